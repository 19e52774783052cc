"""A scene is the plan with the section `deployment`."""

import json

import pytest

from common.errors import InputError
from workflow.scene import write_scene


SETTINGS = {"wall": {"model": "membrane"}, "numerics": {"pcg_tolerance": 0.1}}
STEP = {"device": "balloon", "branch": "main", "centre_s_mm": 9.0, "pressure_bar": 8}
PLAN = {
    "schema": "vci-scene-1",
    "lumen": "../anatomy/lumen.vtp",
    "devices": {"balloon": {"kind": "balloon", "length_mm": 15}},
    "procedure": [{"name": "first", "action": "predilatation", "devices": [STEP]}],
}


@pytest.fixture
def files(tmp_path):
    """plan.json and the settings."""
    plan, settings = tmp_path / "plan.json", tmp_path / "deployment.json"
    plan.write_text(json.dumps(PLAN))
    settings.write_text(json.dumps(SETTINGS))
    return plan, settings


def test_scene_is_the_plan_with_wall_and_numerics(files, tmp_path):
    write_scene(*files, tmp_path / "scene.json")
    assert json.loads((tmp_path / "scene.json").read_text()) == {**PLAN, **SETTINGS}
    with pytest.raises(InputError, match="outside the plan's folder"):
        write_scene(*files, tmp_path / "elsewhere" / "scene.json")


@pytest.mark.parametrize("key", ["wall", "numerics"])
def test_settings_of_another_section_are_refused(files, tmp_path, key):
    files[1].write_text(json.dumps({name: value for name, value in SETTINGS.items() if name != key}))
    with pytest.raises(InputError, match=f"(?s)not settings of the deployment.*key {key} is missing"):
        write_scene(*files, tmp_path / "scene.json")
    assert not (tmp_path / "scene.json").exists()
