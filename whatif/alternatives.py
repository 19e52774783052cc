"""Other plans for the same lesion: the planned steps with one thing changed."""

import copy

from anatomy.planning import catalogue
from common.errors import InputError

PRESSURE_BAR = 4.0  # added to every inflation from the first stent on, but not beyond the rated burst pressure
BEFORE, AFTER, STENT = "predilatation", "postdilatation", "stent"
SMALLER = 0.5  # mm by which an added predilatation balloon is thinner than the stent
FAMILIES = {BEFORE: "semi_compliant", AFTER: "non_compliant"}  # device family of an added balloon
NOMINAL = "nominal_pressure_bar"


class NotOffered(Exception):
    """The catalogue or the plan does not allow this alternative; the message says why."""


def requests(plan):
    """The steps of a plan.json as a case file lists them: devices by family, size, place and pressure.

    Raises InputError for a device that is not named after its family and size.
    """
    return [
        {"action": step["action"], "devices": [_request(use, plan["devices"]) for use in step["devices"]]}
        for step in plan["procedure"]
    ]


def _request(use, devices):
    name, device = use["device"], devices[use["device"]]
    size = {"diameter_mm": float(device["nominal_diameter_mm"]), "length_mm": float(device["length_mm"])}
    family = name.removesuffix(catalogue.key("", *size.values()))
    if family == name:
        raise InputError("a device's name tells no family", "plan.json", name, "make it by `anatomy plan`")
    return {"device": family, **size, **{key: use[key] for key in ("branch", "centre_s_mm", "pressure_bar")}}


def all_of(steps, families):
    """{name: (description, steps, "")} of every alternative plan, in a fixed order.

    If an alternative is not possible, its steps are None and the last entry says why. steps: of the given plan, as
    from `requests`; families: {name: device family}.
    """
    made = {
        "shorter": ("stent one length shorter", lambda: _relengthened(steps, families, -1)),
        "longer": ("stent one length longer", lambda: _relengthened(steps, families, 1)),
        "larger": ("stent and what follows one size larger", lambda: _wider(steps, families)),
        "pressure": (f"{PRESSURE_BAR:g} bar more from the stent on", lambda: _harder(steps, families)),
        "predilatation": _toggled(steps, families, BEFORE),
        "postdilatation": _toggled(steps, families, AFTER),
    }
    found = {}
    for name, (words, make) in made.items():
        try:
            found[name] = words, make(), ""
        except NotOffered as reason:
            found[name] = words, None, str(reason)
    return found


def _of_stents(steps):
    """Index of the first step that places a stent."""
    first = next((k for k, step in enumerate(steps) if step["action"] == STENT), None)
    if first is None:
        raise NotOffered("the plan has no stent")
    return first


def _relengthened(steps, families, by):
    """The steps with each stent's length moved `by` entries in its family's list of lengths."""
    first, found = _of_stents(steps), copy.deepcopy(steps)
    for step in found[first:]:
        for use in step["devices"] if step["action"] == STENT else ():
            sizes = sorted(families[use["device"]]["lengths_mm"])
            k = sizes.index(use["length_mm"]) + by
            if not 0 <= k < len(sizes):
                raise NotOffered(f"the catalogue ends at {use['length_mm']:g} mm")
            use["length_mm"] = sizes[k]
    return found


def _wider(steps, families):
    """The steps with every device from the first stent on one diameter larger.

    A device that already has its family's largest diameter stays as it is.
    """
    first, found = _of_stents(steps), copy.deepcopy(steps)
    for step in found[first:]:
        for use in step["devices"]:
            use["diameter_mm"] = min(
                (size for size in families[use["device"]]["diameters_mm"] if size > use["diameter_mm"]),
                default=use["diameter_mm"],
            )
    if found == steps:
        raise NotOffered("every device is the catalogue's largest")
    return found


def _harder(steps, families):
    first, found = _of_stents(steps), copy.deepcopy(steps)
    for step in found[first:]:
        for use in step["devices"]:
            family = families[use["device"]]
            balloon = families[family["delivery_balloon"]] if family["kind"] == "stent" else family
            use["pressure_bar"] = min(use["pressure_bar"] + PRESSURE_BAR, balloon["rated_burst_pressure_bar"])
    if found == steps:
        raise NotOffered("every balloon is at its rated burst pressure")
    return found


def _toggled(steps, families, action):
    """(description, function that makes the steps) of the plan without its steps of kind `action`.

    If the plan has no such step, the alternative adds one at each stent.
    """
    if any(step["action"] == action for step in steps):
        return f"without {action}", lambda: _without(steps, action)
    return f"with {action}", lambda: _added(steps, families, action)


def _without(steps, action):
    left = [copy.deepcopy(step) for step in steps if step["action"] != action]
    if not left:
        raise NotOffered("the plan has no other step")
    return left


def _added(steps, families, action):
    """The steps with a balloon of `action` before or after each stent, at nominal pressure.

    It has the stent's size; before the stent it is SMALLER mm thinner.
    """
    _of_stents(steps)
    family, found = FAMILIES[action], []
    if family not in families:
        raise NotOffered(f"the catalogue has no {family}")
    for step in copy.deepcopy(steps):
        added = [
            {"action": action, "devices": [_balloon(use, family, families[family], action)]} for use in step["devices"]
        ]
        added = added if step["action"] == STENT else []
        found += [*added, step] if action == BEFORE else [step, *added]
    return found


def _balloon(stent, name, family, action):
    wanted = stent["diameter_mm"] - (SMALLER if action == BEFORE else 0.0)
    sizes = [size for size in family["diameters_mm"] if size <= wanted]
    lengths = [length for length in family["lengths_mm"] if length <= stent["length_mm"]]
    if not sizes or not lengths:
        raise NotOffered(f"{name} has no size up to {wanted:g} x {stent['length_mm']:g} mm")
    size = {"device": name, "diameter_mm": max(sizes), "length_mm": max(lengths)}
    return stent | size | {"pressure_bar": family[NOMINAL]}
