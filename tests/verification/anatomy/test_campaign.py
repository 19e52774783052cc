"""What the campaign counts as right: throats of equal width count as one place, and errors within a stated band are
allowed."""

import json

import campaign_truth
import drawn_patient
import numpy as np
import pytest


def drawn(second):
    """A patient with throats of 60 and `second` per cent at 10 and 18 mm of one lesion."""
    s = np.linspace(0, 30, 301)
    narrowed = sum(p / 100 * np.exp(-((s - at) ** 2)) for p, at in ((60, 10), (second, 18)))
    patient = object.__new__(drawn_patient.Patient)
    lesion = {"true_diameter_stenosis_percent": 60.0, "true_s_mla_mm": 10.0, "centre_s_mm": 14.0, "length_mm": 16.0}
    patient.truth = {"branches": [{"lesions": [lesion]}]}
    along = np.column_stack([s, 0 * s, 0 * s])
    patient.branches = [{"s_mm": s, "points_mm": along, "radius_mm": 2 - 2 * narrowed, "healthy_radius_mm": 2 + 0 * s}]
    return patient


@pytest.mark.parametrize("second, alike", [(59, True), (50, False)])
def test_throats_of_one_width_are_one_place(second, alike):
    places, least, most = drawn(second).lesion()
    assert np.abs(places[:, 0] - 10).min() < 0.1 and least == most == 60
    assert (np.abs(places[:, 0] - 18).min() < 0.1) == alike
    assert np.abs(places[:, 0] - 14).min() > 1


def test_a_stated_band_is_that_of_the_area():
    """If a quarter of a vessel's area is lost, its true diameter is 15.5 per cent larger than it seems."""
    lesion = {"mla_error_percent": 25, "diameter_stenosis_percent": 70}
    assert campaign_truth.stated_error_percent(lesion) == pytest.approx(4.64, abs=0.01)
    assert campaign_truth.stated_error_percent(lesion | {"mla_error_percent": 0}) == 0


def test_false_stubs_are_counted(tmp_path):
    said = [{"what": "stub left closed", "count": 1}, {"what": "caps flattened", "count": 6}]
    (tmp_path / "anatomy.json").write_text(json.dumps({"repairs": said}))
    assert campaign_truth.false_stubs(tmp_path) == 1
