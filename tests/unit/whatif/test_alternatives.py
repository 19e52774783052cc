"""Alternative plans: each changes one thing, to another size or pressure of the catalogue."""

import copy

import pytest

from common.documents import config
from common.errors import InputError
from whatif import alternatives


@pytest.fixture(scope="module")
def families(repo_root):
    return config.load_devices(repo_root / "config" / "devices")


def changed(steps, other):
    """{(action, key): value in `other`} of the device values that differ between two plans with the same steps."""
    assert [step["action"] for step in steps] == [step["action"] for step in other]
    return {
        (step["action"], key): theirs[key]
        for step, twin in zip(steps, other)
        for mine, theirs in zip(step["devices"], twin["devices"])
        for key in mine
        if mine[key] != theirs[key]
    }


def test_each_alternative_changes_what_it_says(plan, families):
    steps = alternatives.case_steps(plan)
    before = copy.deepcopy(steps)
    found = alternatives.all_alternatives(steps, families)
    assert changed(steps, found["shorter"][1]) == {("stent", "length_mm"): 15}
    assert changed(steps, found["longer"][1]) == {("stent", "length_mm"): 23}
    larger = {("stent", "diameter_mm"): 3.25, ("postdilatation", "diameter_mm"): 3.5}
    assert changed(steps, found["larger"][1]) == larger
    smaller = {("stent", "diameter_mm"): 2.75, ("postdilatation", "diameter_mm"): 3.0}
    assert changed(steps, found["smaller"][1]) == smaller
    assert changed(steps, found["pressure"][1]) == {
        ("stent", "pressure_bar"): 16,
        ("postdilatation", "pressure_bar"): 20,
    }
    assert [step["action"] for step in found["predilatation"][1]] == ["stent", "postdilatation"]
    assert [step["action"] for step in found["postdilatation"][1]] == ["predilatation", "stent"]
    assert steps == before, "the plan itself is left alone"


def test_a_stent_alone_gets_balloons_of_the_catalogue(plan, families):
    steps = [alternatives.case_steps(plan)[1]]
    found = alternatives.all_alternatives(steps, families)
    words, other, _ = found["predilatation"]
    balloon = other[0]["devices"][0]
    assert words == "with predilatation" and [step["action"] for step in other] == ["predilatation", "stent"]
    assert (balloon["device"], balloon["diameter_mm"], balloon["length_mm"]) == ("semi_compliant", 2.5, 15)
    balloon = found["postdilatation"][1][1]["devices"][0]
    assert (balloon["device"], balloon["diameter_mm"], balloon["pressure_bar"]) == ("non_compliant", 3.0, 12)
    assert balloon["centre_s_mm"] == 20.0


def test_what_the_catalogue_does_not_have_is_not_offered(plan, families):
    steps = alternatives.case_steps(plan)
    steps[1]["devices"][0] |= {"length_mm": 38.0, "diameter_mm": 4.5, "pressure_bar": 16}
    steps[2]["devices"][0]["pressure_bar"] = 20
    found = alternatives.all_alternatives(steps, families)
    assert found["longer"][1] is None and "ends at 38 mm" in found["longer"][2]
    assert found["pressure"][2] == "every balloon is at its rated burst pressure"
    assert changed(steps, found["larger"][1]) == {("postdilatation", "diameter_mm"): 3.5}, "the largest stent stays"
    assert found["shorter"][1] is not None
    steps[1]["devices"][0]["diameter_mm"] = 2.25
    assert changed(steps, alternatives.all_alternatives(steps, families)["smaller"][1]).keys() == {
        ("postdilatation", "diameter_mm")
    }, "the smallest stent stays"
    steps[1]["devices"][0]["diameter_mm"], steps[2]["devices"][0]["diameter_mm"] = 4.5, 5.5
    assert alternatives.all_alternatives(steps, families)["larger"][2] == "every device is the catalogue's largest"


def test_a_plan_of_balloons_has_no_stent_to_change(plan, families):
    found = alternatives.all_alternatives(alternatives.case_steps(plan)[:1], families)
    assert found["longer"][2] == "the plan has no stent" and found["postdilatation"][1] is None
    assert found["predilatation"][1:] == (None, "the plan has no other step")


def test_a_device_that_is_not_named_after_its_size_is_refused(plan):
    plan["devices"]["semi_compliant_2.50x15"]["length_mm"] = 20
    with pytest.raises(InputError, match="tells no family"):
        alternatives.case_steps(plan)
