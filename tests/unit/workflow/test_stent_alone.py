"""The stents alone of a plan, for radius correction that knows no other balloon."""

import json

import pytest

from common.errors import InputError
from workflow.stent_alone import write_stent_alone

BALLOON = {"kind": "balloon", "length_mm": 15}
DEVICES = {"balloon": BALLOON, "stent": {"kind": "stent", "length_mm": 15, "balloon": "its"}, "its": BALLOON}
USE = {"branch": "main", "centre_s_mm": 9.0, "pressure_bar": 11}


def plan_of(folder, *devices):
    steps = [{"name": name, "action": name, "devices": [{"device": name, **USE}]} for name in devices]
    plan = folder / "case" / "vci" / "plan.json"
    plan.parent.mkdir(parents=True)
    document = {"schema": "vci-scene-1", "lumen": "../anatomy/lumen.vtp", "devices": DEVICES, "procedure": steps}
    plan.write_text(json.dumps(document))
    return plan


def test_only_the_steps_that_place_stents_stay(tmp_path):
    plan = plan_of(tmp_path, "balloon", "stent", "balloon", "stent")
    out = tmp_path / "case" / "rc_stent" / "plan.json"
    out.parent.mkdir()
    write_stent_alone(plan, out)
    found = json.loads(out.read_text())
    assert [step["action"] for step in found["procedure"]] == ["stent", "stent"]
    assert {**found, "procedure": None} == {**json.loads(plan.read_text()), "procedure": None}
    with pytest.raises(InputError, match="another case"):
        write_stent_alone(plan, tmp_path / "other" / "rc_stent" / "plan.json")


def test_a_plan_of_balloons_is_refused(tmp_path):
    plan = plan_of(tmp_path, "balloon")
    with pytest.raises(InputError, match="no stent in the plan"):
        write_stent_alone(plan, tmp_path / "case" / "rc_stent" / "plan.json")
