"""Values of a finite-element field at points.

The curved tetrahedron that contains a point is found first. Velocity is interpolated in it by P2, pressure by P1 basis
functions.
"""

import numpy as np
from scipy.spatial import cKDTree

from flow.geometry import tet10

# A point is searched in the FEW_CELLS cells with the nearest centroids, and if it is in none of them in MANY_CELLS.
# Cells may be several times longer than wide, so the right cell's centroid may be far. Points outside the mesh also
# need many.
FEW_CELLS, MANY_CELLS = 8, 60
POINTS_AT_ONCE = 20_000  # limits the memory
# Curved coordinates are costly. So they are computed only in this many of these cells: those that fit the point best if
# their edges are taken as straight.
TRIED_CELLS = 4
NEWTON_STEPS = 3  # steps of Newton's method for the curved coordinates
LARGEST_STEP = 0.5  # largest change of a barycentric coordinate in one step of Newton's method
# A point is outside the mesh if its least barycentric coordinate in the best cell is below this.
LEAST_COORDINATE = -0.25


class Locator:
    """Finds the cell of a mesh of curved quadratic tetrahedra in which a point lies.

    nodes (n, 3): the mesh's nodes; cells (t, 10): numbers of their nodes, in the order of geometry.tet10.
    """

    def __init__(self, nodes, cells):
        self.nodes, self.cells = nodes, cells
        corners = nodes[cells[:, :4]]
        self.origin = corners[:, 0]
        self.inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
        self.tree = cKDTree(corners.mean(axis=1))

    def find(self, points):
        """(cell (m,), barycentric coordinates (m, 4), inside (m,) bool) of points (m, 3).

        A point that lies in none of the tried cells gets the one that it is least outside of. Its coordinates are then
        moved to this cell's surface.
        """
        cell, lam = np.empty(len(points), int), np.full((len(points), 4), -np.inf)
        for candidates in (FEW_CELLS, MANY_CELLS):
            left = np.flatnonzero(lam.min(axis=1) < 0)
            for first in range(0, len(left), POINTS_AT_ONCE):
                part = left[first : first + POINTS_AT_ONCE]
                cell[part], lam[part] = self._best_cells(points[part], candidates)
        inside = lam.min(axis=1) > LEAST_COORDINATE
        lam = np.maximum(lam, 0)
        return cell, lam / lam.sum(axis=1, keepdims=True), inside

    def _best_cells(self, points, candidates):
        """(cell (m,), barycentric coordinates (m, 4)): the cell in which each of points (m, 3) lies, or least outside.

        candidates: number of cells with the nearest centroids that are tried.
        """
        _, cell = self.tree.query(points, k=np.arange(1, min(candidates, len(self.origin)) + 1))
        offset = points[:, None, :] - self.origin[cell]
        lam = _all_coordinates(np.einsum("mkij,mkj->mki", self.inverse[cell], offset))
        best = np.argsort(-lam.min(axis=2), axis=1, kind="stable")[:, :TRIED_CELLS]
        rows = np.arange(len(points))
        cell, lam = cell[rows[:, None], best], lam[rows[:, None], best]
        lam = self._curved_coordinates(points, cell, lam)
        best = np.argmax(lam.min(axis=2), axis=1)
        return cell[rows, best], lam[rows, best]

    def _curved_coordinates(self, points, cell, lam):
        """Barycentric coordinates (m, k, 4) of points (m, 3) in the curved cells `cell` (m, k), by Newton's method.

        lam (m, k, 4): the coordinates in the straight-edged cells, from which Newton's method starts.
        """
        nodes = self.nodes[self.cells[cell]]
        for _ in range(NEWTON_STEPS):
            gap = points[:, None] - np.einsum("mkn,mknd->mkd", tet10.basis(lam), nodes)
            jacobian = np.einsum("mknd,mknr->mkdr", nodes, tet10.gradients(lam))
            singular = np.abs(np.linalg.det(jacobian)) < 1e-300
            jacobian[singular] = np.eye(3)
            step = np.linalg.solve(jacobian, gap[..., None])[..., 0]
            step[singular] = 0.0
            size = np.abs(step).max(axis=2, keepdims=True)
            lam = _all_coordinates(lam[..., 1:] + step * np.minimum(1.0, LARGEST_STEP / np.maximum(size, 1e-300)))
        return lam


def _all_coordinates(lam):
    """All four barycentric coordinates (..., 4) from the last three (..., 3)."""
    return np.concatenate([1 - lam.sum(axis=-1, keepdims=True), lam], axis=-1)


class FieldSampler:
    """Velocity and pressure of a flow at points, in the unit of the nodes of `locator` (Locator).

    velocity (n, 3) in m/s and pressure (n,) in Pa are the values at these nodes.
    """

    def __init__(self, locator, velocity, pressure):
        self.locator, self.velocity, self.pressure = locator, velocity, pressure

    def __call__(self, points):
        """(velocity (m, 3) in m/s, pressure (m,) in Pa, inside (m,) bool) at points (m, 3)."""
        cell, lam, inside = self.locator.find(points)
        nodes = self.locator.cells[cell]
        velocity = np.einsum("mn,mnd->md", tet10.basis(lam), self.velocity[nodes])
        return velocity, np.einsum("mn,mn->m", lam, self.pressure[nodes[:, :4]]), inside
