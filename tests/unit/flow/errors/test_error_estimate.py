"""The error estimate from its parts: dual-weighted residual, Richardson extrapolation, artificial viscosity.

Patch recovery, which the dual-weighted residual needs, is tested too.
"""

import types

import numpy as np
import pytest
from scipy.spatial import Delaunay

import tubes
from common.errors import ComputationError
from flow.errors import error_estimate, error_field, recovery
from flow.geometry import centreline

EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)]


def _solved(cells, sampler, artificial=0.0):
    space = types.SimpleNamespace(nodes=lambda: (np.zeros((1, 3)), np.zeros((cells, 10), int)))
    problem = types.SimpleNamespace(artificial_viscosity=artificial)
    return types.SimpleNamespace(space=space, problem=problem, sampler=sampler, outflows=None)


@pytest.fixture
def goal(monkeypatch):
    """goal(*values, artificial) sets the parts of the dual-weighted residual and the part of the artificial viscosity.
    At a second probe all are twice as large."""

    def gives(*values, artificial=0.0):
        parts = np.outer([1.0, 2.0], [*values, artificial])
        monkeypatch.setattr(
            error_estimate.error_field, "solve_error_field", lambda solved, document, tree: (parts, None)
        )

    gives(0.0)
    return gives


def _of(solved, coarser=None):
    """The error estimate at two probes. At the second one FFR is lower by .1 on each mesh."""
    return error_estimate.estimate_error(solved, None, None, lambda sampler: [sampler, sampler - 0.1], coarser)


def test_second_order_error_is_found_exactly(goal):
    exact, factor = 0.75, 0.04  # FFR = exact + factor h^2 with h = 1 and 1/2
    estimate = _of(_solved(8000, exact + factor / 4), _solved(1000, exact + factor))
    assert estimate["ffr"] == pytest.approx(factor / 4)
    assert estimate["probes"] == pytest.approx([factor / 4, factor / 4])


def test_meshes_that_agree_do_not_hide_the_residual(goal):
    goal(-0.004)
    estimate = _of(_solved(8000, 0.75), _solved(1000, 0.75))
    assert estimate["ffr"] == pytest.approx(0.004 * (1 + error_estimate.PART_UNCERTAINTY))
    assert estimate["goal_signed"] == -0.004
    assert estimate["probes"] == pytest.approx(
        [0.004 * (1 + error_estimate.PART_UNCERTAINTY), 0.008 * (1 + error_estimate.PART_UNCERTAINTY)]
    )
    assert estimate["probes"][0] == estimate["ffr"]
    assert "probes" not in error_estimate.shown_entries(estimate) and error_estimate.shown_entries(None) is None


def test_parts_that_cancel_are_not_taken_for_an_exact_answer(goal):
    goal(0.003, -0.004, 0.0)
    estimate = _of(_solved(8000, 0.75))
    assert estimate["goal_signed"] == pytest.approx(-0.001) and estimate["goal_sizes"] == pytest.approx(0.007)
    assert estimate["ffr"] == pytest.approx(0.001 + error_estimate.PART_UNCERTAINTY * 0.007)
    goal(0.003, 0.004)  # the two have one sign, so the estimate is their sum
    assert _of(_solved(8000, 0.75))["ffr"] == pytest.approx(0.007 * (1 + error_estimate.PART_UNCERTAINTY))


def test_stretches_are_a_diameter_long():
    """Stretches follow the diameter of their own branch. No stretch belongs to two branches."""
    wide, narrow = (
        tubes.centre_branch(10.0, lambda s, r=r: r, name=name) for name, r in (("main", 1.25), ("side", 0.5))
    )
    found = error_field.stretch_numbers(centreline.Tree([wide, narrow]))
    first, second = found[: len(wide.s_mm)], found[len(wide.s_mm) :]
    assert [int(np.sum(first == k)) for k in range(4)] == [10] * 4  # points every .25 mm
    assert first.max() == 4 and second.min() == 5 and second.max() == 15
    assert [int(np.sum(second == 5 + k)) for k in range(9)] == [4] * 9


def test_meshes_of_the_same_size_say_nothing(goal):
    assert _of(_solved(1050, 0.75), _solved(1000, 0.7))["ffr"] == 0.0


def test_remaining_artificial_viscosity_is_counted(goal):
    goal(0.001, artificial=-0.02)
    estimate = _of(_solved(1000, 0.75, 0.18))
    assert estimate["ffr"] == pytest.approx(
        0.001 * (1 + error_estimate.PART_UNCERTAINTY) + 0.02 * error_estimate.SAFETY_FACTOR
    )
    assert estimate["probes"][1] == pytest.approx(2 * estimate["ffr"])
    assert estimate["artificial_viscosity"] == pytest.approx(-0.02)
    assert "artificial_viscosity" not in _of(_solved(1000, 0.75))


