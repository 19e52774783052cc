"""Writes truth.json, the exact geometry of a virtual patient, and reads it back as branches."""

import numpy as np

from common.documents import json_reader, schema
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
SAMPLED = ("points_mm", "radius_mm", "healthy_radius_mm", "shift_mm")  # lists with an entry for each one of s_mm


def _check_samples(branch, where):
    """Raises InputError unless a branch's arc lengths rise, and every other list has as many samples."""
    least = float(np.diff(branch["s_mm"]).min())
    if least <= 0:
        raise InputError("arc lengths that do not rise", f"{where}.s_mm", least, REGENERATE_REMEDY)
    count = len(branch["s_mm"])
    for key in SAMPLED:
        if len(branch[key]) != count:
            remedy = f"{count} samples, as many as of s_mm; {REGENERATE_REMEDY}"
            raise InputError("another number of samples", f"{where}.{key}", len(branch[key]), remedy)


def load(path):
    """(branches, wall thickness mm) of the truth.json at `path`. Raises InputError if it is not one."""
    found = json_reader.read(path, "truth.json", "write it by data_synthetic generate")
    schema.validate(found, schema.read("truth"), "a truth file", REGENERATE_REMEDY)
    branches = []
    for number, entry in enumerate(found.data["branches"]):
        _check_samples(entry, found.where(("branches", number)))
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
    return branches, found.data["wall_thickness_mm"]
