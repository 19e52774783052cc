"""Other plans for the same lesion: the planned steps with one thing changed."""

import copy

from anatomy.planning import catalogue
from common.documents import config
from common.errors import InputError

EXTRA_PRESSURE_BAR = 4.0  # bar added to every inflation from the first stent on, up to the rated burst pressure
PREDILATATION, POSTDILATATION, STENT = "predilatation", "postdilatation", "stent"
PREDILATATION_UNDERSIZE_MM = 0.5  # mm by which an added predilatation balloon is thinner than the stent
BALLOON_FAMILIES = {
    PREDILATATION: "semi_compliant",
    POSTDILATATION: "non_compliant",
}  # device family of an added balloon
NOMINAL_PRESSURE_KEY = "nominal_pressure_bar"


class PlanNotPossible(Exception):
    """The catalogue or the plan does not allow this alternative; the message says why."""


def case_steps(plan):
    """The steps of a plan.json as a case file lists them: devices by family, size, place and pressure.

    Raises InputError for a device that is not named after its family and size.
    """
    return [
        {"action": step["action"], "devices": [_case_device(use, plan["devices"]) for use in step["devices"]]}
        for step in plan["procedure"]
    ]


def _case_device(use, devices):
    name, device = use["device"], devices[use["device"]]
    size = {"diameter_mm": float(device["nominal_diameter_mm"]), "length_mm": float(device["length_mm"])}
    family = name.removesuffix(catalogue.device_key("", *size.values()))
    if family == name:
        raise InputError("a device's name tells no family", "plan.json", name, "make it by `anatomy plan`")
    return {"device": family, **size, **{key: use[key] for key in ("branch", "centre_s_mm", "pressure_bar")}}


def all_alternatives(steps, families):
    """{name: (description, steps, "")} of every alternative plan, in a fixed order.

    If an alternative is not possible, its steps are None, and the last entry says why instead of "". steps: the given
    plan's steps, as `case_steps` returns them; families: {name: device family}.
    """
    alternatives = {
        "shorter": ("stent one length shorter", lambda: _change_stent_lengths(steps, families, -1)),
        "longer": ("stent one length longer", lambda: _change_stent_lengths(steps, families, 1)),
        "larger": ("stent and what follows one size larger", lambda: _change_diameters(steps, families, 1)),
        "smaller": ("stent and what follows one size smaller", lambda: _change_diameters(steps, families, -1)),
        "pressure": (f"{EXTRA_PRESSURE_BAR:g} bar more from the stent on", lambda: _raise_pressures(steps, families)),
        "predilatation": _toggle_action(steps, families, PREDILATATION),
        "postdilatation": _toggle_action(steps, families, POSTDILATATION),
    }
    results = {}
    for name, (description, make) in alternatives.items():
        try:
            results[name] = description, make(), ""
        except PlanNotPossible as reason:
            results[name] = description, None, str(reason)
    return results


def _first_stent_step(steps):
    """Index of the first step that places a stent."""
    first = next((k for k, step in enumerate(steps) if step["action"] == STENT), None)
    if first is None:
        raise PlanNotPossible("the plan has no stent")
    return first


def _change_stent_lengths(steps, families, entries):
    """The steps with each stent's length moved by `entries` places in its family's list of lengths."""
    first, changed = _first_stent_step(steps), copy.deepcopy(steps)
    for step in changed[first:]:
        for use in step["devices"] if step["action"] == STENT else ():
            sizes = sorted(families[use["device"]]["lengths_mm"])
            index = sizes.index(use["length_mm"]) + entries
            if not 0 <= index < len(sizes):
                raise PlanNotPossible(f"the catalogue ends at {use['length_mm']:g} mm")
            use["length_mm"] = sizes[index]
    return changed


def _change_diameters(steps, families, entries):
    """The steps with the diameter of each device from the first stent on moved by `entries` places in its family.

    A device that already has its family's largest or smallest diameter stays as it is.
    """
    first, changed = _first_stent_step(steps), copy.deepcopy(steps)
    for step in changed[first:]:
        for use in step["devices"]:
            sizes = sorted(families[use["device"]]["diameters_mm"])
            index = sizes.index(use["diameter_mm"]) + entries
            use["diameter_mm"] = sizes[min(max(index, 0), len(sizes) - 1)]
    if changed == steps:
        raise PlanNotPossible(f"every device is the catalogue's {'largest' if entries > 0 else 'smallest'}")
    return changed


def _raise_pressures(steps, families):
    first, changed = _first_stent_step(steps), copy.deepcopy(steps)
    for step in changed[first:]:
        for use in step["devices"]:
            balloon = families[config.balloon_family(families, use["device"])]
            use["pressure_bar"] = min(use["pressure_bar"] + EXTRA_PRESSURE_BAR, balloon["rated_burst_pressure_bar"])
    if changed == steps:
        raise PlanNotPossible("every balloon is at its rated burst pressure")
    return changed


def _toggle_action(steps, families, action):
    """(description, function that makes the steps) of an alternative without the plan's steps of kind `action`.

    If the plan has no such step, the alternative adds one at each stent.
    """
    if any(step["action"] == action for step in steps):
        return f"without {action}", lambda: _without_action(steps, action)
    return f"with {action}", lambda: _add_balloons(steps, families, action)


def _without_action(steps, action):
    remaining = [copy.deepcopy(step) for step in steps if step["action"] != action]
    if not remaining:
        raise PlanNotPossible("the plan has no other step")
    return remaining


def _add_balloons(steps, families, action):
    """The steps with a balloon of kind `action` before or after each stent, at nominal pressure.

    It has the stent's size, or the next smaller one of its family. A balloon before the stent is thinner by
    PREDILATATION_UNDERSIZE_MM or more.
    """
    _first_stent_step(steps)
    family, changed = BALLOON_FAMILIES[action], []
    if family not in families:
        raise PlanNotPossible(f"the catalogue has no {family}")
    for step in copy.deepcopy(steps):
        added = [
            {"action": action, "devices": [_balloon_for_stent(use, family, families[family], action)]}
            for use in step["devices"]
        ]
        added = added if step["action"] == STENT else []
        changed += [*added, step] if action == PREDILATATION else [step, *added]
    return changed


def _balloon_for_stent(stent, name, family, action):
    wanted = stent["diameter_mm"] - (PREDILATATION_UNDERSIZE_MM if action == PREDILATATION else 0.0)
    sizes = [size for size in family["diameters_mm"] if size <= wanted]
    lengths = [length for length in family["lengths_mm"] if length <= stent["length_mm"]]
    if not sizes or not lengths:
        raise PlanNotPossible(f"{name} has no size up to {wanted:g} x {stent['length_mm']:g} mm")
    size = {"device": name, "diameter_mm": max(sizes), "length_mm": max(lengths)}
    return stent | size | {"pressure_bar": family[NOMINAL_PRESSURE_KEY]}
