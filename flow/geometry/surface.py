"""The lumen surface: triangles with a region_id (0 wall, 1 inlet, 2 and above outlets), read and checked."""

import dataclasses

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from common.errors import InputError
from flow.geometry.vectors import unit

WALL, INLET = 0, 1


@dataclasses.dataclass
class Surface:
    """A closed surface: points (n, 3) in mm, outward triangles (m, 3), region (m,): their region ids."""

    points: np.ndarray
    triangles: np.ndarray
    region: np.ndarray

    @property
    def caps(self):
        """Region ids of inlet and outlets, ascending."""
        return [int(r) for r in np.unique(self.region) if r != WALL]

    def edges(self):
        """(edges (e, 2), side (m, 3)): undirected edges, and the numbers of the edges 01, 12, 20 of each triangle."""
        sides = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, inverse = np.unique(sides, axis=0, return_inverse=True)
        return edges, inverse.reshape(-1, 3)

    def area_vectors(self):
        """Area in mm2 times outward unit normal of each triangle, (m, 3)."""
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        return 0.5 * np.cross(b - a, c - a)

    def cap_circles(self):
        """{region id of a cap: (centre (3,), outward unit normal (3,), radius of the circle of its area)}, in mm."""
        vectors, centroids = self.area_vectors(), self.points[self.triangles].mean(axis=1)
        found = {}
        for cap in self.caps:
            own = self.region == cap
            weight, total = np.linalg.norm(vectors[own], axis=1), vectors[own].sum(axis=0)
            centre = (weight[:, None] * centroids[own]).sum(axis=0) / weight.sum()
            found[cap] = centre, unit(total), float(np.sqrt(weight.sum() / np.pi))
        return found

    def count_pieces(self, chosen):
        """Number of pieces that the triangles `chosen` (m,) bool make. Two pieces have no edge in common."""
        edges, side = self.edges()
        side = side[chosen]
        at = np.repeat(np.arange(len(side)), 3), side.ravel()
        graph = coo_matrix((np.ones(side.size), at), shape=(len(side), len(edges))).tocsr()
        return connected_components(graph @ graph.T, directed=False)[0]

    def volume_mm3(self):
        """Enclosed volume in mm3, by the divergence theorem."""
        centroid = self.points[self.triangles].mean(axis=1)
        return float(np.einsum("ij,ij->", centroid, self.area_vectors()) / 3.0)


def facets_at_edges(side):
    """Numbers (e, 2) of the two triangles at each edge of a closed surface. side (m, 3): from `Surface.edges`."""
    return np.argsort(side.ravel(), kind="stable").reshape(-1, 2) // 3


def border_edges(triangles):
    """Border of triangles (m, 3): the edges (r, 2) that only one triangle has, in the direction of this triangle."""
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    _, inverse, counts = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    return sides[counts[inverse] == 1]


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
    surface = Surface(*vtp.points_and_triangles(data), vtk_to_numpy(region).astype(int))
    check(surface, path)
    return surface


def check(surface, where):
    """Raises InputError unless a Surface, of the file `where`, can be meshed.

    It must be closed, of one piece, oriented outwards, with an inlet and an outlet, and in mm.
    """
    remedy = "process it with the anatomy step"
    wrong = np.flatnonzero(~np.isfinite(surface.points).all(axis=1))
    if len(wrong):
        raise InputError("point is not finite", f"{where}: point {wrong[0]}", surface.points[wrong[0]].tolist(), remedy)
    _, side = surface.edges()
    if np.any(np.bincount(side.ravel()) != 2):
        count = int(np.sum(np.bincount(side.ravel()) != 2))
        raise InputError("lumen surface is not closed", where, f"{count} edges without two triangles", remedy)
    pieces = surface.count_pieces(np.ones(len(surface.triangles), bool))
    if pieces > 1:
        raise InputError("lumen surface is not of one piece", where, f"{pieces} pieces", remedy)
    if surface.volume_mm3() <= 0:
        raise InputError("lumen surface is turned inside out", where, f"{surface.volume_mm3():.3g} mm3", remedy)
    if INLET not in surface.caps or len(surface.caps) < 2 or WALL not in surface.region or surface.region.min() < 0:
        present = sorted(set(surface.region.tolist()))
        raise InputError("tags missing or unknown in region_id", where, present, "give 0 wall, 1 inlet, 2.. outlets")
    areas = np.linalg.norm(surface.area_vectors(), axis=1)
    if areas.min() <= 0:
        raise InputError("lumen surface has triangles without area", where, int(areas.argmin()), remedy)
    for cap, (_, _, radius) in surface.cap_circles().items():
        if not 0.15 < radius < 8.0:
            value = f"cap {cap} has radius {radius:.4g}"
            raise InputError("implausible size of a lumen end", where, value, "coordinates must be in mm")
    _check_patches(surface, where, remedy)


def _check_patches(surface, where, remedy):
    """Raises InputError unless each cap is one connected patch of triangles that touches no other cap."""
    for cap in surface.caps:
        pieces = surface.count_pieces(surface.region == cap)
        if pieces > 1:
            raise InputError(
                "tag of a lumen end is not on one patch", where, f"region_id {cap}: {pieces} patches", remedy
            )
    tags = surface.region[facets_at_edges(surface.edges()[1])]
    touching = tags[(tags != WALL).all(axis=1) & (tags[:, 0] != tags[:, 1])]
    if len(touching):
        tags = sorted(touching[0].tolist())
        raise InputError("two lumen ends touch each other", where, f"region_id {tags[0]} and {tags[1]}", remedy)
