"""Triangle surfaces and lines in VTK files: read with checks, written whole or not at all, as plain arrays."""

import pathlib

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

from common.errors import InputError, WriteError
from common.files import replacing


def read(path, remedy):
    """The vtkPolyData in a .vtp file. Raises InputError, with `remedy`, if it is missing or holds no points."""
    path = pathlib.Path(path)
    if not path.is_file():
        raise InputError("no such file", path, "missing", remedy)
    reader = vtk.vtkXMLPolyDataReader()
    if not reader.CanReadFile(str(path)):
        raise InputError("not a VTK file of surfaces or lines", path, path.suffix, remedy)
    reader.SetFileName(str(path))
    reader.Update()
    poly = reader.GetOutput()
    if poly.GetNumberOfPoints() == 0:
        raise InputError("nothing in the file", path, "no points", remedy)
    return poly


def read_triangles(path, remedy):
    """The vtkPolyData in a .vtp file of triangles, read and checked as by `read`.

    Also raises InputError if there are no polygons, or one with more than three corners.
    """
    poly = read(path, remedy)
    if poly.GetNumberOfPolys() == 0 or poly.GetPolys().GetMaxCellSize() != 3:
        raise InputError("not a triangle surface", path, f"{poly.GetNumberOfPolys()} cells", "give closed triangles")
    return poly


def points(poly):
    """Points (n, 3) of a vtkPolyData, in its unit."""
    return vtk_to_numpy(poly.GetPoints().GetData()).astype(float)


def triangles(poly):
    """Triangles (m, 3) of a vtkPolyData without other polygons, as vertex indices."""
    return vtk_to_numpy(poly.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64)


def points_and_triangles(poly):
    """(points (n, 3), triangles (m, 3)) of a vtkPolyData without other polygons."""
    return points(poly), triangles(poly)


def lines(poly):
    """The lines of a vtkPolyData, each an array of vertex indices."""
    cells = poly.GetLines()
    if cells.GetNumberOfCells() == 0:
        return []
    corners = vtk_to_numpy(cells.GetConnectivityArray())
    return np.split(corners, vtk_to_numpy(cells.GetOffsetsArray())[1:-1])


def read_named_lines(path, remedy):
    """{branch name: points (n, 3) mm} of a centreline.vtp. Raises InputError with `remedy` for any other file."""
    poly = read(path, remedy)
    names = poly.GetCellData().GetAbstractArray("branch_name")
    if poly.GetNumberOfLines() == 0 or names is None:
        raise InputError("not a centreline", path, "no lines with branch_name", remedy)
    at = points(poly)
    return {names.GetValue(k): at[line] for k, line in enumerate(lines(poly))}


def surface(points_mm, corners):
    """vtkPolyData (double precision) of points (n, 3) and triangles (m, 3)."""
    poly, vtk_points, cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    vtk_points.SetDataTypeToDouble()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(points_mm, float), deep=True))
    offsets = np.arange(0, 3 * len(corners) + 1, 3, dtype=np.int64)
    connectivity = np.ascontiguousarray(corners, np.int64).ravel()
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(connectivity, deep=True))
    poly.SetPoints(vtk_points)
    poly.SetPolys(cells)
    return poly


def add_array(attributes, name, values):
    """Adds values (n,) or (n, k) under a name to the point or cell data of a vtkPolyData."""
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    attributes.AddArray(array)


def write(path, poly):
    """Writes a vtkPolyData as .vtp, or as binary STL by the suffix .stl. Raises WriteError if VTK cannot."""
    stl = pathlib.Path(path).suffix == ".stl"
    writer = vtk.vtkSTLWriter() if stl else vtk.vtkXMLPolyDataWriter()
    if stl:
        writer.SetFileTypeToBinary()
    with replacing(path) as partial:
        writer.SetFileName(str(partial))
        writer.SetInputData(poly)
        if writer.Write() != 1:
            raise WriteError(path, "VTK's writer failed")
