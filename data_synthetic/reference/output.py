"""The moved lumen surface: read, checked, written with all its arrays."""

import pathlib

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from common.errors import ComputationError, InputError

from ..surface import to_poly


def read_lumen(path):
    """vtkPolyData of triangles. Raises InputError if the file is missing or holds anything else."""
    path = pathlib.Path(path)
    if not path.is_file():
        raise InputError("no such file", path, "missing", "run the anatomy step first")
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    poly = reader.GetOutput()
    if poly.GetNumberOfPolys() == 0 or poly.GetPolys().GetMaxCellSize() != 3:
        raise InputError("not a triangle surface", path, f"{poly.GetNumberOfPolys()} cells", "give closed triangles")
    return poly


def points(poly):
    """Points (n, 3) in mm."""
    return vtk_to_numpy(poly.GetPoints().GetData()).astype(float)


def triangles(poly):
    """Triangles (m, 3)."""
    return vtk_to_numpy(poly.GetPolys().GetConnectivityArray()).reshape(-1, 3)


def _normals(x, t):
    return np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]])


def check_not_folded(t, before, after):
    """Raises ComputationError if more than a thousandth of the triangles t (m, 3) turned over or vanished."""
    a, b = _normals(before, t), _normals(after, t)
    cosine = np.sum(a * b, axis=1) / np.maximum(np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1), 1e-30)
    # The lesion's shoulders turn by up to 45 degrees when it is opened; the other way round means a fold.
    folded = int(np.sum(cosine < 0))
    if folded > 1e-3 * len(t):
        raise ComputationError(
            "the moved lumen is folded",
            "reference lumen",
            f"{folded} of {len(t)} triangles",
            "move devices off the bend",
        )


def _named(values, name):
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    return array


def refined_surface(poly, before, after, triangles_now, parents, old_triangle):
    """vtkPolyData of the refined and moved lumen with all arrays of poly and `displacement_mm`.

    before, after (n, 3): all points; parents (p, 2): the edge that each new point halved; old_triangle (m,): index into
    poly's triangles. Reals are averaged over an edge, integers taken from its first end.
    """
    result = to_poly(after, triangles_now)
    data = poly.GetPointData()
    for index in range(data.GetNumberOfArrays()):
        values = vtk_to_numpy(data.GetArray(index))
        grown = np.empty((len(before),) + values.shape[1:], values.dtype)
        grown[: len(values)] = values
        for number, (a, b) in enumerate(parents, start=len(values)):
            grown[number] = 0.5 * (grown[a] + grown[b]) if values.dtype.kind == "f" else grown[a]
        result.GetPointData().AddArray(_named(grown, data.GetArray(index).GetName()))
    result.GetPointData().AddArray(_named(after - before, "displacement_mm"))
    data = poly.GetCellData()
    for index in range(data.GetNumberOfArrays()):
        values = vtk_to_numpy(data.GetArray(index))[old_triangle]
        result.GetCellData().AddArray(_named(values, data.GetArray(index).GetName()))
    return result


def write_lumen(poly, vtp, stl):
    """Writes the surface as VTP and binary STL."""
    for writer, path in ((vtk.vtkXMLPolyDataWriter(), vtp), (vtk.vtkSTLWriter(), stl)):
        writer.SetFileName(str(path))
        writer.SetInputData(poly)
        if isinstance(writer, vtk.vtkSTLWriter):
            writer.SetFileTypeToBinary()
        writer.Write()