def test_flows_with_other_artificial_viscosities_are_not_compared(goal):
    goal(0.001)
    same, other = (_of(_solved(8000, 0.75), _solved(1000, 0.7, eps)) for eps in (0.0, 0.02))
    assert same["mesh"] == pytest.approx(0.05 / 3) and same["ffr"] == same["mesh"]
    assert other["ffr"] == pytest.approx(0.001 * (1 + error_estimate.PART_UNCERTAINTY)) and "mesh" not in other


def test_two_meshes_know_nothing_of_an_artificial_viscosity(monkeypatch):
    def no_dual(solved, document, tree):
        raise ComputationError("the solve failed", "dual", "none", "none")

    monkeypatch.setattr(error_estimate.error_field, "solve_error_field", no_dual)
    assert _of(_solved(8000, 0.75), _solved(1000, 0.7))["ffr"] == pytest.approx(0.05 / 3)
    assert _of(_solved(8000, 0.75, 0.02), _solved(1000, 0.7, 0.02)) is None


def _quadratic(corners, cells):
    """(nodes, cells (t, 10)) of the straight tetrahedra (t, 4)."""
    sides = np.sort(cells[:, EDGES].reshape(-1, 2), axis=1)
    edges, number = np.unique(sides, axis=0, return_inverse=True)
    nodes = np.concatenate([corners, corners[edges].mean(axis=1)])
    return nodes, np.concatenate([cells, len(corners) + number.reshape(-1, 6)], axis=1)


def test_recovery_returns_a_cubic_from_its_nodal_values():
    rng = np.random.default_rng(3)
    corners = rng.random((60, 3)) * [4.0, 1.0, 1.0]
    nodes, ten = _quadratic(corners, Delaunay(corners).simplices)

    def cubic(x):
        return np.stack([x[:, 0] ** 3 - 2 * x[:, 1] ** 2 * x[:, 2] + 1, x[:, 0] * x[:, 1] * x[:, 2]], axis=1)

    def quadratic(x):
        return (x[:, :1] - x[:, 1:2]) ** 2 + x[:, 2:]

    targets = nodes[ten].mean(axis=1)
    own = np.arange(len(ten))[:, None]
    patches, every = recovery.Patches(nodes, ten), np.arange(len(ten))
    velocity = patches.recover(3, ten, cubic(nodes), targets, own, every)
    pressure = patches.recover(2, ten[:, :4], quadratic(nodes), targets, own, every)
    assert np.allclose(velocity, cubic(targets), atol=1e-6)
    assert np.allclose(pressure, quadratic(targets), atol=1e-6)
    assert np.abs(cubic(nodes)[ten].mean(axis=1) - cubic(targets)).max() > 0.01  # a mean over the nodes would fail


def test_recovery_does_not_depend_on_how_many_patches_are_fitted_together(monkeypatch):
    corners = np.random.default_rng(3).random((60, 3))
    nodes, ten = _quadratic(corners, Delaunay(corners).simplices)
    random = np.random.default_rng(5)
    values, loads = random.random((2, len(nodes), 2))
    group = random.integers(0, 4, len(nodes))

    def found():
        patches = recovery.Patches(nodes, ten)
        back = patches.recover_transposed([(3, ten, loads, nodes, ten, group)], 4)[0]
        there = patches.recover(3, ten, values, nodes, ten, np.arange(len(ten)))
        return there, *(part.toarray() for part in back)

    together = found()
    monkeypatch.setattr(recovery, "LARGEST_BATCH", 1)
    for alone, with_others in zip(found(), together):
        assert alone == pytest.approx(with_others, rel=1e-9, abs=1e-9 * np.abs(with_others).max())


def test_recovery_on_a_lattice_does_not_amplify_rounded_coordinates():
    corners = np.array([[x, 0.5 * y, 0.3 * z] for x in range(6) for y in range(2) for z in range(2)], float)
    ways = [[0, 4, 6, 7], [0, 4, 5, 7], [0, 2, 6, 7], [0, 2, 3, 7], [0, 1, 5, 7], [0, 1, 3, 7]]  # round a diagonal
    nodes, ten = _quadratic(corners, np.concatenate([4 * x + np.array(ways) for x in range(5)]))
    values = np.sin(2.0 * nodes.sum(axis=1))[:, None]  # nodes have only three values of y and z, too few for a cubic

    def recovered(places):
        targets = places[ten].mean(axis=1)
        every = np.arange(len(ten))
        return recovery.Patches(places, ten).recover(3, ten, values, targets, every[:, None], every)

    rounding = 1e-5 * np.random.default_rng(4).standard_normal(nodes.shape)
    assert np.abs(recovered(nodes + rounding) - recovered(nodes)).max() < 1e-3
