"""Reads plan.json for the steps in Python that change or draw it. The engine checks the rest of it in the scene."""

from common.documents import json_reader, schema
from common.errors import InputError

SCHEMA = "vci-scene-1"
REMEDY = "give a plan.json that `anatomy plan` has written"


def read(file):
    """The document (dict) of a plan.json, lengths in mm and pressures in bar, each used device among its devices.

    Raises InputError if the file cannot be read, is no plan, or uses a device that it does not define.
    """
    document = json_reader.read(file, "plan.json", REMEDY)
    plan = document.data
    if plan.get("schema") != SCHEMA:
        raise InputError("not a plan", document.where(("schema",)), plan.get("schema"), REMEDY)
    schema.validate(document, schema.read("reference_scene"))
    for i, step in enumerate(plan["procedure"]):
        for j, use in enumerate(step["devices"]):
            if use["device"] not in plan["devices"]:
                where = document.where(("procedure", i, "devices", j, "device"))
                remedy = f"devices of this plan: {', '.join(plan['devices'])}"
                raise InputError("a device that the plan does not define", where, use["device"], remedy)
    return plan
