"""Makes a synthetic case's lumen surface and truth.json, its exact geometry."""

import sys

import numpy as np

from common import vtp
from common.errors import ComputationError, InputError
from common.files import write_json
from common.implicit import surface
from common.implicit.field import LumenField
from common.patient.plaque_types import CALCIFIED, NONE

from . import crossings, patient, tree, truth

GRID_SPACING_MM = 0.2  # spacing of the grid on which the surface is first found
LARGEST_RMS_ERROR_MM = 0.001  # root mean square distance of the surface's wall points from the exact wall


def plaque_at(field, points_mm):
    """(thickness mm (n,), type (n,)) of the plaque behind wall points (n, 3), by the nearest branch of a LumenField.

    A side branch first runs through the plaque of its parent. There the parent's plaque surrounds the side branch, and
    reaches from the point to the parent's healthy wall.
    """
    branches = field.branches
    behind = {b.name: _plaque_of_branch(field, number, points_mm) for number, b in enumerate(branches)}
    nearest = np.argmin([distance for _, distance, _ in behind.values()], axis=0)
    thickness, kind = np.zeros(len(points_mm)), np.zeros(len(points_mm), np.int32)
    for number, branch in enumerate(branches):
        own = nearest == number
        thickness[own], kind[own] = behind[branch.name][0][own], behind[branch.name][2][own]
        if branch.parent:
            of_parent, beyond_lumen, kind_of_parent = behind[branch.parent]
            remaining = of_parent - beyond_lumen
            thicker = own & (remaining > thickness)
            thickness[thicker], kind[thicker] = remaining[thicker], kind_of_parent[thicker]
    thickness = np.where(thickness > 0.01, thickness, 0.0)
    return thickness, np.where(thickness > 0, kind, NONE)


def _plaque_of_branch(field, number, points_mm):
    """(thickness mm (n,) of a branch's plaque, distance mm (n,) from its lumen's wall, type (n,)) at points (n, 3)."""
    branch = field.branches[number]
    s = np.clip(branch.axis.nearest(points_mm), 0, branch.axis.length_mm)
    offset = points_mm - branch.axis.point(s)
    _, normal, binormal = branch.axis.frame(s)
    theta = np.arctan2(np.sum(offset * binormal, axis=1), np.sum(offset * normal, axis=1))
    kind = np.where(branch.calcium_share(s, theta) > 0.5, CALCIFIED, branch.uncalcified_type(s))
    return branch.plaque_thickness(s, theta), np.abs(field.branch_value(number, points_mm)), kind


def check_narrowest_radius(field, spacing_mm, where):
    """Raises InputError if the lumen of a LumenField is too narrow for the grid of spacing_mm.

    A narrower lumen might lie between the grid's points, with none inside. The surface would miss it.
    """
    least_radius_mm = 0.5 * 3**0.5 * spacing_mm  # half the diagonal of a cell
    for branch in field.branches:
        depth_mm = -field.value(branch.axis.points_mm)
        narrowest = int(np.argmin(depth_mm))
        if depth_mm[narrowest] < least_radius_mm:
            raise InputError(
                "throat too narrow for the surface's grid",
                f"{where}.lesions",
                f"radius {depth_mm[narrowest]:.3f} mm at {branch.axis.s_mm[narrowest]:.1f} mm of {branch.name}",
                f"at least {least_radius_mm:.3f} mm: a milder lesion",
            )


def run(case_path, out, spacing_mm=GRID_SPACING_MM):
    """Writes `out`/lumen.vtp and `out`/truth.json for the case at `case_path`; returns the document of truth.json.

    Raises InputError for a patient that cannot be built. Raises ComputationError if the surface is not exact or crosses
    itself.
    """
    case = patient.load(case_path)
    print("growing the tree", file=sys.stderr)
    branches = tree.grow(case["vessel"], f"{case_path}: vessel")
    field = LumenField(branches)
    check_narrowest_radius(field, spacing_mm, f"{case_path}: vessel")
    print("meshing the lumen", file=sys.stderr)
    points, triangles, on_cap = surface.build(field, spacing_mm)
    rms = float(np.sqrt(np.mean(field.value(points[~on_cap]) ** 2)))
    if rms > LARGEST_RMS_ERROR_MM:
        raise ComputationError(
            "the surface misses the implicit lumen", "lumen surface", f"{rms:.2g} mm rms", "a finer generation spacing"
        )
    crossing = crossings.crossing_pairs(points, triangles)
    if len(crossing):
        place = np.round(points[triangles[crossing[0, 0]]].mean(axis=0), 2).tolist()
        what, value = "the surface crosses itself", f"{len(crossing)} pairs of triangles, first near {place} mm"
        raise ComputationError(what, "lumen surface", value, "another seed, or branches farther apart")
    thickness, kind = plaque_at(field, points)
    poly = vtp.surface(points, triangles)
    for name, values in (("plaque_thickness_mm", thickness), ("plaque_type", kind.astype(np.int32))):
        vtp.add_array(poly.GetPointData(), name, values)
    document = truth.document(case["vessel"], branches, rms, len(points), len(triangles))
    vtp.write(out / "lumen.vtp", poly)
    write_json(out / "truth.json", document)
    return document
