"""Values of a finite-element field at points: the containing tetrahedron by nearest centroids, then P2 or P1 basis."""

import numpy as np
from scipy.spatial import cKDTree

from flow import tet10

CANDIDATES = 40
OUTSIDE = (
    -0.25
)  # least barycentric coordinate of a point that counts as inside (curved cells bulge beyond their corners)


class Locator:
    """Finds points in the corner tetrahedra of a quadratic mesh: points (n, 3), cells (t, 10) as flow.tet10."""

    def __init__(self, points, cells):
        corners = points[cells[:, :4]]
        self.origin = corners[:, 0]
        self.inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
        self.tree = cKDTree(corners.mean(axis=1))

    def find(self, points):
        """(cell (m,), barycentric coordinates (m, 4), inside (m,) bool); coordinates are clipped to the tetrahedron."""
        _, cell = self.tree.query(points, k=min(CANDIDATES, len(self.origin)))
        offset = points[:, None, :] - self.origin[cell]
        lam = np.einsum("mkij,mkj->mki", self.inverse[cell], offset)
        lam = np.concatenate([1 - lam.sum(axis=2, keepdims=True), lam], axis=2)
        best = np.argmax(lam.min(axis=2), axis=1)
        rows = np.arange(len(points))
        cell, lam = cell[rows, best], lam[rows, best]
        inside = lam.min(axis=1) > OUTSIDE
        lam = np.maximum(lam, 0)
        return cell, lam / lam.sum(axis=1, keepdims=True), inside


class FieldSampler:
    """Velocity and pressure of a state at points, in SI."""

    def __init__(self, space, state):
        self.points, self.cells = space.nodes()
        self.locator = Locator(self.points, self.cells)
        self.velocity = state[space.v_map].reshape(-1, 3)
        self.pressure = space.nodal_pressure(state)

    def __call__(self, points):
        """(velocity (m, 3), pressure (m,), inside (m,)) at points (m, 3) in m."""
        cell, lam, inside = self.locator.find(points)
        velocity = np.einsum("mn,mnd->md", tet10.basis(lam), self.velocity[self.cells[cell]])
        pressure = np.einsum("mn,mn->m", lam, self.pressure[self.cells[cell][:, :4]])
        return velocity, pressure, inside
