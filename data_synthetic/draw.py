"""Draws virtual patients from stated distributions, one case file each. patients.md lists the distributions."""

import pathlib

import numpy as np
import yaml

from common.documents import config, schema
from common.errors import ComputationError, InputError
from common.files import replacing

from . import healthy_radius, patient, tree

ARTERIES = {"lad": 0.5, "lcx": 0.22, "rca": 0.28}
LENGTH_MM = {"lad": (65, 105), "lcx": (60, 85), "rca": (75, 110)}
LESIONS = {"focal": 0.45, "diffuse": 0.25, "tandem": 0.15, "bifurcation": 0.15}
LESION_LENGTH_MM = {"focal": (8, 15), "diffuse": (18, 28), "tandem": (18, 26), "bifurcation": (8, 14)}
SMALLEST_TREATED_MM = 2.6  # healthy diameter at the lesion; smaller vessels are rarely stented
LARGEST_TREATED_MM = 4.4  # healthy diameter at the lesion's distal end; the catalogue's largest stents have 4.5 mm
CLEAR_OF_OSTIA_MM = 3.0  # wanted distance between a lesion's end and the nearest ostium
ATTEMPTS = 200  # most draws for one patient
MOST = 1_000_000  # patients in a cohort; each has its own file and takes some milliseconds


def run(count, seed, out):
    """Writes `out`/patient001.yaml ... (patient1000.yaml ...) for `count` patients; returns their paths.

    Patient k of a seed is the same whatever the count. Raises InputError for a count or seed out of range.
    """
    check(count, seed)
    paths = [pathlib.Path(out) / f"patient{number:03d}.yaml" for number in range(1, count + 1)]
    for number, path in enumerate(paths, 1):
        write(seed, number, path)
    return paths


def check(count, seed):
    """Raises InputError for a count or seed out of range."""
    if not 1 <= count <= MOST:
        raise InputError("number of patients out of range", "--count", count, f"1 to {MOST}; more by several seeds")
    if not 0 <= seed < 2**32:
        raise InputError("seed out of range", "--seed", seed, "0 to 4294967295")


def write(seed, number, path):
    """Writes the case file `path` of patient `number` of a seed."""
    text = f"# Drawn by data_synthetic draw, seed {seed}, number {number}.\n" + _text(one(seed, number))
    with replacing(path) as partial:
        partial.write_text(text)
    config.load_case(path)


def one(seed, number):
    """The case (dict, as in its file) of patient `number` of a seed: the first draw that can be built."""
    rng = np.random.default_rng([seed, number])
    for _ in range(ATTEMPTS):
        case = _case(rng)
        vessel = schema.with_defaults(case["vessel"], schema.read("vessel"))
        try:
            patient.check(vessel, "draw")
            branches = tree.grow(vessel, "draw")
        except InputError:
            continue  # impossible combination, such as a side branch too wide or a tree that meets itself
        if _treatable(branches[0], case["vessel"]["lesions"][0]):
            return case
    raise ComputationError("no patient that can be built", "draw", f"{ATTEMPTS} attempts", "another seed")


def _treatable(main, lesion):
    """Whether the catalogue has a stent for the healthy vessel at the lesion."""
    centre = lesion["centre_s_mm"]
    at, distal = 2 * main.healthy(np.array([centre, centre + 0.5 * lesion["length_mm"]]))
    return at >= SMALLEST_TREATED_MM and distal <= LARGEST_TREATED_MM


