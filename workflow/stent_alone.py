"""The plan with the stents' steps alone, for a radius correction by the stents' size (state rc_stent)."""

from common.documents import plan_reader
from common.errors import InputError
from common.files import write_json


def write_stent_alone(plan_file, out):
    """Writes `out`: the plan's document with only the steps that place stents. Unused devices stay listed.

    Raises InputError for a file that is no plan and for a plan without a stent. `out` must lie in a folder beside the
    plan's folder, so that the plan's relative paths stay right. Otherwise InputError is raised, too.
    """
    plan = plan_reader.read(plan_file)
    if out.resolve().parent.parent != plan_file.resolve().parent.parent:
        raise InputError("plan in another case", "--out", out, f"write it beside {plan_file.parent}")
    stents = {name for name, device in plan["devices"].items() if device["kind"] == "stent"}
    steps = [step for step in plan["procedure"] if any(use["device"] in stents for use in step["devices"])]
    if not steps:
        actions = [step["action"] for step in plan["procedure"]]
        raise InputError("no stent in the plan", f"{plan_file}: procedure", actions, "leave metrics.stent_alone false")
    write_json(out, {**plan, "procedure": steps})
