"""Vessels as `lumen process` measures them, with narrowings of chosen place, length and depth."""

import numpy as np

SPACING_MM, NEAR_END_MM = 0.25, 2.0


def focal(centre, length, percent):
    """A cosine narrowing: function of s that gives the share of the diameter that is lost."""
    return lambda s: np.where(
        np.abs(s - centre) < length / 2, percent / 200 * (1 + np.cos(2 * np.pi * (s - centre) / length)), 0
    )


def plateau(start, end, percent, ramp=0.5):
    """A narrowing of constant depth from start to end. The ramps at its ends lie inside this range."""
    return lambda s: percent / 100 * np.interp(s, [start, start + ramp, end - ramp, end], [0, 1, 1, 0])


def worst_of(*shapes):
    """One lesion from several narrowings: at each place the deepest of them."""
    return lambda s: np.max([shape(s) for shape in shapes], axis=0)


def measured_vessel(*narrowings, length=50.0, healthy=lambda s: 3.3 - 0.02 * s, lumen=None, sides=()):
    """(summary, sections) of a main branch as `lumen process` measures it, mm.

    narrowings: functions of s (share of the diameter); a focal one of 64 % at 21 mm without any. Each becomes a lesion.
    lumen: diameters by s instead of healthy(s) less the narrowings. sides: [(s, diameter)] of side branches.
    """
    shapes = narrowings or (focal(21, 12, 64),)
    s = np.arange(SPACING_MM, length, SPACING_MM)
    reference = healthy(s)
    diameter = reference * (1 - worst_of(*shapes)(s)) if lumen is None else lumen(s)
    lesions = [_lesion(s, reference, shape(s)) for shape in shapes]
    lesions.sort(key=lambda lesion: -lesion["diameter_stenosis_percent"])
    for number, lesion in enumerate(lesions, 1):
        lesion["name"] = f"lesion{number}"
    branches = [{"name": "main", "parent": None, "length_mm": length, "s_on_parent_mm": 0.0}]
    sections, ends = {"main": rows("main", s, diameter, reference)}, [_end("inlet", "inlet", "main", 0.0, healthy(0.0))]
    for number, (at, wide) in enumerate(sides or ((20.0, 0.9),), 1):
        name = f"side{number}"
        branches.append({"name": name, "parent": "main", "length_mm": 9.0, "s_on_parent_mm": at})
        ends.append(_end("outlet", f"outlet{number}", name, at, wide))
        along = np.arange(1.5, 9.0, SPACING_MM)
        sections[name] = rows(name, along, 0 * along + wide, 0 * along + wide, 9.0)
    return {"schema": "vci-anatomy-1", "lesions": lesions, "branches": branches, "ends": ends}, sections


def _end(kind, name, branch, at, wide):
    place = {"centre_mm": [at, 0.0, 0.0], "normal": [-1.0, 0.0, 0.0]}
    return {"kind": kind, "name": name, "branch": branch, "diameter_mm": wide} | place


def rows(branch, s, diameter, reference, length=None):
    """Rows of sections.csv as read_sections gives them."""
    last = (length or s[-1] + SPACING_MM) - NEAR_END_MM
    return [
        {
            "branch": branch,
            "s_mm": at,
            "equivalent_diameter_mm": wide,
            "min_diameter_mm": 0.9 * wide,
            "max_diameter_mm": 1.1 * wide,
            "reference_diameter_mm": whole,
            "flag": "ok" if NEAR_END_MM <= at <= last else "end",
        }
        for at, wide, whole in zip(s.tolist(), diameter.tolist(), reference.tolist())
    ]


def _lesion(s, reference, lacking):
    inside, worst = s[lacking > 0.04], int(lacking.argmax())
    first, last = np.searchsorted(s, inside[[0, -1]])
    return {
        "branch": "main",
        "s_start_mm": float(inside[0]),
        "s_mla_mm": float(s[worst]),
        "s_end_mm": float(inside[-1]),
        "mld_mm": float(reference[worst] * (1 - lacking[worst])),
        "reference_diameter_mm": float(reference[worst]),
        "proximal_reference_diameter_mm": float(reference[first]),
        "distal_reference_diameter_mm": float(reference[last]),
        "diameter_stenosis_percent": float(100 * lacking[worst]),
    }
