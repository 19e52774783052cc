"""A scene is the plan with the section `deployment`."""

import json

import pytest

from common.errors import InputError
from workflow.scene import write_scene


def test_scene_is_the_plan_with_wall_and_numerics(tmp_path):
    plan, settings = tmp_path / "plan.json", tmp_path / "deployment.json"
    plan.write_text(json.dumps({"schema": "vci-scene-1", "lumen": "../anatomy/lumen.vtp"}))
    settings.write_text(json.dumps({"wall": {"model": "membrane"}, "numerics": {"pcg_tolerance": 0.1}}))
    write_scene(plan, settings, tmp_path / "scene.json")
    assert json.loads((tmp_path / "scene.json").read_text()) == {
        "schema": "vci-scene-1",
        "lumen": "../anatomy/lumen.vtp",
        "wall": {"model": "membrane"},
        "numerics": {"pcg_tolerance": 0.1},
    }
    with pytest.raises(InputError, match="outside the plan's folder"):
        write_scene(plan, settings, tmp_path / "elsewhere" / "scene.json")
