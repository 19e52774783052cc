"""Values of a finite-element field at points: the containing curved tetrahedron, then P2 or P1 basis."""

import numpy as np
from scipy.spatial import cKDTree

from flow.geometry import tet10

CANDIDATES = 60  # nearest centroids: cells may be several times longer than wide
TRIED = 4  # of them, the best by their corners, in which the curved cell's coordinates are sought
STEPS = 3  # of Newton's method for the curved cell's coordinates
FURTHEST = 0.5  # barycentric step
OUTSIDE = -0.25  # least barycentric coordinate of a point that counts as inside


class Locator:
    """Finds points in the cells of a quadratic mesh: points (n, 3), cells (t, 10) as geometry.tet10."""

    def __init__(self, points, cells):
        self.nodes, self.cells = points, cells
        corners = points[cells[:, :4]]
        self.origin = corners[:, 0]
        self.inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
        self.tree = cKDTree(corners.mean(axis=1))

    def find(self, points):
        """(cell (m,), barycentric coordinates (m, 4), inside (m,) bool); coordinates are clipped to the tetrahedron."""
        _, cell = self.tree.query(points, k=min(CANDIDATES, len(self.origin)))
        offset = points[:, None, :] - self.origin[cell]
        lam = _complete(np.einsum("mkij,mkj->mki", self.inverse[cell], offset))
        best = np.argsort(-lam.min(axis=2), axis=1, kind="stable")[:, :TRIED]
        rows = np.arange(len(points))
        cell, lam = cell[rows[:, None], best], lam[rows[:, None], best]
        lam = self._curved(points, cell, lam)
        best = np.argmax(lam.min(axis=2), axis=1)
        cell, lam = cell[rows, best], lam[rows, best]
        inside = lam.min(axis=1) > OUTSIDE
        lam = np.maximum(lam, 0)
        return cell, lam / lam.sum(axis=1, keepdims=True), inside

    def _curved(self, points, cell, lam):
        """Barycentric coordinates (m, k, 4) in the curved cells (m, k), by Newton's method from the straight."""
        nodes = self.nodes[self.cells[cell]]
        for _ in range(STEPS):
            gap = points[:, None] - np.einsum("mkn,mknd->mkd", tet10.basis(lam), nodes)
            jacobian = np.einsum("mknd,mknr->mkdr", nodes, tet10.gradients(lam))
            singular = np.abs(np.linalg.det(jacobian)) < 1e-300
            jacobian[singular] = np.eye(3)
            step = np.linalg.solve(jacobian, gap[..., None])[..., 0]
            step[singular] = 0.0
            size = np.abs(step).max(axis=2, keepdims=True)
            lam = _complete(lam[..., 1:] + step * np.minimum(1.0, FURTHEST / np.maximum(size, 1e-300)))
        return lam


def _complete(lam):
    """All four barycentric coordinates of the last three."""
    return np.concatenate([1 - lam.sum(axis=-1, keepdims=True), lam], axis=-1)


class FieldSampler:
    """Velocity and pressure of a state at points, in SI."""

    def __init__(self, space, state):
        self.points, self.cells = space.nodes()
        self.locator = Locator(self.points, self.cells)
        self.take(space, state)

    def take(self, space, state):
        """Samples another state (n,) of the same space from now on."""
        self.velocity = state[space.v_map].reshape(-1, 3)
        self.pressure = space.nodal_pressure(state)

    def __call__(self, points):
        """(velocity (m, 3), pressure (m,), inside (m,)) at points (m, 3) in m."""
        cell, lam, inside = self.locator.find(points)
        velocity = np.einsum("mn,mnd->md", tet10.basis(lam), self.velocity[self.cells[cell]])
        pressure = np.einsum("mn,mn->m", lam, self.pressure[self.cells[cell][:, :4]])
        return velocity, pressure, inside
