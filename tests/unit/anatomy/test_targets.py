"""What is treated: the stretch of significant narrowing, with neighbours too near for a landing zone."""

import pytest
from narrowed_vessels import focal, plateau, worst_of

from anatomy.planning import targets
from anatomy.planning.profile import Profile


def found(vessel, *narrowings, **shape):
    return targets.targets_to_treat(*vessel(*narrowings, **shape))


def test_a_stretch_ends_where_the_narrowing_falls_below_30_percent(vessel):
    (target,) = found(vessel, focal(21, 12, 80))
    assert target.start == pytest.approx(21 - 3.5, abs=0.3) and target.end == pytest.approx(21 + 3.5, abs=0.3)


def test_a_mild_lesion_is_covered_to_half_its_narrowing(vessel):
    (target,) = found(vessel, plateau(15, 25, 20))
    assert target.start == pytest.approx(15.25, abs=0.26) and target.end == pytest.approx(24.75, abs=0.26)


@pytest.mark.parametrize("percent, end", [(25, 27.7), (29, 27.7), (31, 43.8)])
def test_mild_disease_behind_a_severe_lesion_is_left(vessel, percent, end):
    """A lesion of 84 % continues as a long, milder narrowing. Up to 29 % the stent does not cover it; from 31 % it
    does."""
    (target,) = found(vessel, worst_of(focal(24, 12, 84), plateau(24, 44, percent)))
    assert target.end == pytest.approx(end, abs=0.4) and target.start == pytest.approx(20.3, abs=0.4)


def test_significant_lesions_only_or_all_where_there_is_none(vessel):
    three = focal(12, 8, 60), focal(30, 8, 75), focal(43, 8, 40)
    assert [target.name for target in found(vessel, *three)] == ["lesion1", "lesion2"]
    assert [target.percent for target in found(vessel, focal(12, 8, 30), focal(20, 6, 45))] == pytest.approx([45, 30])


def test_lesions_of_what_the_case_asks_for(vessel):
    three = vessel(focal(12, 8, 60), focal(30, 8, 75), focal(43, 8, 40))
    assert [target.name for target in targets.targets_to_treat(*three, 70)] == ["lesion1"]
    assert [target.percent for target in targets.targets_to_treat(*three, 39)] == pytest.approx([75, 60, 40], abs=0.1)
    assert targets.targets_to_treat(*three, 80) == [] and len(targets.all_targets(*three)) == 3


@pytest.mark.parametrize("second, together", [(27.5, True), (30.0, False)])
def test_lesions_without_a_landing_zone_between_are_one(vessel, second, together):
    """The vessel is 3 mm wide. The two stretches are 4 mm long, with 7.3 or 9.8 mm between them."""
    targets_found = found(vessel, focal(16, 8, 60), focal(second, 8, 70))
    assert (len(targets_found) == 1) == together
    assert targets_found[0].percent == pytest.approx(70, abs=0.3)
    assert targets_found[0].s_mla == pytest.approx(second, abs=0.2)


def test_a_mild_neighbour_is_no_part_of_it(vessel):
    (target,) = found(vessel, focal(16, 8, 70), focal(24, 8, 45))
    assert target.name == "lesion1" and target.end < 20


def test_lumen_beyond_an_end_leaves_out_mouths(vessel):
    lumens = {"healthy": lambda s: 3 + 0 * s, "lumen": lambda s: 3 + 0 * s + (abs(s - 20) < 1)}
    summary, sections = vessel(focal(15, 8, 70), sides=((20.0, 2.0),), **lumens)
    profile = Profile(summary, sections, "main")
    assert profile.reference_lumen_mm(18.0, 1) == pytest.approx(3.0)
    assert profile.reference_lumen_mm(19.5, 1) == pytest.approx(3.0) and profile.mouth_at(19.5) == "side1"


@pytest.mark.parametrize("share, told", [(1.0, 3.0), (0.9, 2.7), (0.7, 2.55), (1.8, 3.15)])
def test_diseased_or_dilated_lumen_does_not_tell_the_vessels_size(vessel, share, told):
    summary, sections = vessel(focal(15, 8, 70), healthy=lambda s: 3 + 0 * s, lumen=lambda s: share * 3 + 0 * s)
    assert Profile(summary, sections, "main").reference_lumen_mm(30, 1) == pytest.approx(told)
