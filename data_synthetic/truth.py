"""Writes truth.json, the exact geometry of a virtual patient, and reads it back as branches."""

import numpy as np

from common.documents import json_reader
from common.errors import InputError
from common.implicit.curves import Curve

from . import healthy_radius, disease, tree

SCHEMA = "vci-truth-1"


def document(vessel, branches, rms_mm, vertices, triangles):
    """The content of truth.json: samples (mm) of each branch, true areas and stenoses of its lesions, wall thickness.

    rms_mm: rms distance of the surface's wall points from the exact wall. vertices, triangles: their numbers in the
    surface.
    """
    forks = healthy_radius.bifurcations(vessel)
    return {
        "schema": SCHEMA,
        "seed": vessel["seed"],
        "artery": vessel["artery"],
        "murray_exponent": vessel["murray_exponent"],
        "wall_thickness_mm": vessel["wall_thickness_mm"],
        "bifurcations": [vars(fork) for fork in forks],
        "surface": {"vertices": vertices, "triangles": triangles, "wall_error_rms_mm": rms_mm},
        "branches": [_branch_entry(branch) for branch in branches],
    }


def _branch_entry(branch):
    axis = branch.axis
    return {
        "name": branch.name,
        "parent": branch.parent,
        "s_on_parent_mm": branch.s_on_parent_mm,
        "length_mm": axis.length_mm,
        "mean_curvature_per_mm": float(axis.curvature(axis.s_mm).mean()),
        "lesions": [dict(lesion, **_true_lesion_values(branch, lesion)) for lesion in branch.lesions],
        "s_mm": axis.s_mm.round(6).tolist(),
        "points_mm": axis.points_mm.round(9).tolist(),
        "radius_mm": branch.radius_mm.round(9).tolist(),
        "healthy_radius_mm": branch.healthy_radius_mm.round(9).tolist(),
        "shift_mm": branch.shift_mm.round(9).tolist(),
    }


def _true_lesion_values(branch, lesion):
    start, end = disease.lesion_extent(lesion)
    s = branch.axis.s_mm
    inside = (s >= start) & (s <= end)
    narrowest = np.flatnonzero(inside)[np.argmin(branch.radius_mm[inside])]
    theta = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    thickness = branch.plaque_thickness(s[inside][:, None], theta[None])
    r = branch.radius_mm[inside][:, None]
    area = np.mean((r + thickness) ** 2 - r**2, axis=1) * np.pi
    return {
        "true_s_mla_mm": float(s[narrowest]),
        "true_mla_mm2": float(np.pi * branch.radius_mm[narrowest] ** 2),
        "true_diameter_stenosis_percent": float(
            100 * (1 - branch.radius_mm[narrowest] / branch.healthy_radius_mm[narrowest])
        ),
        "true_plaque_volume_mm3": float(np.sum(area) * (s[1] - s[0])),
    }


REGENERATE_REMEDY = "run data_synthetic generate again"
# Number of dimensions of each array of samples: 1 for (n,), 2 for (n, 3).
SAMPLE_DIMENSIONS = {"s_mm": 1, "points_mm": 2, "radius_mm": 1, "healthy_radius_mm": 1, "shift_mm": 2}


def check(document, path):
    """Raises InputError, naming the key, if a part of the document (dict) is missing or impossible for a vessel."""
    for key in ("branches", "wall_thickness_mm"):
        if key not in document:
            raise InputError("incomplete truth file", f"{path}: {key}", "missing", REGENERATE_REMEDY)
    wall = document["wall_thickness_mm"]
    if not isinstance(wall, (int, float)) or not 0 < wall < np.inf:
        raise InputError(
            "not a thickness", f"{path}: wall_thickness_mm", wall, f"a positive number; {REGENERATE_REMEDY}"
        )
    if not isinstance(document["branches"], list) or not document["branches"]:
        raise InputError("no branches in the truth file", f"{path}: branches", document["branches"], REGENERATE_REMEDY)
    for number, entry in enumerate(document["branches"], start=1):
        _check_branch(entry, f"{path}: branches[{number}]")


def _check_branch(entry, where):
    for key in ("name", "parent", "s_on_parent_mm", "lesions", *SAMPLE_DIMENSIONS):
        if not isinstance(entry, dict) or key not in entry:
            raise InputError("incomplete truth file", f"{where}.{key}", "missing", REGENERATE_REMEDY)
    count = len(entry["s_mm"]) if isinstance(entry["s_mm"], list) else 0
    for key, dimensions in SAMPLE_DIMENSIONS.items():
        try:
            values = np.array(entry[key], float)
        except (TypeError, ValueError):
            values = np.zeros(0)
        if values.shape != ((count,), (count, 3))[dimensions - 1] or count < 2 or not np.isfinite(values).all():
            wanted = f"{count} finite samples, as many as of s_mm"
            raise InputError(
                "samples that are none", f"{where}.{key}", f"shape {values.shape}", f"{wanted}; {REGENERATE_REMEDY}"
            )
        if key == "s_mm" and np.any(np.diff(values) <= 0):
            raise InputError(
                "arc lengths that do not rise", f"{where}.{key}", float(np.diff(values).min()), REGENERATE_REMEDY
            )
        if key.endswith("radius_mm") and values.min() <= 0:
            raise InputError("a radius that is not positive", f"{where}.{key}", float(values.min()), REGENERATE_REMEDY)


def load(path):
    """(branches, wall thickness mm) of the truth.json at `path`. Raises InputError if it is not one."""
    found = json_reader.read(path, "truth.json", "write it by data_synthetic generate").data
    schema = found.get("schema")
    if schema != SCHEMA:
        raise InputError("not a truth file", f"{path}: schema", schema, f"expected {SCHEMA}")
    check(found, path)
    branches = []
    for entry in found["branches"]:
        axis = Curve(entry["points_mm"])
        s = np.array(entry["s_mm"])

        def resampled(values):
            return np.interp(axis.s_mm, s, values)

        shift = np.array(entry["shift_mm"])
        branches.append(
            tree.Branch(
                entry["name"],
                entry["parent"],
                entry["s_on_parent_mm"],
                axis,
                resampled(entry["radius_mm"]),
                resampled(entry["healthy_radius_mm"]),
                np.stack([resampled(shift[:, k]) for k in range(3)], axis=1),
                entry["lesions"],
            )
        )
    return branches, found["wall_thickness_mm"]
