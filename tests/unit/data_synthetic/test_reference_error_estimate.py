"""The estimate of the reference's own error, on slices whose errors are known."""

import numpy as np
import pytest

from common.documents import config
from data_synthetic.reference import run
from data_synthetic.reference.slices import error_estimate, lumen

STEP, MESH = 0.02, 0.08  # relative errors of the area: per mm of load step, at mesh refinement 1
SETTINGS = {"radius_step_mm": 0.2, "check_slices": 3, "edge_decay_mm": 0.0}
SPAN = [(0.0, 6.0)]


def area(s_mm):
    return 8.0 + np.sin(s_mm)


def measured(refinement, settings, s_mm, stented):
    assert stented
    return area(s_mm) * (1 + STEP * settings["radius_step_mm"]) * (1 + MESH / refinement)


def records(count):
    s = np.linspace(0, 6, count)
    radius = 0.5 + 0.1 * np.abs(s - s[2])
    return [
        {"s_mm": float(x), "stented": True, "radius_before_mm": float(r), "area_mm2": measured(1, SETTINGS, x, True)}
        for x, r in zip(s, radius)
    ]


def test_mesh_and_step_are_told_apart():
    found = error_estimate.estimate(records(13), SPAN, SETTINGS, measured)
    assert len(found["slices"]) == 3 and found["slices"][0]["s_mm"] == 1.0, "the tightest first"
    assert found["step_area_percent"] == pytest.approx(100 * (1.004 / 1.002 - 1))
    assert found["mesh_area_percent"] == pytest.approx(100 * (1.08 / 1.04 - 1))
    assert found["mesh_and_step_area_percent"] == pytest.approx(100 * (1.004 * 1.08 / 1.002 / 1.04 - 1))


def test_spacing_is_the_curvature_of_the_area():
    coarse, fine = (
        error_estimate.estimate(records(n), SPAN, SETTINGS, measured)["spacing_area_percent"] for n in (31, 61)
    )
    # The slice at an extremum is left out. The cubic through its neighbours, h away, is flat there: it misses the area
    # of 7 by h^2 / 2 |A''|, and |A''| is 1.
    for found, h in ((coarse, 0.2), (fine, 0.1)):
        assert 0.5 < found["largest"] / (100 * 0.5 * h**2 / 7) < 1.05
        assert 0 < found["mean"] < found["largest"]
    assert (
        2.5 < coarse["largest"] / fine["largest"] < 5.5
    )  # 4 by second order; the extremum's place between slices changes it


def test_two_stents_are_looked_at_one_by_one():
    """Between two stents the area jumps. That is no error by the spacing within either."""
    first = records(31)
    second = [dict(one, s_mm=one["s_mm"] + 20, area_mm2=2 * one["area_mm2"]) for one in first]
    spans = [*SPAN, (20.0, 26.0)]
    both, alone = (
        error_estimate.estimate(found, spans, SETTINGS, lambda *_: 1.0)["spacing_area_percent"]
        for found in (first + second, first)
    )
    assert both["largest"] == pytest.approx(alone["largest"], rel=1e-6)
    assert both["mean"] == pytest.approx(alone["mean"], rel=1e-6)


def test_a_straight_line_is_not_missed():
    s = np.array([0.0, 0.7, 1.0, 2.5, 3.0])
    assert error_estimate.leave_one_out_change(s, np.pi * (3 + 2 * s) ** 2, 0.6) == pytest.approx(0, abs=1e-9)


def test_no_check_asked_for():
    found = error_estimate.estimate(records(4), SPAN, dict(SETTINGS, check_slices=0), measured)
    assert found == {"slices": []}


def test_a_coarser_reference_says_so():
    default = config.load_section(None, "reference")
    assert run._coarser_settings(default) == {}
    coarse = default | {"slice_spacing_mm": 1.0, "elements_around": 16, "radius_step_mm": 0.05, "elements_through": 9}
    assert run._coarser_settings(coarse) == {"slice_spacing_mm": [1.0, 0.75], "elements_around": [16, 24]}


def test_slices_are_added_where_the_area_bends_sharply():
    """A balloon's end leaves a kink in the area. Slices are added at the kink and nowhere else."""
    kink, even, settings = 11.3, np.linspace(6, 18, 17), config.load_section(None, "reference")

    def bent(s_mm):
        return 8.0 + 2.0 * np.maximum(s_mm - kink, 0.0)

    found = lumen.refined(even, lambda s: (np.full((4, 2), bent(s)), bent(s)), settings)
    held = np.array(list(found))
    added = held[np.abs(held[:, None] - even).min(axis=1) > 1e-9]
    assert np.all(np.diff(held) > 0) and 2 <= len(added) <= 8 and np.abs(added - kink).max() < 1.2
    tolerance, coupling = settings["slice_tolerance_percent"], settings["edge_decay_mm"]
    assert error_estimate.leave_one_out_change(even, bent(even), coupling).max() > tolerance
    assert error_estimate.leave_one_out_change(held, bent(held), coupling).max() <= tolerance
