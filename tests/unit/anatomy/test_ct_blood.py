"""The CT number of the blood changes along the vessel. The level at which edges are read must follow it."""

import ct_vessels
import numpy as np
import pytest

from anatomy.ct import segment
from anatomy.ct.rays import blood, edges

S = np.linspace(0, 40, 161)
ALL = np.ones(len(S), bool)


@pytest.mark.parametrize("method, off", [("psf_edge", 0.03), ("half_maximum", 0.06), ("threshold", 0.06)])
@pytest.mark.parametrize("reverse", [False, True])
def test_a_vessel_keeps_its_radius_where_the_contrast_falls(method, off, reverse):
    """The contrast falls by 120 HU of 400. With one level for the whole vessel, the brighter third was taken for
    calcium, and the lumen had half its radius."""
    image = ct_vessels.image(falls=120.0)
    found = segment.segment(image, ct_vessels.ends(reverse), ct_vessels.settings(method=method))
    tube = found["tubes"][0]
    for third in np.array_split(tube.radius(tube.s_mm), 3):
        assert third.mean() == pytest.approx(ct_vessels.RADIUS_MM, abs=off)
    assert [w["code"] for w in found["warnings"]] == []
    assert not any(met.any() for met, _, _ in found["bright"])
    level = found["lines"][0].blood(tube.s_mm[[0, -1]])
    assert sorted(level) == pytest.approx([281, 399], abs=12)


def test_a_vessel_that_is_narrow_over_most_of_its_length_is_not_too_noisy():
    """Blur lowers the CT number on the axis of the narrow part. This must count neither as darker blood nor as
    noise."""
    found = segment.segment(ct_vessels.image(narrow_mm=0.65), ct_vessels.ends(), ct_vessels.settings())
    tube = found["tubes"][0]
    assert tube.radius(np.array([12.0, 20.0, 28.0])) == pytest.approx(0.65, abs=0.05)
    assert tube.radius(np.array([4.0, 36.5])) == pytest.approx(ct_vessels.RADIUS_MM, abs=0.05)
    assert found["lines"][0].blood(tube.s_mm) == pytest.approx(400, abs=12)


def test_the_level_that_is_contoured_follows_the_blood():
    """The level is half-way between the blood at this place and the tissue. So the fainter end is not found thinner."""
    found = segment.segment(ct_vessels.image(falls=120.0), ct_vessels.ends(), ct_vessels.settings(method="threshold"))
    for z in (3.0, 37.0):
        x = np.linspace(1.0, 2.2, 121)
        value = found["field"].value(np.stack([x, 0 * x, 0 * x + z], axis=1))
        assert x[np.argmax(value > 0)] == pytest.approx(ct_vessels.RADIUS_MM, abs=0.15)


def test_lesions_and_calcium_do_not_bend_the_trend():
    hu = 400 - 3 * S
    disturbed = np.where((S > 2) & (S < 8), hu + 300, np.where((S > 24) & (S < 30), hu - 200, hu))
    found = blood.fit_trend(S, disturbed, ALL, None)
    assert found(S) == pytest.approx(hu, abs=8)
    # the line is continued to the ends
    assert blood.fit_trend(S, hu, (S > 12) & (S < 30), None)(S) == pytest.approx(hu, abs=2)


def test_a_long_vessel_may_fall_faster_in_a_part():
    s = np.linspace(0, 120, 481)
    hu = np.where(s < 60, 400 - 0.5 * s, 370 - 2.5 * (s - 60))
    assert blood.fit_trend(s, hu, np.ones(len(s), bool), None)(s) == pytest.approx(hu, abs=20)


def test_few_wide_sections_give_a_constant_and_none_the_parents_level():
    parent = blood.Trend(0.0, 300.0)
    assert blood.fit_trend(S, 0 * S, S < 1.5, parent) is parent
    assert blood.fit_trend(S, 400 - 3 * S, S < 14.0, parent)(S) == pytest.approx(379, abs=1)


def test_levelling_changes_the_blood_and_not_the_wall():
    hu = np.full((161, 4, 3), edges.HEALTHY_WALL_HU)
    hu[:, :, 0] = (400 - 4 * S)[:, None]
    flat = blood.level_contrast(
        edges.Profiles(S, np.arange(4), np.arange(3), hu, hu[:, 0, 0]), blood.Trend(S, hu[:, 0, 0]), 320
    )
    assert flat.hu[:, :, 0] == pytest.approx(320) and flat.axis_hu == pytest.approx(320)
    assert flat.hu[:, :, 1:] == pytest.approx(edges.HEALTHY_WALL_HU)
    assert flat.sections_from(40).gain == pytest.approx(270 / (350 - 4 * S[40:]))


@pytest.mark.parametrize("top, smoothing", [(300.0, 0.0), (240.0, 0.0), (300.0, 0.5)])
def test_blood_cut_off_by_a_window_is_warned_of(top, smoothing):
    image = ct_vessels.image()
    image.values = np.clip(image.values, -160, top)
    settings = ct_vessels.settings(smoothing_fwhm_mm=smoothing)
    said = [w for w in segment.segment(image, ct_vessels.ends(), settings)["warnings"] if w["code"] == "saturated"]
    assert len(said) == 1 and said[0]["value"] == top and "without a window" in said[0]["message"]
    assert said[0]["s_end_mm"] - said[0]["s_start_mm"] > 36


@pytest.mark.parametrize("smoothing", [0.0, 0.7])
def test_an_assumed_point_spread_includes_the_smoothing(monkeypatch, smoothing):
    """No section is wide enough to measure the point spread. Assumed are 0.7 mm of the scanner, plus the smoothing."""
    monkeypatch.setattr(edges, "point_spread", lambda *given: None)
    settings = ct_vessels.settings(smoothing_fwhm_mm=smoothing)
    found = segment.segment(ct_vessels.image(), ct_vessels.ends(), settings)
    assert found["sigma_mm"] * np.sqrt(8 * np.log(2)) == pytest.approx(np.hypot(0.7, smoothing))


def test_calcium_cut_off_is_none_of_the_bloods():
    """A display window that ends above the blood does not move the edge. Single voxels of blood at its upper limit do
    not either."""
    image = ct_vessels.image()
    image.values = np.clip(image.values, -160, 420)
    found = segment.segment(image, ct_vessels.ends(), ct_vessels.settings())
    assert [w["code"] for w in found["warnings"]] == []
