"""The plan: devices in full, placed on the measured lumen, within what catalogue and stent allow."""

import json

import pytest

from anatomy import catalogue, plan, sizing
from common.errors import InputError


def wish(device="des", diameter=3.0, length=15, pressure=11, **place):
    size = {"diameter_mm": diameter, "length_mm": length, "pressure_bar": pressure}
    return {"device": device, "branch": "main", **size, **(place or {"lesion": 1})}


def stent_step(**changes):
    return [{"action": "stent", "devices": [wish(**changes)]}]


def test_stent_comes_with_its_delivery_balloon(families, summary):
    done = plan.procedure(stent_step(), families, summary, "case")
    stent = done["devices"]["des_3.00x15"]
    balloon = done["devices"][stent["balloon"]]
    assert stent["kind"] == "stent" and stent["maximal_diameter_mm"] == 4.4 and stent["crowns"] == 8
    assert balloon["kind"] == "balloon" and catalogue.diameter_at(balloon, 11) == pytest.approx(3.0)
    assert done["procedure"][0]["devices"][0]["centre_s_mm"] == 21.0
    assert done["segment"] == {"branch": "main", "s_start_mm": 13.5, "s_end_mm": 28.5}


def test_segment_covers_all_stents_of_the_branch(families, summary):
    steps = stent_step(centre_s_mm=15) + stent_step(centre_s_mm=28)
    done = plan.procedure(steps, families, summary, "case")
    assert (done["segment"]["s_start_mm"], done["segment"]["s_end_mm"]) == (7.5, 35.5)
    assert [step["name"] for step in done["procedure"]] == ["stent", "stent_2"]


def test_device_of_a_side_branch_may_begin_in_the_parent(families, summary):
    done = plan.procedure(stent_step(branch="side1", centre_s_mm=1), families, summary, "case")
    assert done["segment"] == {"branch": "side1", "s_start_mm": -6.5, "s_end_mm": 8.5}


@pytest.mark.parametrize(
    "steps, what",
    [
        (stent_step(device="unknown"), "no such device family"),
        (stent_step(diameter=3.1), "size not in the catalogue"),
        (stent_step(length=16), "size not in the catalogue"),
        (stent_step(pressure=17), "rated burst pressure"),
        (stent_step(lesion=2), "no such lesion"),
        (stent_step(branch="side4", centre_s_mm=5), "no such branch"),
        (stent_step(centre_s_mm=5), "beyond its branch"),
        (stent_step(centre_s_mm=45), "beyond its branch"),
        (stent_step(branch="side1", centre_s_mm=2), "beyond its branch"),
        (stent_step(branch="side1", centre_s_mm=-13), "beyond its branch"),
        (stent_step(device="semi_compliant"), "wrong kind"),
        ([{"action": "predilatation", "devices": [wish()]}], "wrong kind"),
        (
            stent_step(diameter=2.25) + [{"action": "postdilatation", "devices": [wish("non_compliant", 3.5, 12, 20)]}],
            "over-expand",
        ),
    ],
)
def test_refusals(families, summary, steps, what):
    with pytest.raises(InputError, match=what):
        plan.procedure(steps, families, summary, "case")


def test_balloon_away_from_the_stent_may_be_larger(families, summary):
    away = {"action": "postdilatation", "devices": [wish("non_compliant", 3.5, 12, 20, centre_s_mm=40)]}
    steps = stent_step(diameter=2.25, centre_s_mm=15) + [away]
    assert len(plan.procedure(steps, families, summary, "case")["procedure"]) == 2


def test_proposed_plan_follows_the_sizing_rules(families, summary):
    steps = sizing.propose(summary, families, "case")
    pre, stent, post = (step["devices"][0] for step in steps)
    assert stent["diameter_mm"] == 3.0  # 2.9 rounded up
    assert stent["length_mm"] == 15  # 10 mm and two margins
    assert pre["diameter_mm"] == 2.75 and pre["length_mm"] == 12  # not above the distal reference, covers the lesion
    assert post["diameter_mm"] == 3.25 and post["length_mm"] == 15
    assert pre["pressure_bar"] == 8 and stent["pressure_bar"] == 11
    assert 12 <= post["pressure_bar"] <= 20
    assert {d["centre_s_mm"] for d in (pre, stent, post)} == {21.0}
    assert plan.procedure(steps, families, summary, "case")["segment"]["s_end_mm"] == 28.5


