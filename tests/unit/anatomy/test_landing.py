"""Where stents begin and end."""

import pytest
from narrowed_vessels import measured_vessel, focal, plateau, worst_of

from anatomy.planning import landing, profile, targets
from common.errors import InputError

LENGTHS = [8, 12, 15, 18, 23, 28, 33, 38]


def spans(*narrowings, least=1, **shape):
    target = targets.targets_to_treat(*measured_vessel(*narrowings, **shape))[0]
    return target, landing.stent_spans(target, LENGTHS, "case", least)


def test_a_focal_lesion_takes_the_shortest_stent_with_its_ends_in_normal_lumen():
    target, (span,) = spans(focal(21, 12, 80))
    assert span.length == 12 and span.centre == pytest.approx(21, abs=0.3)
    assert target.profile.stenosis_at([span.start, span.end]) == pytest.approx([0, 0], abs=5.1)


def test_an_end_moves_to_the_healthiest_lumen_within_5_mm():
    """Behind the lesion the vessel is narrowed by 25 % until 28 mm. The stent's end moves past this, to normal
    lumen."""
    target, (span,) = spans(worst_of(focal(21, 12, 80), plateau(21, 28, 25)))
    assert span.end > 27.9 and target.start - span.start >= landing.MARGIN_MM - 0.01
    assert span.end - target.end <= landing.SEARCH_MM


def test_diffuse_disease_beyond_5_mm_is_left():
    target, (span,) = spans(worst_of(focal(21, 12, 84), plateau(21, 44, 25)))
    assert span.length <= 15 and span.end - target.end <= landing.SEARCH_MM


def test_a_dilatation_is_no_landing_zone():
    """Behind the lesion the lumen is up to a third wider than the vessel. The stent ends in the normal lumen before
    that."""
    wide = lambda s: (3.3 - 0.02 * s) * (1 - focal(21, 8, 80)(s) + 0.33 * ((s > 26.5) & (s < 32)))  # noqa: E731
    _, (span,) = spans(focal(21, 8, 80), lumen=wide)
    assert span.end <= 26.5


def test_ends_keep_clear_of_a_mouth():
    _, (span,) = spans(focal(21, 12, 80), sides=((27.0, 1.8),))
    assert not 26.1 < span.end < 27.9


@pytest.mark.parametrize("length, count", [(26, 1), (33, 1), (36, 2), (66, 2), (75, 3), (100, 3)])
def test_stents_in_a_row_where_one_is_too_short(length, count):
    target, row = spans(plateau(12, 12 + length, 70), length=130.0)
    assert len(row) == count
    assert row[-1].start <= target.start - landing.MARGIN_MM + 0.01
    assert row[0].end >= target.end + landing.MARGIN_MM - 0.01
    for distal, proximal in zip(row, row[1:]):
        assert proximal.end - distal.start == pytest.approx(landing.OVERLAP_MM)


def test_at_least_two_if_asked_for():
    _, row = spans(focal(21, 12, 80), least=2)
    assert len(row) == 2 and row[1].start < row[0].start


def test_too_long_for_the_catalogue():
    assert len(spans(plateau(8, 112, 70), length=130.0)[1]) == 3
    with pytest.raises(InputError, match="(?s)no stents of the catalogue are long enough.*3 of 38 mm"):
        spans(plateau(8, 115, 70), length=130.0)


def test_near_an_end_the_margin_is_what_the_branch_has():
    """The stretch begins near the inlet. So the stent begins 1.5 mm behind the inlet, with less than the usual
    margin."""
    target, (span,) = spans(plateau(1.5, 8, 70))
    assert span.start == profile.CAP_MARGIN_MM and target.start - span.start < landing.MARGIN_MM
    assert spans(focal(1.75, 4, 70))[0].s_mla > profile.CAP_MARGIN_MM
    for near in (0.5, 1.25, 48.75):
        with pytest.raises(InputError, match="(?s)too near an end of its branch.*from 1.5 to 48.5 mm of main"):
            spans(focal(near, 4, 70))


def side_branch(shape, ostium):
    """The first target on a vessel that leaves a parent: its sections begin `ostium` mm from the parent's axis."""
    summary, sections = measured_vessel(shape)
    summary["branches"][0]["parent"] = "trunk"
    sections["main"] = [row for row in sections["main"] if row["s_mm"] >= ostium]
    return targets.targets_to_treat(summary, sections)[0]


def test_a_stent_of_a_side_branch_begins_at_its_ostium():
    """The parent is 7 mm wide. A stent that began 1.5 mm from the parent's axis would lie in the parent's lumen."""
    target = side_branch(focal(6, 6, 70), 3.5)
    (span,) = landing.stent_spans(target, LENGTHS, "case")
    assert span.start == 3.5 and span.end > target.end + landing.MARGIN_MM - 0.01
    at_the_ostium = side_branch(focal(3.5, 4, 70), 3.5)
    assert at_the_ostium.s_mla == 3.5 and landing.stent_spans(at_the_ostium, LENGTHS, "case")[0].start == 3.5


def test_a_branch_too_short_for_any_stent():
    with pytest.raises(InputError, match="longer than the branch has room for"):
        spans(focal(5, 4, 70), length=10.9)
    assert spans(focal(5, 4, 70), length=11.1)[1][0].length == 8
