"""The error estimate: dual-weighted residual, Richardson's on two meshes, the straight line to c = 0."""

import types

import numpy as np
import pytest

from flow import error_estimate, recovery

EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)]


def _solved(cells, sampler, mixing=0.0, passed=()):
    space = types.SimpleNamespace(nodes=lambda: (np.zeros((1, 3)), np.zeros((cells, 10), int)))
    problem = types.SimpleNamespace(mixing=mixing, passed=list(passed))
    return types.SimpleNamespace(space=space, problem=problem, sampler=sampler)


@pytest.fixture
def goal(monkeypatch):
    """goal(value): the dual-weighted residual from now on."""

    def gives(value):
        monkeypatch.setattr(error_estimate.goal_error, "of", lambda solved, document, tree: value)

    gives(0.0)
    return gives


def _of(solved, coarser=None):
    return error_estimate.of(solved, None, None, lambda sampler: sampler, coarser)


def test_second_order_error_is_found_exactly(goal):
    exact, factor = 0.75, 0.04  # FFR = exact + factor h^2 with h = 1 and 1/2
    estimate = _of(_solved(8000, exact + factor / 4), _solved(1000, exact + factor))
    assert estimate["ffr"] == pytest.approx(factor / 4)


def test_meshes_that_agree_do_not_hide_the_residual(goal):
    goal(-0.004)
    estimate = _of(_solved(8000, 0.75), _solved(1000, 0.75))
    assert estimate["ffr"] == pytest.approx(0.004 * error_estimate.SAFETY)
    assert estimate["goal_signed"] == -0.004


def test_meshes_of_the_same_size_say_nothing(goal):
    assert _of(_solved(1050, 0.75), _solved(1000, 0.7))["ffr"] == 0.0


def test_remaining_jet_viscosity_is_counted(goal, monkeypatch):
    goal(0.001)
    monkeypatch.setattr(error_estimate.locate, "FieldSampler", lambda space, values: values)
    solved = _solved(1000, 0.75, 0.18, [(0.27, 0.76, 1e-6), (0.18, 0.75, 1e-6)])
    assert _of(solved)["ffr"] == pytest.approx(0.02 + 0.001 * error_estimate.SAFETY)


def test_a_jet_viscosity_without_a_neighbour_says_too_little(goal):
    assert _of(_solved(1000, 0.75, 0.18, [(0.18, 0.75, 1e-6)])) is None


def test_recovery_returns_a_cubic_from_its_nodal_values():
    from scipy.spatial import Delaunay

    rng = np.random.default_rng(3)
    corners = rng.random((60, 3)) * [4.0, 1.0, 1.0]
    cells = Delaunay(corners).simplices
    sides = np.sort(cells[:, EDGES].reshape(-1, 2), axis=1)
    edges, number = np.unique(sides, axis=0, return_inverse=True)
    nodes = np.concatenate([corners, corners[edges].mean(axis=1)])
    ten = np.concatenate([cells, 60 + number.reshape(-1, 6)], axis=1)

    def cubic(x):
        return np.stack([x[:, 0] ** 3 - 2 * x[:, 1] ** 2 * x[:, 2] + 1, x[:, 0] * x[:, 1] * x[:, 2]], axis=1)

    def quadratic(x):
        return (x[:, :1] - x[:, 1:2]) ** 2 + x[:, 2:]

    targets = nodes[ten].mean(axis=1)
    own = np.arange(len(cells))[:, None]
    fields = [(3, ten, cubic(nodes), targets, own), (2, cells, quadratic(nodes), targets, own)]
    velocity, pressure = recovery.Patches(nodes, ten).recover(fields)
    assert np.allclose(velocity, cubic(targets), atol=1e-6)
    assert np.allclose(pressure, quadratic(targets), atol=1e-6)
    assert np.abs(cubic(nodes)[ten].mean(axis=1) - cubic(targets)).max() > 0.01  # the mean of the nodes is not enough
