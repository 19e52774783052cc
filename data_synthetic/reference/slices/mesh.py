"""Annular mesh of quadratic quadrilaterals between lumen and adventitia; its nodes are moved from slice to slice."""

import numpy as np
from dolfinx import mesh as dmesh
from mpi4py import MPI

from common import fenicsx

LUMEN, OUTSIDE = 1, 2


class Annulus:
    """Ring of `around` x `through` biquadratic elements, created on the unit annulus 1 < r < 2.

    mesh: dolfinx mesh with geometry of degree 2. facet_tags: its edges on the lumen (LUMEN) and outside (OUTSIDE).
    theta_rad (2 around,): angles of the nodes of a circle. depth (2 through + 1,): place of each circle of nodes
    between lumen (0) and outside (1).
    """

    def __init__(self, around, through):
        self.theta_rad = 2 * np.pi * np.arange(2 * around) / (2 * around)
        self.depth = np.linspace(0, 1, 2 * through + 1)
        columns, rows = 2 * around, 2 * through + 1

        def node(i, j):
            return (i % columns) * rows + j

        cells = []
        for i in range(0, columns, 2):
            for j in range(0, 2 * through, 2):
                # Basix orders the nodes by corners (0,0) (1,0) (0,1) (1,1), then edges, then the centre. The first
                # direction is depth.
                corner = [node(i, j), node(i, j + 2), node(i + 2, j), node(i + 2, j + 2)]
                edge = [node(i, j + 1), node(i + 1, j), node(i + 1, j + 2), node(i + 2, j + 1)]
                cells.append(corner + edge + [node(i + 1, j + 1)])
        radius = 1 + self.depth
        x = np.stack(
            [np.outer(np.cos(self.theta_rad), radius).ravel(), np.outer(np.sin(self.theta_rad), radius).ravel()], axis=1
        )
        domain = fenicsx.quadratic_domain("quadrilateral")
        self.mesh = dmesh.create_mesh(MPI.COMM_SELF, np.array(cells, np.int64), x, domain)
        self._input = np.array(self.mesh.geometry.input_global_indices)
        self.mesh.topology.create_connectivity(1, 2)
        inner = dmesh.locate_entities_boundary(self.mesh, 1, lambda p: np.hypot(p[0], p[1]) < 1.2)
        outer = dmesh.locate_entities_boundary(self.mesh, 1, lambda p: np.hypot(p[0], p[1]) > 1.8)
        facets = np.concatenate([inner, outer]).astype(np.int32)
        tags = np.concatenate([np.full(len(inner), LUMEN), np.full(len(outer), OUTSIDE)]).astype(np.int32)
        order = np.argsort(facets)
        self.facet_tags = dmesh.meshtags(self.mesh, 1, facets[order], tags[order])

    def place(self, inner_mm, outer_mm):
        """Moves the nodes so that the ring lies between the radii inner_mm and outer_mm, each (2 around,) in mm.

        The radii are those at the angles theta_rad.
        """
        radius = inner_mm[:, None] + (outer_mm - inner_mm)[:, None] * self.depth[None]
        x = radius * np.cos(self.theta_rad)[:, None]
        y = radius * np.sin(self.theta_rad)[:, None]
        self.mesh.geometry.x[:, 0] = x.ravel()[self._input]
        self.mesh.geometry.x[:, 1] = y.ravel()[self._input]
