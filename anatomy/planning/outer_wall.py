"""Healthy diameters of a vessel with a known outer wall: the lumen plus its plaque.

Intravascular contours with an outer wall give the plaque's thickness beyond a healthy wall. Twice its mean round a
section, added to the lumen's diameter, gives the diameter that the vessel would have without plaque. This is the
reference. A line fitted through the lumen's diameters would be too small in diffuse disease, where no diameter is
healthy.

Where the wall was not traced, lumen.vtp has a thickness that was estimated from the narrowing. The reference there is
the diameter of the healthy profile, or the lumen's own diameter if that is larger.
"""

import numpy as np
from scipy.spatial import cKDTree
from vtkmodules.util.numpy_support import vtk_to_numpy

from common import vtp

WALL = 0  # region_id (docs/design.md)


def has_traced_wall(case):
    """Whether a case's lumen (its document as a dict) comes with a traced outer wall."""
    return "outer_wall" in case.get("lumen", {}).get("contours", {})


def with_lumen_and_plaque_reference(sections, lumen_file):
    """The sections with each reference_diameter_mm replaced by the diameter of lumen and plaque together.

    sections: result of lumen_results.read_sections(). lumen_file: lumen.vtp, which has the plaque's thickness at its
    points.
    """
    data = vtp.read(lumen_file, "run `lumen process` first")
    points, triangles = vtp.points_and_triangles(data)
    region = vtk_to_numpy(data.GetCellData().GetArray("region_id"))
    wall = np.unique(triangles[region == WALL])
    plaque = vtk_to_numpy(data.GetPointData().GetArray("plaque_thickness_mm"))[wall]
    rows = [row for branch in sections.values() for row in branch]
    centres = np.array([[row[key] for key in ("x_mm", "y_mm", "z_mm")] for row in rows])
    nearest = cKDTree(centres).query(points[wall])[1]
    count = np.bincount(nearest, minlength=len(rows))
    mean = np.bincount(nearest, weights=plaque, minlength=len(rows)) / np.maximum(count, 1)
    for row, thickness, points_near in zip(rows, mean, count):
        row["plaque_mm"] = float(thickness) if points_near else None
    return {
        name: [_with_reference(row, _plaque_mm(branch, k)) for k, row in enumerate(branch)]
        for name, branch in sections.items()
    }


def _plaque_mm(branch, k):
    """Mean plaque thickness (mm) at a branch's k-th section.

    It is interpolated between other sections if no point of the wall is nearest to this one.
    """
    measured = [(row["s_mm"], row["plaque_mm"]) for row in branch if row["plaque_mm"] is not None]
    return float(np.interp(branch[k]["s_mm"], *zip(*measured)))


def _with_reference(row, plaque_mm):
    return row | {"reference_diameter_mm": row["equivalent_diameter_mm"] + 2 * plaque_mm}
