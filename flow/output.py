"""Files of a solve: solution.vtu (quadratic tetrahedra, mm), ffr.json, pullback.csv."""

import os
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

from common.errors import InputError, WriteError
from common.files import replacing, write_json
from flow.geometry import tet10
from flow.physics.units import MM_PER_M

FILES = ("ffr.json", "pullback.csv", "solution.vtu")


def remove_old_output(files, inputs):
    """Removes the output `files` of an earlier run, which would be taken for output of this run if it is refused.

    inputs: paths of the files that the command reads. Raises InputError, and removes nothing, if one of them is among
    `files`, if two of `files` are the same, or if `files` cannot be written.
    """
    resolved = [path.resolve() for path in files]
    for k, path in enumerate(resolved):
        if path in resolved[:k]:
            raise InputError("a file would replace another", "output", files[k], "give each its own name")
    for path in inputs:
        if path.resolve() in resolved:
            raise InputError("an input would be replaced by its answer", "--out", path, "give another name or folder")
    for path in files:
        if path.is_dir():
            raise InputError("a file cannot replace a folder", path, "a folder", "give another name")
        existing = next(place for place in path.absolute().parents if place.exists())
        if not existing.is_dir() or not os.access(existing, os.W_OK | os.X_OK):
            value = f"{existing} is no folder to write to: give another"
            raise InputError("no folder for the answer", "--out", path.parent, value)
    for path in files:
        path.unlink(missing_ok=True)


def print_warnings(warnings):
    """Prints the warnings [str] of a command."""
    for one in warnings:
        print(one, file=sys.stderr, flush=True)


def write_vtu(path, points, cells, fields):
    """Writes a mesh and fields at its nodes to a .vtu file, with coordinates in mm.

    points (n, 3) in m, cells (t, 10) ordered as in geometry.tet10, fields {name: values (n,) or (n, 3)}.
    """
    grid = vtk.vtkUnstructuredGrid()
    vtk_points = vtk.vtkPoints()
    vtk_points.SetDataTypeToDouble()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(points * MM_PER_M), deep=True))
    grid.SetPoints(vtk_points)
    array = vtk.vtkCellArray()
    connectivity = np.ascontiguousarray(cells[:, tet10.VTK_ORDER]).ravel().astype(np.int64)
    offsets = np.arange(0, connectivity.size + 1, 10, dtype=np.int64)
    array.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(connectivity, deep=True))
    grid.SetCells(vtk.VTK_QUADRATIC_TETRA, array)
    for name, values in fields.items():
        data = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        data.SetName(name)
        grid.GetPointData().AddArray(data)
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    with replacing(path) as partial:
        writer.SetFileName(str(partial))
        if writer.Write() != 1:
            raise WriteError(path, "VTK's writer failed")


def write_all(folder, fields, table, document):
    """Writes the three output files of a solve to a folder (Path). ffr.json is the last, as a sign that all are there.

    fields: arguments (points, cells, fields) of write_vtu; table: DataFrame of pullback.csv; document: content of
    ffr.json.
    """
    write_vtu(folder / "solution.vtu", *fields)
    with replacing(folder / "pullback.csv") as partial:
        table.to_csv(partial, index=False, float_format="%.10g")
    write_json(folder / "ffr.json", document)
