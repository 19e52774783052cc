"""Surfaces of lumens and devices as plain arrays, thinned out for pictures."""

import dataclasses

import numpy as np
import vtkmodules.vtkFiltersCore as filters

from common import vtp
from reports.inputs.reading import read_polydata


@dataclasses.dataclass(frozen=True)
class Surface:
    """Vertices (n, 3) in mm and triangles (m, 3)."""

    points: np.ndarray
    triangles: np.ndarray


def read_lumen(path, most_triangles):
    """The lumen as a Surface of at most about `most_triangles` triangles (quadric decimation)."""
    return to_surface(decimated(triangulated(read_polydata(path, "anatomy")), most_triangles))


def read_device(path):
    """A device as a Surface, without the lines in the file. None if the file holds no triangles."""
    polydata = triangulated(read_polydata(path, "vci deploy"))
    return to_surface(polydata) if polydata.GetNumberOfPolys() else None


def triangulated(polydata):
    """Only the triangles of a vtkPolyData; strips and polygons are cut into triangles."""
    triangle = filters.vtkTriangleFilter()
    triangle.SetInputData(polydata)
    triangle.PassLinesOff()
    triangle.PassVertsOff()
    triangle.Update()
    return triangle.GetOutput()


def decimated(polydata, most_triangles):
    """`polydata` with its triangles reduced to about `most_triangles`."""
    count = polydata.GetNumberOfPolys()
    if count <= most_triangles:
        return polydata
    decimate = filters.vtkQuadricDecimation()
    decimate.SetInputData(polydata)
    decimate.SetTargetReduction(1.0 - most_triangles / count)
    decimate.VolumePreservationOn()
    decimate.Update()
    return decimate.GetOutput()


def to_surface(polydata):
    """A triangulated vtkPolyData as a Surface."""
    return Surface(*vtp.points_and_triangles(polydata))