def test_proposed_stent_stays_in_its_branch(families, summary):
    summary["lesions"][0].update(s_start_mm=2.0, s_end_mm=10.0)
    stent = sizing.propose(summary, families, "case")[1]["devices"][0]
    assert stent["centre_s_mm"] == sizing.EDGE_MM + stent["length_mm"] / 2


def test_nothing_to_propose(families, summary):
    with pytest.raises(InputError, match="no lesion.*(?s:.*)no healthy reference"):
        sizing.propose({**summary, "lesions": []}, families, "case")
    summary["lesions"][0].update(s_start_mm=2.0, s_end_mm=48.0)
    with pytest.raises(InputError, match="stent length(?s:.*)overlapping stents"):
        sizing.propose(summary, families, "case")


@pytest.mark.parametrize(
    "change, what",
    [
        ({"distal_reference_diameter_mm": 1.7}, "no stent diameter .*fits the vessel"),
        ({"distal_reference_diameter_mm": 4.8}, "no stent diameter .*fits the vessel"),
        ({"distal_reference_diameter_mm": 2.3, "proximal_reference_diameter_mm": 4.6}, "two overlapping stents"),
        ({"s_start_mm": 0.5, "s_end_mm": 9.0}, "too near an end"),
        ({"s_start_mm": 42.0, "s_end_mm": 49.5}, "too near an end"),
        ({"branch": "side1", "s_start_mm": 3.0, "s_end_mm": 6.0}, "longer than the branch"),
    ],
)
def test_what_the_catalogue_or_the_branch_cannot_hold(families, summary, change, what):
    summary["lesions"][0].update(change)
    with pytest.raises(InputError, match=f"(?s){what}"):
        sizing.propose(summary, families, "case")


def test_design_that_reaches_the_proximal_reference(families, summary):
    summary["lesions"][0].update(distal_reference_diameter_mm=2.7, proximal_reference_diameter_mm=3.6)
    steps = sizing.propose(summary, families, "case")
    assert steps[1]["devices"][0]["diameter_mm"] == 3.0  # the 2.75 mm design ends at 3.5 mm
    plan.procedure(steps, families, summary, "case")


def test_tapered_vessel_is_postdilated_in_its_proximal_part(families, summary):
    summary["lesions"][0].update(distal_reference_diameter_mm=2.9, proximal_reference_diameter_mm=3.9)
    _, stent, post = (step["devices"][0] for step in sizing.propose(summary, families, "case"))
    assert post["diameter_mm"] == 4.0 and post["length_mm"] <= stent["length_mm"] / 2
    assert post["centre_s_mm"] - post["length_mm"] / 2 == stent["centre_s_mm"] - stent["length_mm"] / 2


def test_post_dilatation_does_not_overstretch_the_distal_reference(families, summary):
    """References 0.48 mm apart, but the balloon nearest to the proximal one is 0.59 mm above the distal one."""
    summary["lesions"][0].update(distal_reference_diameter_mm=3.16, proximal_reference_diameter_mm=3.64)
    _, stent, post = (step["devices"][0] for step in sizing.propose(summary, families, "case"))
    assert post["diameter_mm"] == 3.5 and post["length_mm"] == stent["length_mm"]
    assert post["pressure_bar"] == 20  # 3.58 mm


def second_lesion(summary, start, end, percent=58.0, branch="main"):
    """Adds a lesion behind or before the first one."""
    references = {"proximal_reference_diameter_mm": 3.0, "distal_reference_diameter_mm": 2.6}
    place = {"name": "lesion2", "branch": branch, "s_start_mm": start, "s_mla_mm": (start + end) / 2, "s_end_mm": end}
    summary["lesions"].append({**place, **references, "diameter_stenosis_percent": percent})


def test_tandem_lesions_come_under_one_stent(families, summary):
    """2.5 mm between them: a stent for the first alone would end in the second."""
    second_lesion(summary, 28.5, 34.0)
    pre, stent, _ = (step["devices"][0] for step in sizing.propose(summary, families, "case"))
    ends = [stent["centre_s_mm"] + sign * stent["length_mm"] / 2 for sign in (-1, 1)]
    assert ends[0] <= 16 - sizing.MARGIN_MM and ends[1] >= 34 + sizing.MARGIN_MM
    assert stent["diameter_mm"] == 2.75 and pre["diameter_mm"] == 2.5  # by the second one's distal reference, 2.6 mm
    assert pre["length_mm"] >= 18  # from the first one's start to the second one's end


