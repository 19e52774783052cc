"""scene.json: the plan (what is done) with the section `deployment` (how the virtual deployment computes it)."""

from common.documents import json_reader, plan_reader, schema
from common.errors import InputError
from common.files import write_json

SCENE_SECTIONS = ("wall", "numerics")  # the parts of the section `deployment` that a scene has
REMEDY = "give settings/deployment.json of a case, or another JSON file with wall and numerics"


def write_scene(plan_file, settings_file, out):
    """Writes `out`: the plan's document with `wall` and `numerics`.

    Raises InputError if a file is not what it should be. Also raises it if `out` is not in the plan's folder: the scene
    keeps the plan's relative paths.
    """
    if out.resolve().parent != plan_file.resolve().parent:
        raise InputError("scene outside the plan's folder", "--out", out, f"write it into {plan_file.parent}")
    scene, settings = plan_reader.read(plan_file), json_reader.read(settings_file, "deployment.json", REMEDY)
    rules = {**schema.read("deployment"), "required": SCENE_SECTIONS}
    schema.validate(settings, rules, "settings of the deployment", REMEDY)
    write_json(out, {**scene, **{key: settings.data[key] for key in SCENE_SECTIONS}})
