"""Swept mesh of quadratic hexahedra for a stretch of a branch, from the lumen to the adventitia."""

import itertools

import basix
import numpy as np
from dolfinx import mesh as dmesh
from mpi4py import MPI
from scipy.spatial import cKDTree

from common import fenicsx

LUMEN, OUTSIDE, ENDS = 1, 2, 3


def _tensor_order():
    """Places (27, 3) of the nodes of a quadratic hexahedron, in the order of Basix.

    Each coordinate is 0, 1 or 2 half edges.
    """
    corner = np.array([[v % 2, v // 2 % 2, v // 4] for v in range(8)]) * 2
    topology = basix.topology(basix.CellType.hexahedron)
    return np.array([corner[entity].sum(axis=0) // len(entity) for dim in topology for entity in dim])


class Tube:
    """Mesh of hexahedra between the lumen and the outside. Its nodes lie at stations x angles x depths.

    axis: Curve. inner_mm, outer_mm (stations, 2 around): radii from `tissue.inner_outer_radii`. station_s_mm
    (stations,): arc lengths of the planes of nodes. Their number is odd, since corners and middles of the elements
    alternate. through: number of elements through the wall.

    Nodes are numbered station by station, then by angle, then by depth. section_coordinates_mm (nodes, 3) holds their
    coordinates (s, a, b), with a and b along the section's normal and binormal.
    """

    def __init__(self, axis, station_s_mm, inner_mm, outer_mm, through):
        stations, columns = inner_mm.shape
        rows = 2 * through + 1
        self.station_s_mm, self.rows = np.asarray(station_s_mm, float), rows
        self.theta_rad = 2 * np.pi * np.arange(columns) / columns
        depth = np.linspace(0, 1, rows)
        radius = inner_mm[..., None] + (outer_mm - inner_mm)[..., None] * depth
        a = radius * np.cos(self.theta_rad)[:, None]
        b = radius * np.sin(self.theta_rad)[:, None]
        s = np.broadcast_to(self.station_s_mm[:, None, None], a.shape)
        self.section_coordinates_mm = np.stack([s.ravel(), a.ravel(), b.ravel()], axis=1)
        self.points_mm = self._node_points(axis)
        domain = fenicsx.quadratic_domain("hexahedron")
        cells = self._cells(stations, columns, through)
        self.mesh = dmesh.create_mesh(MPI.COMM_SELF, cells, self.points_mm, domain)
        self._tree = cKDTree(self.points_mm)
        self.facet_tags = self._tags(stations, columns)

    def _node_points(self, axis):
        centre = axis.point(self.section_coordinates_mm[:, 0])
        _, normal, binormal = axis.frame(self.section_coordinates_mm[:, 0])
        return centre + self.section_coordinates_mm[:, 1:2] * normal + self.section_coordinates_mm[:, 2:] * binormal

    def _cells(self, stations, columns, through):
        offsets = _tensor_order()
        found = []
        for k, i, j in itertools.product(range(0, stations - 1, 2), range(0, columns, 2), range(0, 2 * through, 2)):
            # The element's first direction is depth, the second round, the third along the axis: right-handed.
            depth, turn, along = (offsets + [j, i, k]).T
            found.append((along * columns + turn % columns) * self.rows + depth)
        return np.array(found, np.int64)

    def find_nodes(self, points_mm):
        """Numbers (n,) of the nodes at points (n, 3)."""
        distance, number = self._tree.query(points_mm)
        assert distance.max(initial=0) < 1e-9, "no node there"
        return number

    def _tags(self, stations, columns):
        """dolfinx tags LUMEN, OUTSIDE and ENDS of the boundary's facets, found by the numbers of their nodes."""
        number = np.arange(len(self.points_mm)).reshape(stations, columns, self.rows)
        first, last = number[0].ravel(), number[-1].ravel()
        self.mesh.topology.create_connectivity(2, 3)
        groups = [(LUMEN, number[:, :, 0].ravel()), (OUTSIDE, number[:, :, -1].ravel()), (ENDS, first), (ENDS, last)]
        facets, tags = [], []
        for tag, members in groups:
            flag = np.zeros(len(self.points_mm), bool)
            flag[members] = True
            at = dmesh.locate_entities_boundary(self.mesh, 2, lambda x: flag[self.find_nodes(x.T)])
            facets.append(at)
            tags.append(np.full(len(at), tag))
        facets, tags = np.concatenate(facets).astype(np.int32), np.concatenate(tags).astype(np.int32)
        order = np.argsort(facets)
        return dmesh.meshtags(self.mesh, 2, facets[order], tags[order])

    def lumen_nodes(self):
        """Numbers (stations, 2 around) of the nodes on the lumen."""
        return np.arange(len(self.points_mm)).reshape(len(self.station_s_mm), -1, self.rows)[:, :, 0]
