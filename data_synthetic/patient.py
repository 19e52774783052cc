"""Reads a synthetic case and refuses what cannot be built, by its key."""

import pathlib

from common import config
from common.errors import InputError

from . import disease


NARROWEST_END_MM = 0.6  # of diameter: three cells of the grid on which the surface is found


def load(path):
    """The case (dict, defaults filled in) at `path`. Raises InputError naming the key at fault."""
    path = pathlib.Path(path)
    case = config.load_case(path)
    if case["kind"] != "synthetic":
        raise InputError("not a synthetic case", f"{path}: kind", case["kind"], "generate only cases of kind synthetic")
    check(case["vessel"], str(path))
    return case


def ordered_sides(vessel):
    """Side branches in the order in which they leave the main vessel: side1, side2, ..."""
    return sorted(vessel["side_branches"], key=lambda side: side["s_mm"])


def healthy_diameters(vessel):
    """Healthy main diameters (mm) just before each side branch, and the power d^m left after the last (mm^m)."""
    exponent, main = vessel["murray_exponent"], vessel["main"]
    power = main["ostial_diameter_mm"] ** exponent
    before = []
    for side in ordered_sides(vessel):
        before.append(power ** (1 / exponent))
        power -= side["diameter_mm"] ** exponent
        if power <= 0:
            break
    return before, power


def check(vessel, where):
    """Raises InputError if the vessel (defaults filled in) is impossible."""

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
    before, left = healthy_diameters(vessel)
    exponent = vessel["murray_exponent"]
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
        if rank >= len(before) or side["diameter_mm"] >= 0.95 * before[rank]:
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
        if side["length_mm"] < 0.5 * before[rank] + 2.5 * side["diameter_mm"]:
            refuse(
                "side branch hardly leaves the main vessel",
                f"{key}.length_mm",
                side["length_mm"],
                f"at least {0.5 * before[rank] + 2.5 * side['diameter_mm']:.1f} mm (main radius + 2.5 diameters)",
            )
    if left < 1.2**exponent:
        refuse(
            "main vessel too narrow after its side branches",
            "side_branches",
            f"{max(left, 0) ** (1 / exponent):.2f} mm left",
            "at least 1.2 mm before taper: fewer or smaller branches",
        )
    _check_taper(main, left ** (1 / exponent), "main", refuse)
    for index, side in enumerate(vessel["side_branches"]):
        _check_taper(side, side["diameter_mm"], f"side_branches[{index + 1}]", refuse)
    for index, lesion in enumerate(vessel["lesions"]):
        _check_lesion(vessel, lesion, f"lesions[{index + 1}]", refuse)


def _check_taper(branch, diameter_mm, key, refuse):
    end = diameter_mm * (1 - 0.01 * branch["taper_percent_per_cm"]) ** (0.1 * branch["length_mm"])
    if end < NARROWEST_END_MM:
        refuse(
            "tapers to nothing",
            f"{key}.taper_percent_per_cm",
            f"{branch['taper_percent_per_cm']} over {branch['length_mm']} mm: {end:.2f} mm left at the end",
            f"at least {NARROWEST_END_MM} mm: less taper, a shorter or a wider branch",
        )


def _check_lesion(vessel, lesion, key, refuse):
    names = ["main"] + [f"side{i + 1}" for i in range(len(vessel["side_branches"]))]
    if lesion["branch"] not in names:
        refuse("lesion in a branch that is not there", f"{key}.branch", lesion["branch"], f"one of {', '.join(names)}")
    if lesion["branch"] == "main":
        length, margin = vessel["main"]["length_mm"], vessel["main"]["ostial_diameter_mm"]
    else:
        side = ordered_sides(vessel)[int(lesion["branch"][4:]) - 1]
        length, margin = side["length_mm"], side["diameter_mm"]
    start, end = disease.extent(lesion)
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
