"""Draws virtual patients from stated distributions, one case file each. patients.md lists the distributions."""

import pathlib

import numpy as np
import yaml

from common.documents import config, schema
from common.errors import ComputationError, InputError
from common.files import replacing

from . import healthy_radius, patient, tree

ARTERY_SHARES = {"lad": 0.5, "lcx": 0.22, "rca": 0.28}
MAIN_LENGTH_MM = {"lad": (65, 105), "lcx": (60, 85), "rca": (75, 110)}
LESION_SHARES = {"focal": 0.45, "diffuse": 0.25, "tandem": 0.15, "bifurcation": 0.15}
LESION_LENGTH_MM = {"focal": (8, 15), "diffuse": (18, 28), "tandem": (18, 26), "bifurcation": (8, 14)}
SMALLEST_TREATED_MM = 2.6  # healthy diameter at the lesion; smaller vessels are rarely stented
# Largest healthy diameter at the lesion's distal end; the largest stents of the catalogue have 4.5 mm.
LARGEST_TREATED_MM = 4.4
CLEAR_OF_OSTIA_MM = 3.0  # wanted distance between a lesion's end and the nearest ostium, where there is room
MOST_DRAWS = 200  # a patient is drawn at most this many times until it can be built
MOST_PATIENTS = 1_000_000  # largest cohort; each patient has a file and takes some milliseconds


def run(count, seed, out):
    """Writes `out`/patient001.yaml ... (patient1000.yaml ...) for `count` patients; returns their paths.

    Patient k of a seed is the same for every count. Raises InputError for a count or seed out of range.
    """
    check(count, seed)
    paths = [pathlib.Path(out) / f"patient{number:03d}.yaml" for number in range(1, count + 1)]
    for number, path in enumerate(paths, 1):
        write_patient(seed, number, path)
    return paths


def check(count, seed):
    """Raises InputError for a count or seed out of range."""
    if not 1 <= count <= MOST_PATIENTS:
        raise InputError(
            "number of patients out of range", "--count", count, f"1 to {MOST_PATIENTS}; more by several seeds"
        )
    if not 0 <= seed < 2**32:
        raise InputError("seed out of range", "--seed", seed, "0 to 4294967295")


def write_patient(seed, number, path):
    """Writes the case file `path` of patient `number` of a seed."""
    text = f"# Drawn by data_synthetic draw, seed {seed}, number {number}.\n" + _as_yaml(draw_patient(seed, number))
    with replacing(path) as partial:
        partial.write_text(text)
    config.load_case(path)


def draw_patient(seed, number):
    """The case (dict, as in its file) of patient `number` of a seed: the first draw that can be built."""
    rng = np.random.default_rng([seed, number])
    for _ in range(MOST_DRAWS):
        case = _random_case(rng)
        vessel = schema.with_defaults(case["vessel"], schema.read("vessel"))
        try:
            patient.check(vessel, "draw")
            branches = tree.grow(vessel, "draw")
        except InputError:
            continue  # the draw is impossible: for example a side branch is too wide, or the tree meets itself
        if _treatable(branches[0], case["vessel"]["lesions"][0]):
            return case
    raise ComputationError("no patient that can be built", "draw", f"{MOST_DRAWS} attempts", "another seed")


def _treatable(main, lesion):
    """Whether the catalogue has a stent for the healthy vessel at the lesion."""
    centre = lesion["centre_s_mm"]
    at_lesion, distal = 2 * main.healthy_radius(np.array([centre, centre + 0.5 * lesion["length_mm"]]))
    return at_lesion >= SMALLEST_TREATED_MM and distal <= LARGEST_TREATED_MM


