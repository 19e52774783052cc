"""A plan proposed from the most severe lesion by the usual sizing rules.

Sizing as in the EAPCI consensus on intracoronary imaging (Raeber et al., Eur Heart J 2018;39:3281-3300): the stent by
the distal reference, rounded up to the catalogue; landing zones in healthy wall; post-dilatation with a non-compliant
balloon at the proximal reference.
"""

from common.errors import InputError

from . import catalogue

MARGIN_MM = 2.5  # healthy wall under each end of the stent
EDGE_MM = 1.5  # least distance of a device from the ends of its branch
PREDILATATION, STENT, POSTDILATATION = "semi_compliant", "des", "non_compliant"


def propose(summary, families, where):
    """Plan steps (as in a case file, placed by centre_s_mm) for the most severe lesion of `summary`.

    Raises InputError if there is no lesion, or if the catalogue or the branch is too small for it.
    """
    if not summary["lesions"]:
        raise InputError("no lesion to plan for", where, "plan: auto", "write the plan's steps with centre_s_mm")
    for family in (PREDILATATION, STENT, POSTDILATATION):
        if family not in families:
            raise InputError("plan: auto needs a device family", where, family, f"add {family}.yaml to the devices")
    lesion = summary["lesions"][0]
    distal, proximal = lesion["distal_reference_diameter_mm"], lesion["proximal_reference_diameter_mm"]
    extent = lesion["s_end_mm"] - lesion["s_start_mm"]
    stent_d = _at_least(families[STENT]["diameters_mm"], distal, "stent diameter", where)
    stent_l = _at_least(families[STENT]["lengths_mm"], extent + 2 * MARGIN_MM, "stent length", where)
    pre_d = _at_most(families[PREDILATATION]["diameters_mm"], distal, "predilatation diameter", where)
    pre_l = _at_most(families[PREDILATATION]["lengths_mm"], stent_l, "predilatation length", where)
    pre_l = min([x for x in families[PREDILATATION]["lengths_mm"] if x >= extent and x <= pre_l], default=pre_l)
    post_d = min(families[POSTDILATATION]["diameters_mm"], key=lambda size: abs(size - max(proximal, stent_d)))
    post_l = _at_most(families[POSTDILATATION]["lengths_mm"], stent_l, "post-dilatation length", where)
    sizes = {PREDILATATION: (pre_d, pre_l), STENT: (stent_d, stent_l), POSTDILATATION: (post_d, post_l)}
    length = next(b["length_mm"] for b in summary["branches"] if b["name"] == lesion["branch"])
    centre = _inside(0.5 * (lesion["s_start_mm"] + lesion["s_end_mm"]), stent_l, length, where)

    def step(action, family):
        diameter, device_length = sizes[family]
        balloon = catalogue.entries(
            families, catalogue.balloon_family(families, family), diameter, device_length, where
        ).popitem()[1]
        target = max(proximal, stent_d) if action == "postdilatation" else diameter
        device = {
            "device": family,
            "diameter_mm": diameter,
            "length_mm": device_length,
            "branch": lesion["branch"],
            "centre_s_mm": centre,
            "pressure_bar": catalogue.pressure_for(balloon, target),
        }
        return {"action": action, "devices": [device]}

    return [step("predilatation", PREDILATATION), step("stent", STENT), step("postdilatation", POSTDILATATION)]


def _at_least(sizes, wanted, what, where):
    for size in sizes:
        if size >= wanted - 1e-9:
            return size
    raise InputError(f"no {what} large enough in the catalogue", where, f"{wanted:.2f} mm", f"largest {sizes[-1]} mm")


def _at_most(sizes, wanted, what, where):
    for size in reversed(sizes):
        if size <= wanted + 1e-9:
            return size
    raise InputError(f"no {what} small enough in the catalogue", where, f"{wanted:.2f} mm", f"smallest {sizes[0]} mm")


def _inside(centre, device_length, branch_length, where):
    lowest, highest = EDGE_MM + device_length / 2, branch_length - EDGE_MM - device_length / 2
    if lowest > highest:
        raise InputError(
            "the stent is longer than the branch",
            where,
            f"{device_length} mm in {branch_length:.1f} mm",
            "write the plan's steps with a shorter stent",
        )
    return round(min(max(centre, lowest), highest), 3)
