"""The plan: devices in full, placed on the measured lumen, within what catalogue and stent allow."""

import json

import pytest

from anatomy.planning import catalogue, plan
from common.errors import InputError


def request(device="des", diameter=3.0, length=15, pressure=11, **place):
    size = {"diameter_mm": diameter, "length_mm": length, "pressure_bar": pressure}
    return {"device": device, "branch": "main", **size, **(place or {"lesion": 1})}


def stent_step(**changes):
    return [{"action": "stent", "devices": [request(**changes)]}]


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


def test_a_branch_left_out_is_that_of_the_lesion_or_main(families, summary):
    """A branch that the user names decides. Without one, the branch is the lesion's, or main."""
    summary["lesions"][0] |= {"branch": "side1", "s_start_mm": 0.0, "s_end_mm": 2.0}
    for place, branch in (({"lesion": 1}, "side1"), ({"centre_s_mm": 20}, "main")):
        steps = stent_step(**place)
        del steps[0]["devices"][0]["branch"]
        done = plan.procedure(steps, families, summary, "case")
        assert done["procedure"][0]["devices"][0]["branch"] == branch


def test_device_of_a_side_branch_may_begin_in_the_parent(families, summary):
    done = plan.procedure(stent_step(branch="side1", centre_s_mm=1), families, summary, "case")
    assert done["segment"] == {"branch": "side1", "s_start_mm": 0.0, "s_end_mm": 8.5}


@pytest.mark.parametrize(
    "steps, what",
    [
        (stent_step(device="unknown"), "no such device family"),
        (stent_step(diameter=3.1), "size not in the catalogue"),
        (stent_step(length=16), "size not in the catalogue"),
        (stent_step(pressure=17), "rated burst pressure"),
        (stent_step(lesion=2), "no such lesion"),
        (stent_step(branch="side1", lesion=1), "the lesion lies in another branch"),
        (stent_step(branch="side4", centre_s_mm=5), "no such branch"),
        (stent_step(centre_s_mm=5), "beyond its branch"),
        (stent_step(centre_s_mm=45), "beyond its branch"),
        (stent_step(branch="side1", centre_s_mm=2), "beyond its branch"),
        (stent_step(branch="side1", centre_s_mm=-13), "beyond its branch"),
        (stent_step(device="semi_compliant"), "wrong kind"),
        ([{"action": "predilatation", "devices": [request()]}], "wrong kind"),
        (
            stent_step(diameter=2.25)
            + [{"action": "postdilatation", "devices": [request("non_compliant", 3.5, 12, 20)]}],
            "over-expand",
        ),
    ],
)
def test_refusals(families, summary, steps, what):
    with pytest.raises(InputError, match=what):
        plan.procedure(steps, families, summary, "case")


@pytest.mark.parametrize(
    "steps",
    [
        stent_step(pressure=16),
        stent_step(centre_s_mm=7.5),
        stent_step(centre_s_mm=42.5),
        stent_step(branch="side1", centre_s_mm=1.5),
        stent_step(branch="side1", centre_s_mm=-12.5),
        stent_step(diameter=2.25) + [{"action": "postdilatation", "devices": [request("non_compliant", 3.25, 12, 18)]}],
    ],
)
def test_what_lies_just_inside_is_planned(families, summary, steps):
    assert plan.procedure(steps, families, summary, "case")["procedure"]


def test_balloon_away_from_the_stent_may_be_larger(families, summary):
    away = {"action": "postdilatation", "devices": [request("non_compliant", 3.5, 12, 20, centre_s_mm=40)]}
    steps = stent_step(diameter=2.25, centre_s_mm=15) + [away]
    assert len(plan.procedure(steps, families, summary, "case")["procedure"]) == 2


def test_pressure_reaches_the_wanted_diameter(families):
    balloon = catalogue.device_entries(families, "non_compliant", 3.0, 12, "case")["non_compliant_3.00x12"]
    assert catalogue.pressure_for(balloon, 3.054) == 18
    assert catalogue.pressure_for(balloon, 3.5) == 20
    assert catalogue.pressure_for(balloon, 2.0) == 12
    assert (catalogue.pressure_for(balloon, 3.05), catalogue.pressure_for(balloon, 3.05, 3.05)) == (18, 17)


def test_a_family_may_ask_for_folding(families):
    family = families["non_compliant"] | {"folding": {"wings": 2}}
    assert (
        "folding" not in catalogue.device_entries(families, "non_compliant", 3.0, 12, "case")["non_compliant_3.00x12"]
    )
    entry = catalogue.device_entries(families | {"non_compliant": family}, "non_compliant", 3.0, 12, "case")
    assert entry["non_compliant_3.00x12"]["folding"] == {"wings": 2}


def test_mean_arterial_pressure():
    assert plan.mean_arterial_pressure_pa({"sbp_mmhg": 120, "dbp_mmhg": 80}) == pytest.approx(96 * 133.322, rel=1e-5)


def test_command_writes_a_relative_plan(run_module, repo_root, vessel, written, tmp_path):
    folder = written(*vessel())
    out = tmp_path / "vci" / "plan.json"
    case = repo_root / "config" / "cases" / "real_artery.yaml"
    done = run_module("anatomy", "plan", case, "--anatomy", folder, "--out", out)
    assert done.returncode == 0, done.stderr
    document = json.loads(out.read_text())
    assert document["lumen"] == "../anatomy/lumen.vtp" and document["case"] == "real_artery"
    (folder / "anatomy.json").write_text("{}")
    done = run_module("anatomy", "plan", case, "--anatomy", folder, "--out", tmp_path / "other.json")
    assert done.returncode == 2 and "schema" in done.stderr and not (tmp_path / "other.json").exists()
