"""scene.json: the plan (what is done) with the section `deployment` (how the virtual deployment computes it)."""

import json

from common.errors import InputError
from common.files import write_json


def write_scene(plan_file, settings_file, out):
    """Writes `out`: the plan's document with `wall` and `numerics`.

    Raises InputError if `out` is in another folder than the plan, whose relative paths it keeps.
    """
    if out.resolve().parent != plan_file.resolve().parent:
        raise InputError("scene outside the plan's folder", "--out", out, f"write it into {plan_file.parent}")
    scene = json.loads(plan_file.read_text())
    settings = json.loads(settings_file.read_text())
    write_json(out, {**scene, "wall": settings["wall"], "numerics": settings["numerics"]})
