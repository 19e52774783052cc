"""A plan proposed from the most severe lesion by the usual sizing rules.

Sizing as in the EAPCI consensus on intracoronary imaging (Raeber et al., Eur Heart J 2018;39:3281-3300): the stent by
the distal reference, rounded up to the catalogue; landing zones in healthy wall and, where a little more length allows
it, neither in a side branch's mouth nor in another lesion; lesions with no landing zone between them under one stent;
post-dilatation with a non-compliant balloon at the proximal reference, but not more than half a millimetre above the
distal one; in a vessel that tapers by more than that only in the stent's proximal part.
"""

from common.errors import InputError

from . import catalogue

MARGIN_MM = 2.5  # healthy wall under each end of the stent
EDGE_MM = 1.5  # least distance of a device from the ends of its branch
OVERSIZE_MM = 0.5  # of the stent over the distal reference at most
TAPER_MM = 0.5  # from the proximal to the distal reference that one balloon may dilate alike
SHIFT_MM = 0.5  # step in which a stent is moved out of a side branch's mouth or another lesion
SIGNIFICANT_PERCENT = 50  # diameter stenosis from which a lesion is usually treated
AND = " and "  # between the names of lesions under one stent
PREDILATATION, STENT, POSTDILATATION = "semi_compliant", "des", "non_compliant"


def propose(summary, families, where):
    """Plan steps (as in a case file, placed by centre_s_mm) for the `target` of `summary`.

    Raises InputError if there is no lesion, or if the catalogue or the branch does not fit it.
    """
    if not summary["lesions"]:
        raise InputError(
            "no lesion to plan for",
            where,
            "plan: auto",
            "write the plan's steps with centre_s_mm; a vessel narrowed all along its length has no healthy reference",
        )
    for family in (PREDILATATION, STENT, POSTDILATATION):
        if family not in families:
            raise InputError("plan: auto needs a device family", where, family, f"add {family}.yaml to the devices")
    lesion = target(summary)
    distal, proximal = lesion["distal_reference_diameter_mm"], lesion["proximal_reference_diameter_mm"]
    extent = lesion["s_end_mm"] - lesion["s_start_mm"]
    stent_d = _stent_diameter(families, distal, proximal, where)
    stent_l, centre = _stent_place(summary, lesion, families[STENT]["lengths_mm"], where)
    pre_d = _at_most(families[PREDILATATION]["diameters_mm"], distal, "predilatation diameter", where)
    pre_l = _at_most(families[PREDILATATION]["lengths_mm"], stent_l, "predilatation length", where)
    pre_l = min([x for x in families[PREDILATATION]["lengths_mm"] if x >= extent and x <= pre_l], default=pre_l)
    wanted_d = max(proximal, stent_d)
    tapers = wanted_d - distal > TAPER_MM
    sizes = families[POSTDILATATION]["diameters_mm"]
    if not tapers:  # dilates the distal reference, too
        sizes = [size for size in sizes if size <= distal + TAPER_MM + 1e-9] or sizes[:1]
    post_d = min(sizes, key=lambda size: abs(size - wanted_d))
    covered = stent_l / 2 if tapers else stent_l
    post_l = _at_most(families[POSTDILATATION]["lengths_mm"], covered, "post-dilatation length", where)
    post_centre = round(centre - (stent_l - post_l) / 2, 3) if tapers else centre

    def step(action, family, diameter, length, wanted, at):
        inflated = catalogue.balloon_family(families, family)
        balloon = catalogue.entries(families, inflated, diameter, length, where).popitem()[1]
        size = {"device": family, "diameter_mm": diameter, "length_mm": length}
        place = {"branch": lesion["branch"], "centre_s_mm": at, "pressure_bar": catalogue.pressure_for(balloon, wanted)}
        return {"action": action, "devices": [size | place]}

    return [
        step("predilatation", PREDILATATION, pre_d, pre_l, pre_d, centre),
        step("stent", STENT, stent_d, stent_l, stent_d, centre),
        step("postdilatation", POSTDILATATION, post_d, post_l, wanted_d, post_centre),
    ]


def target(summary):
    """The most severe lesion of `summary`, with those of its branch that leave no landing zone between (tandem).

    Such lesions are those of at least SIGNIFICANT_PERCENT less than two margins away; the entry that stands for them
    has the names of all, the extent from the first to the last, and the references at its two ends.
    """
    found = dict(summary["lesions"][0])
    near = [other for other in summary["lesions"][1:] if other["branch"] == found["branch"]]
    near = [other for other in near if other["diameter_stenosis_percent"] >= SIGNIFICANT_PERCENT]
    while near:
        gaps = [max(o["s_start_mm"] - found["s_end_mm"], found["s_start_mm"] - o["s_end_mm"]) for o in near]
        nearest = gaps.index(min(gaps))
        if gaps[nearest] >= 2 * MARGIN_MM:
            break
        other = near.pop(nearest)
        found["name"] += AND + other["name"]
        for at, side in (("s_start_mm", "proximal"), ("s_end_mm", "distal")):
            if (other[at] < found[at]) == (side == "proximal"):
                found |= {key: other[key] for key in (at, f"{side}_reference_diameter_mm")}
    return found


