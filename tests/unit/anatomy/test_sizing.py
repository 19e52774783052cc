"""Diameters by the lumen at a stent's ends."""

import numpy as np
import pytest
from narrowed_vessels import measured_vessel, focal, plateau

from anatomy.planning import landing, sizing, targets
from common.errors import InputError


def planned(families, proximal, distal, length=15):
    """The one stent for a focal lesion between two lumens, mm."""
    (target,) = targets.targets_to_treat(
        *measured_vessel(
            focal(21, 8 if length > 12 else 3, 80), healthy=lambda s: proximal + (distal - proximal) * (s > 21)
        )
    )
    return sizing.size_stents(target.profile, landing.stent_spans(target, [length], "case"), families, "case")[0]


@pytest.mark.parametrize(
    "proximal, distal, size",
    [
        (3.3, 2.9, 3.0),  # rounded up
        (3.0, 3.0, 3.0),
        (3.6, 2.7, 3.0),  # the 2.75 mm design ends at 3.5 mm
        (4.4, 4.1, 4.5),
        (5.0, 4.9, 4.5),  # the largest; its design opens to 5.7 mm
        (2.0, 1.8, 2.25),
        (2.0, 1.76, 2.25),
        (5.69, 5.69, 4.5),
        (4.39, 2.8, 3.0),  # as far as its design opens
    ],
)
def test_stent_by_the_distal_lumen(families, proximal, distal, size):
    stent = planned(families, proximal, distal)
    assert stent.diameter == size and (stent.proximal_reference, stent.distal_reference) == pytest.approx(
        (proximal, distal)
    )


@pytest.mark.parametrize(
    "proximal, distal, what",
    [
        (2.0, 1.74, "no stent diameter.*1.74 mm, stents of 2.25 to 4.5 mm"),
        (1.3, 1.3, "no stent diameter.*check the file's units"),
        (6.0, 5.72, "no stent diameter.*check the file's units"),
        (4.42, 2.7, "two overlapping stents"),
        (4.6, 2.3, "two overlapping stents"),
    ],
)
def test_what_the_catalogue_cannot_hold(families, proximal, distal, what):
    with pytest.raises(InputError, match=f"(?s){what}"):
        planned(families, proximal, distal)


def test_balloon_before_is_by_the_distal_reference(families):
    stent = planned(families, 3.3, 2.9)
    assert sizing.predilatation(families, stent, 10.0, "case") == (3.0, 12)
    assert sizing.predilatation(families, stent, 40.0, "case") == (3.0, 15)  # not beyond the stent


def test_balloon_after_reaches_the_proximal_reference(families):
    stent = planned(families, 3.3, 2.9)
    diameter, length, centre, (wanted, _) = sizing.postdilatation(families, stent, "case")
    assert (diameter, length, centre) == (3.25, 15, stent.span.centre) and wanted == pytest.approx(3.3)


def test_tapered_vessel_is_postdilated_in_its_proximal_part(families):
    stent = planned(families, 3.9, 2.9)
    diameter, length, centre, _ = sizing.postdilatation(families, stent, "case")
    assert diameter == 4.0 and length <= 7.5 and centre - length / 2 == pytest.approx(stent.span.start)


def test_a_short_stent_in_a_tapered_vessel_is_dilated_whole_by_what_its_distal_end_bears(families):
    """Half of an 8 mm stent is shorter than the shortest balloon, 6 mm. This happened in a real artery with an
    intramural course."""
    stent = planned(families, 3.9, 2.9, length=8)
    diameter, length, centre, (wanted, _) = sizing.postdilatation(families, stent, "case")
    assert (diameter, length, centre) == (3.25, 8, stent.span.centre) and wanted == pytest.approx(3.4)


def test_post_dilatation_does_not_overstretch_the_distal_reference(families):
    """The two references differ by 0.48 mm only. But the balloon nearest to the proximal reference is 0.59 mm wider
    than the distal one."""
    diameter, length, *_ = sizing.postdilatation(families, planned(families, 3.64, 3.16), "case")
    assert diameter == 3.5 and length == 15


def test_between_two_stents_the_vessels_reference_counts(families):
    (target,) = targets.targets_to_treat(
        *measured_vessel(plateau(10, 50, 70), length=70.0, healthy=lambda s: 4.0 - 0.02 * s)
    )
    distal, proximal = sizing.size_stents(target.profile, landing.stent_spans(target, [28], "case"), families, "case")
    joint = 0.5 * (proximal.span.end + distal.span.start)
    assert distal.proximal_reference == proximal.distal_reference == pytest.approx(4.0 - 0.02 * joint, abs=1e-3)


def test_post_dilatation_does_not_open_a_stent_beyond_its_design(families):
    """The proximal reference is 4.3 mm, and the nearest balloon 4.5 mm. But the 3.0 mm stent opens to 4.4 mm only."""
    diameter, _, _, (_, most) = sizing.postdilatation(families, planned(families, 4.3, 2.9), "case")
    assert diameter == 4.0 and most == 4.4


def test_in_a_row_the_balloon_ends_before_a_stent_that_it_would_over_expand(families):
    """The distal stent of 2.75 mm opens to 3.5 mm; the vessel is 3.75 mm wide at the proximal stent's beginning."""
    taper = {"length": 70.0, "healthy": lambda s: np.interp(s, [8, 30, 53], [3.75, 3.35, 2.7])}
    (target,) = targets.targets_to_treat(*measured_vessel(plateau(10, 50, 70), **taper))
    distal, proximal = sizing.size_stents(target.profile, landing.stent_spans(target, [28], "case"), families, "case")
    assert (distal.diameter, distal.limit, proximal.distal_limit) == (2.75, 3.5, 3.5)
    diameter, length, centre, _ = sizing.postdilatation(families, proximal, "case")
    assert diameter == 3.75 and length > 15 and centre + length / 2 <= distal.span.start


@pytest.mark.parametrize(
    "distal, balloon",
    [
        (1.74, ("semi_compliant", 1.5)),
        (1.43, ("semi_compliant", 1.5)),  # 1.05 of the lumen
        (1.42, None),
        (5.8, ("non_compliant", 5.5)),
        (6.87, ("non_compliant", 5.5)),  # 0.8 of it
        (6.88, None),
    ],
)
def test_a_balloon_alone_is_as_wide_as_the_lumen(families, distal, balloon):
    (target,) = targets.targets_to_treat(*measured_vessel(focal(21, 8, 80), healthy=lambda s: distal + 0 * s))
    found = sizing.balloon_alone(families, target, "case")
    if balloon is None:
        assert found is None
    else:
        (device,) = found["devices"]
        assert found["action"] == "predilatation" and (device["device"], device["diameter_mm"]) == balloon
        assert (device["length_mm"], device["centre_s_mm"]) == (12, 21)  # a stretch of 4.5 mm, and 2 mm past its ends
        assert device["pressure_bar"] == {1.43: 8, 1.74: 14}.get(distal, 20)


def test_a_balloon_alone_stays_inside_its_branch(families):
    (target,) = targets.targets_to_treat(*measured_vessel(plateau(1.5, 7.5, 80), healthy=lambda s: 1.6 + 0 * s))
    (device,) = sizing.balloon_alone(families, target, "case")["devices"]
    assert device["centre_s_mm"] == 7.5 and device["length_mm"] == 12