def _case(rng):
    artery = _choice(rng, ARTERIES)
    length = _uniform(rng, *LENGTH_MM[artery], 0)
    ostial = _normal(rng, 4.2, 0.45, 3.2, 5.0, 2)
    mean = _normal(rng, 0.11, 0.02, 0.07, 0.16, 3)
    main = {
        "length_mm": length,
        "ostial_diameter_mm": ostial,
        "taper_percent_per_cm": _uniform(rng, 1, 3, 1),
        "mean_curvature_per_mm": mean,
        "max_curvature_per_mm": round(min(2.1 * mean, 0.3), 3),
    }
    sides = _sides(rng, main)
    lesion = _lesion(rng, length, sides)
    words = f"{artery.upper()}, {len(sides)} side branches, {lesion['shape']} {lesion['plaque']} lesion"
    systolic = _normal(rng, 130, 12, 100, 170, 0)
    return {
        "kind": "synthetic",
        "description": words + (" with calcium" if "calcium" in lesion else "") + ", drawn at random.",
        "patient": {
            "lvm_g": _normal(rng, 150, 28, 90, 240, 0),
            "sbp_mmhg": systolic,
            "dbp_mmhg": min(_normal(rng, 78, 8, 55, 100, 0), systolic - 30),
        },
        "vessel": {
            "seed": int(rng.integers(2**31)),
            "artery": artery,
            "main": main,
            "side_branches": sides,
            "lesions": [lesion],
        },
        "plan": "auto",
    }


def _sides(rng, main):
    """Side branches (dicts, as in the case file) of a main vessel (dict), from proximal to distal.

    The diameter of each is a share of the main vessel's diameter where the branch leaves.
    """
    count, length = int(rng.integers(2, 6)), main["length_mm"]
    stretch = np.linspace(0.15, 0.85, count + 1) * length
    found = []
    for low, high in zip(stretch[:-1], stretch[1:]):
        s = _uniform(rng, low, high, 1)
        so_far = schema.with_defaults({"seed": 0, "main": main, "side_branches": found}, schema.read("vessel"))
        parent = 2 * float(healthy_radius.main_healthy_radius(so_far, s))
        diameter = round(float(np.clip(rng.uniform(0.38, 0.62) * parent, 1.2, 2.8)), 2)
        reach = min(_uniform(rng, 9, 22, 1), round(length - s - 4, 1))
        found.append(
            {
                "s_mm": s,
                "diameter_mm": diameter,
                "length_mm": reach,
                "angle_deg": _uniform(rng, 45, 75, 0),
                "azimuth_deg": _uniform(rng, 0, 360, 0),
            }
        )
    return found


def _lesion(rng, length, sides):
    kind = _choice(rng, LESIONS)
    extent = _uniform(rng, *LESION_LENGTH_MM[kind], 0)
    ostia = np.array([side["s_mm"] for side in sides])
    if kind == "bifurcation":
        centre = float(ostia[rng.integers(0, max(len(ostia) // 2, 1))])
    else:
        places = np.arange(0.22 * length, 0.6 * length, 0.5)
        room = np.abs(places[:, None] - ostia[None]).min(axis=1)
        best = places[room >= min(0.5 * extent + CLEAR_OF_OSTIA_MM, room.max())]
        centre = float(rng.choice(best))
    lesion = {
        "shape": "focal" if kind == "bifurcation" else kind,
        "centre_s_mm": round(centre, 1),
        "length_mm": extent,
        "diameter_stenosis_percent": _normal(rng, 68, 5, 55, 78, 0),
        "eccentricity": round(float(rng.beta(2, 2)), 2),
        "direction_deg": _uniform(rng, 0, 360, 0),
        "plaque": "lipid" if rng.random() < 0.35 else "fibrous",
    }
    if rng.random() < 0.3:
        lesion["calcium"] = {
            "arc_deg": _uniform(rng, 40, 150, 0),
            "direction_deg": (lesion["direction_deg"] + 180) % 360,
            "length_mm": round(0.5 * extent, 1),
        }
    return lesion


def _choice(rng, shares):
    return str(rng.choice(list(shares), p=list(shares.values())))


def _uniform(rng, low, high, digits):
    return _rounded(rng.uniform(low, high), digits)


def _normal(rng, mean, sd, low, high, digits):
    """A normal number, drawn again until it lies between low and high."""
    while True:
        value = rng.normal(mean, sd)
        if low <= value <= high:
            return _rounded(value, digits)


def _rounded(value, digits):
    return round(float(value), digits) if digits else int(round(float(value)))


def _text(case):
    return yaml.safe_dump(case, sort_keys=False, default_flow_style=None, width=140)
