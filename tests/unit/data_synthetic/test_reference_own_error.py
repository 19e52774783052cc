"""The reference's own error, from an area whose errors are known."""

import numpy as np
import pytest

from data_synthetic.reference import own_error, run

STEP, MESH = 0.02, 0.08  # error of the area per mm of load step, and of one element
SETTINGS = {"radius_step_mm": 0.2, "check_slices": 3}


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
    found = own_error.estimate(records(13), SETTINGS, measured)
    assert len(found["slices"]) == 3 and found["slices"][0]["s_mm"] == 1.0, "the tightest first"
    assert found["step_area_percent"] == pytest.approx(100 * (1.004 / 1.002 - 1))
    assert found["mesh_area_percent"] == pytest.approx(100 * (1.08 / 1.04 - 1))
    assert found["mesh_and_step_area_percent"] == pytest.approx(100 * (1.004 * 1.08 / 1.002 / 1.04 - 1))


def test_spacing_is_the_curvature_of_the_area():
    found = own_error.estimate(records(61), SETTINGS, measured)["spacing_area_percent"]
    # linear interpolation over 2 h misses h^2 / 2 |A''|, here at most 0.01 / 2 of an area of 7
    assert found["largest"] == pytest.approx(100 * 0.5 * 0.1**2 / 7, rel=0.05)
    assert found["mean"] < found["largest"]


def test_no_check_asked_for():
    found = own_error.estimate(records(4), dict(SETTINGS, check_slices=0), measured)
    assert found == {"slices": []}


def test_a_coarser_reference_says_so():
    default = run.load_settings(None)
    assert run._coarser(default) == {}
    coarse = default | {"slice_spacing_mm": 1.0, "elements_around": 16, "radius_step_mm": 0.05, "elements_through": 9}
    assert run._coarser(coarse) == {"slice_spacing_mm": [1.0, 0.75], "elements_around": [16, 24]}
