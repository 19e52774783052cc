"""Reads a synthetic case, and refuses a vessel that cannot be built, with a message that names the key."""

import pathlib

from common.documents import config
from common.errors import InputError

from . import healthy_radius, disease


NARROWEST_MAIN_MM = 1.2  # least diameter of the main vessel past its last side branch
NARROWEST_END_MM = 0.6  # least diameter at an end: three cells of the grid on which the surface is found


def load(path):
    """The case (dict, defaults filled in) at `path`. Raises InputError naming the key at fault."""
    path = pathlib.Path(path)
    case = config.load_case(path)
    if case["kind"] != "synthetic":
        raise InputError("not a synthetic case", f"{path}: kind", case["kind"], "generate only cases of kind synthetic")
    check(case["vessel"], str(path))
    return case


def check(vessel, where):
    """Raises InputError if a vessel (dict, defaults filled in) cannot be built. where: its file, for the message."""

    def refuse(what, key, value, remedy):
        raise InputError(what, f"{where}: vessel.{key}", value, remedy)

    main = vessel["main"]
    if main["mean_curvature_per_mm"] > 0.7 * main["max_curvature_per_mm"]:
        refuse(
            "mean curvature too close to its bound",
            "main.mean_curvature_per_mm",
            main["mean_curvature_per_mm"],
            "at most 0.7 of main.max_curvature_per_mm",
        )
    radius = 0.5 * main["ostial_diameter_mm"]
    order = sorted(range(len(vessel["side_branches"])), key=lambda i: vessel["side_branches"][i]["s_mm"])
    forks = healthy_radius.bifurcations(vessel)
    for rank, index in enumerate(order):
        side, key = vessel["side_branches"][index], f"side_branches[{index + 1}]"
        low, high = 2.5 * radius, main["length_mm"] - 4 * radius
        if not low <= side["s_mm"] <= high:
            refuse(
                "side branch outside the main vessel",
                f"{key}.s_mm",
                side["s_mm"],
                f"between {low:.1f} and {high:.1f} mm: room for the ends' caps",
            )
        before = 2 * forks[rank].before_mm
        if side["diameter_mm"] >= 0.95 * before:
            refuse(
                "side branch as wide as its parent, or nothing is left for the main vessel",
                f"{key}.diameter_mm",
                side["diameter_mm"],
                "a smaller branch, a wider ostium, or fewer branches",
            )
        if side["s_mm"] + side["length_mm"] > main["length_mm"] - 1:
            refuse(
                "side branch reaches farther than the main vessel, which is the longest path by definition",
                f"{key}.length_mm",
                side["length_mm"],
                f"below {main['length_mm'] - 1 - side['s_mm']:.1f} mm",
            )
        if side["length_mm"] < 0.5 * before + 2.5 * side["diameter_mm"]:
            refuse(
                "side branch hardly leaves the main vessel",
                f"{key}.length_mm",
                side["length_mm"],
                f"at least {0.5 * before + 2.5 * side['diameter_mm']:.1f} mm (main radius + 2.5 diameters)",
            )
    left = 2 * forks[-1].after_mm if forks else main["ostial_diameter_mm"]
    if left < NARROWEST_MAIN_MM:
        refuse(
            "main vessel too narrow after its side branches",
            "side_branches",
            f"{left:.2f} mm left",
            f"at least {NARROWEST_MAIN_MM} mm: fewer or smaller branches, or less taper",
        )
    _check_taper(main, 2 * healthy_radius.main_healthy_radius(vessel, main["length_mm"]), "main", refuse)
    for rank, index in enumerate(order):
        side = vessel["side_branches"][index]
        end = 2 * healthy_radius.side_healthy_radius(side, forks[rank], side["length_mm"])
        _check_taper(side, end, f"side_branches[{index + 1}]", refuse)
    for index, lesion in enumerate(vessel["lesions"]):
        _check_lesion(vessel, lesion, f"lesions[{index + 1}]", refuse)
        _check_overlap(vessel["lesions"][:index], lesion, f"lesions[{index + 1}]", refuse)


def _check_taper(branch, end, key, refuse):
    if end < NARROWEST_END_MM:
        refuse(
            "tapers to nothing",
            f"{key}.taper_percent_per_cm",
            f"{branch['taper_percent_per_cm']} over {branch['length_mm']} mm: {end:.2f} mm left at the end",
            f"at least {NARROWEST_END_MM} mm: less taper, a shorter or a wider branch",
        )


def _check_overlap(others, lesion, key, refuse):
    """Raises InputError if the lesion overlaps one of `others` that shifts the lumen differently.

    At the place where one lesion becomes deeper than the other the lumen's axis would jump.
    """
    start, end = disease.lesion_extent(lesion)
    for number, other in enumerate(others, start=1):
        low, high = disease.lesion_extent(other)
        if other["branch"] != lesion["branch"] or end <= low or high <= start:
            continue
        if _lumen_shift(other) != _lumen_shift(lesion):
            both = f"from {start:.1f} to {end:.1f} mm; lesions[{number}] {low:.1f} to {high:.1f} mm"
            refuse(
                "lesion overlaps another that shifts the lumen differently",
                f"{key}.centre_s_mm",
                f"{lesion['centre_s_mm']} ({both})",
                f"clear of it, or the eccentricity and direction_deg of lesions[{number}]",
            )


def _lumen_shift(lesion):
    """(eccentricity, direction in degrees) of a lesion. A concentric lesion shifts nothing: its direction is 0."""
    return lesion["eccentricity"], lesion["direction_deg"] % 360 if lesion["eccentricity"] else 0


def _check_lesion(vessel, lesion, key, refuse):
    names = ["main"] + [f"side{i + 1}" for i in range(len(vessel["side_branches"]))]
    if lesion["branch"] not in names:
        refuse("lesion in a branch that is not there", f"{key}.branch", lesion["branch"], f"one of {', '.join(names)}")
    if lesion["branch"] == "main":
        length, margin = vessel["main"]["length_mm"], vessel["main"]["ostial_diameter_mm"]
    else:
        side = healthy_radius.ordered_side_branches(vessel)[int(lesion["branch"][4:]) - 1]
        length, margin = side["length_mm"], side["diameter_mm"]
    start, end = disease.lesion_extent(lesion)
    if start < margin or end > length - margin:
        refuse(
            "lesion beyond the vessel",
            f"{key}.centre_s_mm",
            f"{lesion['centre_s_mm']} (from {start:.1f} to {end:.1f} mm)",
            f"inside {margin:.1f} ... {length - margin:.1f} mm: one diameter from the ends",
        )
    calcium = lesion.get("calcium")
    if calcium and calcium["length_mm"] > lesion["length_mm"]:
        refuse(
            "calcium longer than its lesion",
            f"{key}.calcium.length_mm",
            calcium["length_mm"],
            f"at most {lesion['length_mm']} mm",
        )