def _random_case(rng):
    artery = _random_choice(rng, ARTERY_SHARES)
    length = _random_uniform(rng, *MAIN_LENGTH_MM[artery], 0)
    ostial = _truncated_normal(rng, 4.2, 0.45, 3.2, 5.0, 2)
    mean = _truncated_normal(rng, 0.11, 0.02, 0.07, 0.16, 3)
    main = {
        "length_mm": length,
        "ostial_diameter_mm": ostial,
        "taper_percent_per_cm": _random_uniform(rng, 1, 3, 1),
        "mean_curvature_per_mm": mean,
        "max_curvature_per_mm": round(min(2.1 * mean, 0.3), 3),
    }
    sides = _random_side_branches(rng, main)
    lesion = _random_lesion(rng, length, sides)
    words = f"{artery.upper()}, {len(sides)} side branches, {lesion['shape']} {lesion['plaque']} lesion"
    systolic = _truncated_normal(rng, 130, 12, 100, 170, 0)
    return {
        "kind": "synthetic",
        "description": words + (" with calcium" if "calcium" in lesion else "") + ", drawn at random.",
        "patient": {
            "lvm_g": _truncated_normal(rng, 150, 28, 90, 240, 0),
            "sbp_mmhg": systolic,
            "dbp_mmhg": min(_truncated_normal(rng, 78, 8, 55, 100, 0), systolic - 30),
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


def _random_side_branches(rng, main):
    """Side branches (dicts, as in the case file) of a main vessel (dict), from proximal to distal.

    The diameter of each is a share of the main vessel's diameter where the branch leaves.
    """
    count, length = int(rng.integers(2, 6)), main["length_mm"]
    intervals = np.linspace(0.15, 0.85, count + 1) * length
    branches = []
    for low, high in zip(intervals[:-1], intervals[1:]):
        s = _random_uniform(rng, low, high, 1)
        vessel = schema.with_defaults({"seed": 0, "main": main, "side_branches": branches}, schema.read("vessel"))
        parent = 2 * float(healthy_radius.main_healthy_radius(vessel, s))
        diameter = round(float(np.clip(rng.uniform(0.38, 0.62) * parent, 1.2, 2.8)), 2)
        branch_length = min(_random_uniform(rng, 9, 22, 1), round(length - s - 4, 1))
        branches.append(
            {
                "s_mm": s,
                "diameter_mm": diameter,
                "length_mm": branch_length,
                "angle_deg": _random_uniform(rng, 45, 75, 0),
                "azimuth_deg": _random_uniform(rng, 0, 360, 0),
            }
        )
    return branches


def _random_lesion(rng, length, sides):
    lesion_type = _random_choice(rng, LESION_SHARES)
    extent = _random_uniform(rng, *LESION_LENGTH_MM[lesion_type], 0)
    ostia = np.array([side["s_mm"] for side in sides])
    if lesion_type == "bifurcation":
        centre = float(ostia[rng.integers(0, max(len(ostia) // 2, 1))])
    else:
        places = np.arange(0.22 * length, 0.6 * length, 0.5)
        distance_to_ostium = np.abs(places[:, None] - ostia[None]).min(axis=1)
        best = places[distance_to_ostium >= min(0.5 * extent + CLEAR_OF_OSTIA_MM, distance_to_ostium.max())]
        centre = float(rng.choice(best))
    lesion = {
        "shape": "focal" if lesion_type == "bifurcation" else lesion_type,
        "centre_s_mm": round(centre, 1),
        "length_mm": extent,
        "diameter_stenosis_percent": _truncated_normal(rng, 68, 5, 55, 78, 0),
        "eccentricity": round(float(rng.beta(2, 2)), 2),
        "direction_deg": _random_uniform(rng, 0, 360, 0),
        "plaque": "lipid" if rng.random() < 0.35 else "fibrous",
    }
    if rng.random() < 0.3:
        lesion["calcium"] = {
            "arc_deg": _random_uniform(rng, 40, 150, 0),
            "direction_deg": (lesion["direction_deg"] + 180) % 360,
            "length_mm": round(0.5 * extent, 1),
        }
    return lesion


def _random_choice(rng, shares):
    return str(rng.choice(list(shares), p=list(shares.values())))


def _random_uniform(rng, low, high, digits):
    return _rounded(rng.uniform(low, high), digits)


def _truncated_normal(rng, mean, sd, low, high, digits):
    """A normally distributed number, drawn again until it lies between low and high."""
    while True:
        value = rng.normal(mean, sd)
        if low <= value <= high:
            return _rounded(value, digits)


def _rounded(value, digits):
    return round(float(value), digits) if digits else int(round(float(value)))


def _as_yaml(case):
    return yaml.safe_dump(case, sort_keys=False, default_flow_style=None, width=140)
