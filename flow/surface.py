"""The tagged lumen surface: triangles with region_id 0 wall, 1 inlet, 2.. outlets; read and checked."""

import dataclasses

import numpy as np
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from common.errors import InputError

WALL, INLET = 0, 1


@dataclasses.dataclass
class Surface:
    """points (n, 3) in mm, triangles (m, 3) oriented outwards, region (m,) ids."""

    points: np.ndarray
    triangles: np.ndarray
    region: np.ndarray

    @property
    def caps(self):
        """Region ids of inlet and outlets, ascending."""
        return [int(r) for r in np.unique(self.region) if r != WALL]

    def edges(self):
        """Undirected edges (e, 2), the edge of each triangle side (m, 3) in the order 01, 12, 20."""
        sides = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, inverse = np.unique(sides, axis=0, return_inverse=True)
        return edges, inverse.reshape(-1, 3)

    def area_vectors(self):
        """Area times outward normal of each triangle, (m, 3)."""
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        return 0.5 * np.cross(b - a, c - a)

    def volume_mm3(self):
        """Enclosed volume by the divergence theorem."""
        centroid = self.points[self.triangles].mean(axis=1)
        return float(np.einsum("ij,ij->", centroid, self.area_vectors()) / 3.0)


def read(path):
    """Surface from lumen.vtp, checked by `check`. Raises InputError."""
    data = vtp.read(path, "make it with the anatomy step")
    region = data.GetCellData().GetArray("region_id")
    if region is None:
        raise InputError(
            "lumen surface has no tags", path, "no cell array region_id", "process it with the anatomy step"
        )
    if data.GetNumberOfCells() == 0 or data.GetNumberOfCells() != data.GetNumberOfPolys():
        raise InputError("lumen surface is not made of triangles", path, data.GetNumberOfCells(), "triangulate it")
    if data.GetPolys().GetMaxCellSize() != 3:
        raise InputError("lumen surface is not made of triangles", path, "polygons", "triangulate it")
    surface = Surface(*vtp.arrays(data), vtk_to_numpy(region).astype(int))
    check(surface, path)
    return surface


def check(surface, where):
    """Closed, oriented outwards, tagged with an inlet and an outlet, and in mm; else InputError."""
    remedy = "process it with the anatomy step"
    _, side = surface.edges()
    if np.any(np.bincount(side.ravel()) != 2):
        count = int(np.sum(np.bincount(side.ravel()) != 2))
        raise InputError("lumen surface is not closed", where, f"{count} edges without two triangles", remedy)
    if surface.volume_mm3() <= 0:
        raise InputError("lumen surface is turned inside out", where, f"{surface.volume_mm3():.3g} mm3", remedy)
    if INLET not in surface.caps or len(surface.caps) < 2 or WALL not in surface.region:
        present = sorted(set(surface.region.tolist()))
        raise InputError("tags missing in region_id", where, present, "0 wall, 1 inlet, 2.. outlets are needed")
    areas = np.linalg.norm(surface.area_vectors(), axis=1)
    for cap in surface.caps:
        radius = np.sqrt(areas[surface.region == cap].sum() / np.pi)
        if not 0.15 < radius < 8.0:
            value = f"cap {cap} has radius {radius:.4g}"
            raise InputError("implausible size of a lumen end", where, value, "coordinates must be in mm")
    if areas.min() <= 0:
        raise InputError("lumen surface has triangles without area", where, int(areas.argmin()), remedy)
