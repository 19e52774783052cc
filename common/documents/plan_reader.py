"""Reads plan.json for the Python commands that change or draw a plan.

Only what these commands use is checked here. The deployment engine checks the rest when it reads scene.json.
"""

from common.documents import json_reader, schema
from common.errors import InputError

REMEDY = "give a plan.json that `anatomy plan` has written"


def read(file):
    """The content (dict) of a plan.json: lengths in mm, pressures in bar. It defines every device that a step uses.

    Raises InputError if the file cannot be read, is no plan, or uses a device that it does not define.
    """
    document = json_reader.read(file, "plan.json", REMEDY)
    schema.validate(document, schema.read("reference_scene"), "a plan", REMEDY)
    plan = document.data
    for i, step in enumerate(plan["procedure"]):
        for j, use in enumerate(step["devices"]):
            if use["device"] not in plan["devices"]:
                where = document.where(("procedure", i, "devices", j, "device"))
                remedy = f"devices of this plan: {', '.join(plan['devices'])}"
                raise InputError("a device that the plan does not define", where, use["device"], remedy)
    return plan


def inflating_balloon(devices, name):
    """The entry (dict) of the balloon that inflates the device `name`: its own, or that of a stent's delivery balloon.

    devices: {name: entry}, as in plan.json and scene.json.
    """
    device = devices[name]
    return devices[device["balloon"]] if device["kind"] == "stent" else device
