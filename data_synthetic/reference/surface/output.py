"""Checks the moved lumen surface for folds, and gives it the arrays of the surface before the move."""

import numpy as np
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from common.errors import ComputationError


def _normals(points, triangles):
    return np.cross(
        points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]]
    )


def check_not_folded(triangles, before, after):
    """Raises ComputationError if more than a thousandth of the triangles (m, 3) turned over.

    before, after (n, 3): points before and after the move.
    """
    a, b = _normals(before, triangles), _normals(after, triangles)
    cosine = np.sum(a * b, axis=1) / np.maximum(np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1), 1e-30)
    # When a lesion is opened, triangles on its shoulders turn by up to 45 degrees. Only a triangle that turns over is a
    # fold.
    folded = np.flatnonzero(cosine < 0)
    if len(folded) > 1e-3 * len(triangles):
        place = np.round(before[triangles[folded[np.argmin(cosine[folded])]]].mean(axis=0), 2).tolist()
        raise ComputationError(
            "the moved lumen is folded",
            "reference lumen",
            f"{len(folded)} of {len(triangles)} triangles turned over, the most near {place} mm",
            "move devices off the bend",
        )


def refined_surface(poly, before, after, triangles, parents, old_triangle):
    """vtkPolyData of the refined and moved lumen, with all arrays of poly and `displacement_mm`.

    before, after (n, 3): all points before and after the move. parents (p, 2): ends of the edge that each new point
    halves. old_triangle (m,): index of the triangle of poly in which each triangle lies. At a new point a real array
    gets the mean of both ends of the edge. An integer array gets the value at the first end.
    """
    result = vtp.surface(after, triangles)
    data = poly.GetPointData()
    for index in range(data.GetNumberOfArrays()):
        values = vtk_to_numpy(data.GetArray(index))
        grown = np.empty((len(before),) + values.shape[1:], values.dtype)
        grown[: len(values)] = values
        for number, (a, b) in enumerate(parents, start=len(values)):
            grown[number] = 0.5 * (grown[a] + grown[b]) if values.dtype.kind == "f" else grown[a]
        vtp.add_array(result.GetPointData(), data.GetArray(index).GetName(), grown)
    vtp.add_array(result.GetPointData(), "displacement_mm", after - before)
    data = poly.GetCellData()
    for index in range(data.GetNumberOfArrays()):
        values = vtk_to_numpy(data.GetArray(index))[old_triangle]
        vtp.add_array(result.GetCellData(), data.GetArray(index).GetName(), values)
    return result