def test_tandem_lesion_before_the_worst_one(families, summary):
    second_lesion(summary, 8.0, 13.0)
    stent = sizing.propose(summary, families, "case")[1]["devices"][0]
    assert stent["centre_s_mm"] - stent["length_mm"] / 2 <= 8 - sizing.MARGIN_MM and stent["diameter_mm"] == 3.0


@pytest.mark.parametrize("change", [{"start": 31.1, "end": 36.0}, {"percent": 30.0}, {"branch": "side1"}])
def test_lesions_apart_mild_or_elsewhere_are_no_tandem(families, summary, change):
    second_lesion(summary, **{"start": 29.0, "end": 34.0, **change})
    assert sizing.target(summary)["s_end_mm"] == 26.0


def test_stent_does_not_end_in_a_mild_lesion(families, summary):
    """Ends at 13.5 and 28.5 mm: moved by 0.5 mm out of a narrowing that begins at 28.3 mm."""
    summary["lesions"][0].update(s_start_mm=16.5, s_end_mm=25.5)
    second_lesion(summary, 28.3, 33.0, percent=25.0)
    stent = sizing.propose(summary, families, "case")[1]["devices"][0]
    assert stent["length_mm"] == 15 and stent["centre_s_mm"] == 20.5


@pytest.mark.parametrize("mouth, length, centre", [(29.0, 18, 21.0), (28.4, 18, 22.0), (21.0, 15, 21.0)])
def test_stent_ends_beside_a_mouth(families, summary, mouth, length, centre):
    """Ends at 13.5 and 28.5 mm: moved or lengthened out of a mouth of 2 mm, not for one that the stent covers."""
    summary["branches"][1].update(parent="main", s_on_parent_mm=mouth)
    summary["ends"] = [{"kind": "outlet", "branch": "side1", "diameter_mm": 2.0}]
    stent = sizing.propose(summary, families, "case")[1]["devices"][0]
    ends = [stent["centre_s_mm"] + sign * stent["length_mm"] / 2 for sign in (-1, 1)]
    assert all(abs(end - mouth) >= 1 for end in ends)
    assert ends[0] <= 16 - sizing.MARGIN_MM and ends[1] >= 26 + sizing.MARGIN_MM
    assert stent["length_mm"] == length and abs(stent["centre_s_mm"] - centre) < 1.01


def test_pressure_reaches_the_wanted_diameter(families):
    balloon = catalogue.entries(families, "non_compliant", 3.0, 12, "case")["non_compliant_3.00x12"]
    assert catalogue.pressure_for(balloon, 3.054) == 18
    assert catalogue.pressure_for(balloon, 3.5) == 20
    assert catalogue.pressure_for(balloon, 2.0) == 12


def test_a_family_may_ask_for_folding(families):
    family = families["non_compliant"] | {"folding": {"wings": 2}}
    assert "folding" not in catalogue.entries(families, "non_compliant", 3.0, 12, "case")["non_compliant_3.00x12"]
    entry = catalogue.entries(families | {"non_compliant": family}, "non_compliant", 3.0, 12, "case")
    assert entry["non_compliant_3.00x12"]["folding"] == {"wings": 2}


def test_mean_arterial_pressure():
    assert plan.mean_arterial_pressure_pa({"sbp_mmhg": 120, "dbp_mmhg": 80}) == pytest.approx(96 * 133.322, rel=1e-5)


def test_command_writes_a_relative_plan(run_module, repo_root, summary, tmp_path):
    folder = tmp_path / "anatomy"
    folder.mkdir()
    (folder / "anatomy.json").write_text(json.dumps(summary))
    out = tmp_path / "vci" / "plan.json"
    case = repo_root / "config" / "cases" / "real_artery.yaml"
    done = run_module("anatomy", "plan", case, "--anatomy", folder, "--out", out)
    assert done.returncode == 0, done.stderr
    document = json.loads(out.read_text())
    assert document["lumen"] == "../anatomy/lumen.vtp" and document["case"] == "real_artery"
    (folder / "anatomy.json").write_text("{}")
    done = run_module("anatomy", "plan", case, "--anatomy", folder, "--out", tmp_path / "other.json")
    assert done.returncode == 2 and "schema" in done.stderr and not (tmp_path / "other.json").exists()