def _stent_diameter(families, distal, proximal, where):
    """The least diameter (mm) not below the distal reference whose design can be expanded to the proximal one."""
    fitting = [size for size in families[STENT]["diameters_mm"] if distal - 1e-9 <= size <= distal + OVERSIZE_MM]
    if not fitting:
        sizes = families[STENT]["diameters_mm"]
        raise InputError(
            "no stent diameter of the catalogue fits the vessel",
            where,
            f"distal reference {distal:.2f} mm",
            f"sizes are {sizes[0]} to {sizes[-1]} mm, at most {OVERSIZE_MM} mm above the reference: "
            "treat by balloon alone, or write the plan's steps",
        )
    for size in fitting:
        if _greatest_diameter(families[STENT], size) >= max(proximal, size):
            return size
    raise InputError(
        "no stent that fits the distal reference can be expanded to the proximal one",
        where,
        f"{distal:.2f} and {proximal:.2f} mm",
        "write the plan's steps with two overlapping stents",
    )


def _greatest_diameter(stents, size):
    return next(d for d in stents["designs"] if size <= d["up_to_diameter_mm"])["maximal_diameter_mm"]


def _stent_place(summary, lesion, lengths, where):
    """(length, centre) in mm of the stent: the shortest that covers the lesion and its margins, inside its branch."""
    branch = next(b for b in summary["branches"] if b["name"] == lesion["branch"])
    start, end = lesion["s_start_mm"], lesion["s_end_mm"]
    wanted = end - start + 2 * MARGIN_MM
    fitting = [length for length in lengths if length >= wanted - 1e-9]
    if not fitting:
        raise InputError(
            "no stent length large enough in the catalogue",
            where,
            f"{wanted:.1f} mm for {lesion['name']} of {end - start:.1f} mm and its margins",
            f"largest {lengths[-1]} mm: write the plan's steps with overlapping stents",
        )
    centre = _inside(0.5 * (start + end), fitting[0], branch["length_mm"], where)
    if centre - fitting[0] / 2 > start or centre + fitting[0] / 2 < end:
        raise InputError(
            "the lesion reaches too near an end of its branch for a stent",
            where,
            f"{start:.1f} to {end:.1f} mm of {branch['length_mm']:.1f} mm",
            "bring more of the vessel, or write the plan's steps",
        )
    return _clear_of_mouths(summary, lesion, fitting[:2], branch, (fitting[0], centre))


def _clear_of_mouths(summary, lesion, lengths, branch, centred):
    """The first (length, centre) by rising length and shift with no end in a mouth or a lesion, else `centred`."""
    taken = [*mouths(summary, lesion["branch"]).values(), *other_lesions(summary, lesion)]
    middle = 0.5 * (lesion["s_start_mm"] + lesion["s_end_mm"])
    candidates = [centred]
    for length in lengths:
        slack = (length - (lesion["s_end_mm"] - lesion["s_start_mm"])) / 2 - MARGIN_MM
        shifts = [SHIFT_MM * k for k in range(int(slack / SHIFT_MM + 1e-9) + 1)]
        candidates += [(length, round(middle + sign * shift, 3)) for shift in shifts for sign in (1, -1)]
    for length, centre in candidates:
        ends = (centre - length / 2, centre + length / 2)
        inside = EDGE_MM <= ends[0] and ends[1] <= branch["length_mm"] - EDGE_MM
        if inside and not any(low < end < high for end in ends for low, high in taken):
            return length, centre
    return centred


def mouths(summary, parent):
    """{side branch: (s_low, s_high)} of the mouths on a branch, mm, as wide as their outlets."""
    width = {end["branch"]: end["diameter_mm"] for end in summary.get("ends", ()) if end["kind"] == "outlet"}
    sides = [branch for branch in summary["branches"] if branch.get("parent") == parent]
    middles = {side["name"]: side["s_on_parent_mm"] for side in sides}
    return {name: (s - width[name] / 2, s + width[name] / 2) for name, s in middles.items()}


def other_lesions(summary, lesion):
    """[(s_start, s_end)] in mm of the lesions on a (merged) lesion's branch that it does not cover."""
    inside = (lesion["s_start_mm"], lesion["s_end_mm"])
    spans = [(o["s_start_mm"], o["s_end_mm"]) for o in summary["lesions"] if o["branch"] == lesion["branch"]]
    return [span for span in spans if span[0] < inside[0] or span[1] > inside[1]]


def _at_most(sizes, wanted, what, where):
    for size in reversed(sizes):
        if size <= wanted + 1e-9:
            return size
    raise InputError(f"no {what} small enough in the catalogue", where, f"{wanted:.2f} mm", f"smallest {sizes[0]} mm")


def _inside(centre, device_length, branch_length, where):
    lowest, highest = EDGE_MM + device_length / 2, branch_length - EDGE_MM - device_length / 2
    if lowest > highest:
        raise InputError(
            "the stent is longer than the branch has room for",
            where,
            f"{device_length} mm, and {EDGE_MM} mm to each end, in {branch_length:.1f} mm",
            "write the plan's steps with a shorter stent",
        )
    return round(min(max(centre, lowest), highest), 3)
