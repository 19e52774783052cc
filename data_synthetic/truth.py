"""truth.json: what is known exactly about a virtual patient, and back to branches."""

import json
import pathlib

import numpy as np

from common.errors import InputError

from . import calibre, disease, tree
from .curves import Curve

SCHEMA = "vci-truth-1"


def document(vessel, branches, rms_mm, vertices, triangles):
    """The JSON document: per branch its samples (mm), lesions with their true extent and stenosis, the wall."""
    forks = calibre.bifurcations(vessel)
    return {
        "schema": SCHEMA,
        "seed": vessel["seed"],
        "artery": vessel["artery"],
        "murray_exponent": vessel["murray_exponent"],
        "wall_thickness_mm": vessel["wall_thickness_mm"],
        "bifurcations": [vars(fork) for fork in forks],
        "surface": {"vertices": vertices, "triangles": triangles, "wall_error_rms_mm": rms_mm},
        "branches": [_branch(branch) for branch in branches],
    }


def _branch(branch):
    axis = branch.axis
    return {
        "name": branch.name,
        "parent": branch.parent,
        "s_on_parent_mm": branch.s_on_parent_mm,
        "length_mm": axis.length_mm,
        "mean_curvature_per_mm": float(axis.curvature(axis.s_mm).mean()),
        "lesions": [dict(lesion, **_measured(branch, lesion)) for lesion in branch.lesions],
        "s_mm": axis.s_mm.round(6).tolist(),
        "points_mm": axis.points_mm.round(9).tolist(),
        "radius_mm": branch.radius_mm.round(9).tolist(),
        "healthy_radius_mm": branch.healthy_mm.round(9).tolist(),
        "shift_mm": branch.shift_mm.round(9).tolist(),
    }


def _measured(branch, lesion):
    start, end = disease.extent(lesion)
    s = branch.axis.s_mm
    inside = (s >= start) & (s <= end)
    at = np.flatnonzero(inside)[np.argmin(branch.radius_mm[inside])]
    theta = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    thickness = branch.plaque_thickness(s[inside][:, None], theta[None])
    r = branch.radius_mm[inside][:, None]
    area = np.mean((r + thickness) ** 2 - r**2, axis=1) * np.pi
    return {
        "true_s_mla_mm": float(s[at]),
        "true_mla_mm2": float(np.pi * branch.radius_mm[at] ** 2),
        "true_diameter_stenosis_percent": float(100 * (1 - branch.radius_mm[at] / branch.healthy_mm[at])),
        "true_plaque_volume_mm3": float(np.sum(area) * (s[1] - s[0])),
    }


def load(path):
    """(branches, wall thickness mm) of the truth.json at `path`. Raises InputError if it is not one."""
    path = pathlib.Path(path)
    if not path.is_file():
        raise InputError("no such file", path, "missing", "run data_synthetic generate first")
    try:
        found = json.loads(path.read_text())
    except ValueError as error:
        raise InputError("not a JSON file", path, error, "run data_synthetic generate again") from error
    schema = found.get("schema") if isinstance(found, dict) else None
    if schema != SCHEMA:
        raise InputError("not a truth file", f"{path}: schema", schema, f"expected {SCHEMA}")
    missing = [key for key in ("branches", "wall_thickness_mm") if key not in found]
    if missing:
        raise InputError(
            "incomplete truth file", f"{path}: {missing[0]}", "missing", "run data_synthetic generate again"
        )
    branches = []
    for entry in found["branches"]:
        axis = Curve(entry["points_mm"])
        s = np.array(entry["s_mm"])

        def at(values):
            return np.interp(axis.s_mm, s, values)

        shift = np.array(entry["shift_mm"])
        branches.append(
            tree.Branch(
                entry["name"],
                entry["parent"],
                entry["s_on_parent_mm"],
                axis,
                at(entry["radius_mm"]),
                at(entry["healthy_radius_mm"]),
                np.stack([at(shift[:, k]) for k in range(3)], axis=1),
                entry["lesions"],
            )
        )
    return branches, found["wall_thickness_mm"]
