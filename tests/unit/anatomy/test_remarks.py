"""What is said about a proposed plan."""

import json

import pytest
from narrowed_vessels import measured_vessel, focal, plateau, worst_of

from anatomy.planning import plan, proposal, remarks


def said(families, *narrowings, treat="culprit", **shape):
    summary, sections = measured_vessel(*narrowings, **shape)
    return remarks.of_proposal(summary, proposal.propose(summary, sections, families, "case", treat))


def test_nothing_where_nothing_is_left_open(families):
    assert said(families, focal(21, 12, 64)) == []


@pytest.mark.parametrize(
    "narrowing, words",
    [
        (focal(21, 12, 44), "44.0 % only"),
        (plateau(2.0, 9.0, 60), "mm past lesion1 at its proximal end"),
        (plateau(41.0, 48.0, 60), "mm past lesion1 at its distal end"),
    ],
)
def test_lesion_that_is_mild_or_near_an_end(families, narrowing, words):
    assert [words in remark for remark in said(families, narrowing)] == [True]


near_begin, near_end = worst_of(plateau(-1, 8, 58), focal(4, 3, 62)), plateau(42, 50, 60)


@pytest.mark.parametrize(
    "narrowing, words",
    [
        (near_begin, "within 1.5 mm of the vessel's cut begin. The first 1.5 mm, narrowed by up to 58 %, stay"),
        (near_end, "within 1.5 mm of the vessel's cut end. The last 1.5 mm, narrowed by up to 60 %, stay"),
        (plateau(2.0, 8.0, 60), "of the vessel's cut begin. Give a longer lumen, with the left main or the aorta"),
    ],
)
def test_a_lesion_that_reaches_to_a_cut_end_is_told_with_its_remedy(families, narrowing, words):
    """Formerly the remark said that the branch begins there, and that no better lumen lies within 5 mm."""
    found = said(families, narrowing)
    assert [words in remark for remark in found].count(True) == 1
    assert not any("hold no better" in remark or "the branch begins" in remark for remark in found)


def test_short_stent_that_a_balloon_cannot_open_to_its_proximal_end(families):
    taper = {"healthy": lambda s: 3.6 - 0.7 * (s > 21)}
    words = "8 mm stent at lesion1 is too short for a balloon in its proximal part"
    assert any(words in remark for remark in said(families, focal(21, 3, 80), **taper))
    assert not any(words in remark for remark in said(families, focal(21, 12, 64), **taper))


def test_lesion_that_is_left(families):
    two = focal(12, 8, 75), focal(40, 8, 58)
    (remark,) = said(families, *two)
    assert "lesion2 (58 % on main at 40.0 mm) is left as it is: the plan treats lesion1 alone" in remark
    assert said(families, *two, treat="all") == []
    assert said(families, focal(12, 8, 75), focal(40, 8, 45)) == []


def test_balloon_alone(families):
    (remark,) = said(families, focal(21, 12, 64), healthy=lambda s: 6.36 + 0 * s)
    assert "lesion1 takes a balloon alone, of 5.5 mm: no stent diameter" in remark and "6.36 mm" in remark


def test_lesion_that_cannot_be_treated_says_why(families):
    two = focal(12, 8, 75), focal(44, 6, 60)
    taper = {"healthy": lambda s: 3.3 - 0.9 * (s > 30) - 1.1 * (s > 38)}
    (remark,) = said(families, *two, treat="all", **taper)
    assert "lesion2" in remark and "no stent diameter of the catalogue fits the vessel" in remark


@pytest.mark.parametrize("middle, width, words", [(21.0, 2.2, "lies across side1 (2.2 mm wide)"), (35.0, 2.2, None)])
def test_side_branch_at_the_stent(families, middle, width, words):
    found = said(families, focal(21, 12, 64), sides=((middle, width),))
    assert [words in remark for remark in found] == [True] if words else found == []


def test_end_in_a_mouth_that_no_length_avoids(families):
    found = said(families, focal(21, 12, 64), sides=((30.0, 12.0),))
    assert any("ends in the mouth of side1 (24.0 to 36.0 mm)" in remark for remark in found)


def test_diffuse_disease_that_is_left(families):
    found = said(families, worst_of(focal(14, 10, 84), plateau(14, 45, 25)), length=60.0)
    assert any("diffuse narrowing by up to 25 %" in remark and "to 44." in remark for remark in found)
    assert any("lumen is up to 25 % off the reference" in remark for remark in found)
    short = said(families, worst_of(focal(14, 10, 84), plateau(14, 25, 25)), length=60.0)
    assert not any("diffuse" in remark for remark in short)


def test_several_stents(families):
    assert any("2 stents that overlap by 2.5 mm" in one for one in said(families, plateau(10, 52, 70), length=70.0))


def test_a_vessel_wider_than_the_largest_stent(families):
    found = said(families, focal(21, 12, 64), healthy=lambda s: 4.9 + 0 * s)
    assert any("is 4.90 mm wide, the largest stent 4.50 mm" in remark for remark in found)


def test_the_command_says_them(run_module, repo_root, written, tmp_path):
    folder, case = written(*measured_vessel(focal(21, 12, 34))), repo_root / "config" / "cases" / "real_artery.yaml"
    done = run_module("anatomy", "plan", case, "--anatomy", folder, "--out", tmp_path / "plan.json")
    assert done.returncode == 0 and "warning: " in done.stderr and "34.0 % only" in done.stderr
    (kept,) = json.loads((tmp_path / "plan.json").read_text())["reference"]["remarks"]
    assert kept in done.stderr


def test_a_device_far_wider_than_the_vessel_is_named(families):
    """A vessel of 3 mm: 4 mm is within the ratio of 1.4, 4.5 mm is not."""
    summary, sections = measured_vessel(healthy=lambda s: 3.0 + 0 * s)
    found = []
    for diameter in (4.0, 4.5):
        device = {"device": "des", "diameter_mm": diameter, "length_mm": 18, "lesion": 1, "pressure_bar": 11}
        listed = plan.procedure([{"action": "stent", "devices": [device]}], families, summary, "case")
        found.append(list(remarks.of_device_sizes(listed, sections)))
    assert found == [[], ["stent: des_4.50x18 is 4.50 mm wide, 1.5 times the healthy vessel there (3.00 mm)"]]
