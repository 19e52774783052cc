"""Values of a finite-element field at points.

The curved tetrahedron that contains a point is found first. Velocity is interpolated in it by P2, pressure by P1 basis
functions.
"""

import numpy as np
from scipy.spatial import cKDTree

from flow.geometry import tet10

CANDIDATE_CELLS = (
    60  # number of cells by the nearest centroids, so many since cells may be several times longer than wide
)
TRIED_CELLS = 4  # number of these for which the curved coordinates are computed: the best ones as straight-edged cells
NEWTON_STEPS = 3  # steps of Newton's method for the curved coordinates
LARGEST_STEP = 0.5  # largest change of a barycentric coordinate in one of these steps
# A point is outside the mesh if its least barycentric coordinate in the best cell is below this.
LEAST_COORDINATE = -0.25


class Locator:
    """Finds points in the cells of a quadratic mesh with nodes `points` (n, 3) and cells (t, 10), as geometry.tet10."""

    def __init__(self, points, cells):
        self.nodes, self.cells = points, cells
        corners = points[cells[:, :4]]
        self.origin = corners[:, 0]
        self.inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
        self.tree = cKDTree(corners.mean(axis=1))

    def find(self, points):
        """(cell (m,), barycentric coordinates (m, 4), inside (m,) bool) of points (m, 3).

        The coordinates of a point outside its cell are moved to the cell's surface.
        """
        _, cell = self.tree.query(points, k=min(CANDIDATE_CELLS, len(self.origin)))
        offset = points[:, None, :] - self.origin[cell]
        lam = _all_coordinates(np.einsum("mkij,mkj->mki", self.inverse[cell], offset))
        best = np.argsort(-lam.min(axis=2), axis=1, kind="stable")[:, :TRIED_CELLS]
        rows = np.arange(len(points))
        cell, lam = cell[rows[:, None], best], lam[rows[:, None], best]
        lam = self._curved_coordinates(points, cell, lam)
        best = np.argmax(lam.min(axis=2), axis=1)
        cell, lam = cell[rows, best], lam[rows, best]
        inside = lam.min(axis=1) > LEAST_COORDINATE
        lam = np.maximum(lam, 0)
        return cell, lam / lam.sum(axis=1, keepdims=True), inside

    def _curved_coordinates(self, points, cell, lam):
        """Barycentric coordinates (m, k, 4) of points (m, 3) in the curved cells `cell` (m, k), by Newton's method.

        lam (m, k, 4): the coordinates in the straight-edged cells, where it starts.
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
    """Velocity and pressure of a flow at points, in SI units.

    space: discretisation.spaces.LumenSpace; state (n,): velocity and pressure dofs over its mixed space W.
    """

    def __init__(self, space, state):
        self.points, self.cells = space.nodes()
        self.locator = Locator(self.points, self.cells)
        self.set_state(space, state)

    def set_state(self, space, state):
        """Takes another state (n,) over the same space."""
        self.velocity = state[space.v_map].reshape(-1, 3)
        self.pressure = space.nodal_pressure(state)

    def __call__(self, points):
        """(velocity (m, 3) in m/s, pressure (m,) in Pa, inside (m,) bool) at points (m, 3) in m."""
        cell, lam, inside = self.locator.find(points)
        velocity = np.einsum("mn,mnd->md", tet10.basis(lam), self.velocity[self.cells[cell]])
        pressure = np.einsum("mn,mn->m", lam, self.pressure[self.cells[cell][:, :4]])
        return velocity, pressure, inside
