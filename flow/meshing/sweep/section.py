"""Cross-sections of the lumen's smooth surface: radius by angle around a centre in a plane.

A plane cuts the wall's facets in a loop of segments. A ray with direction e from the centre hits the loop at radius r,
on a facet with normal n. The smooth surface over the facet (geometry.smooth_surface) is a quadratic patch, which lies
off the facet by the vector d at this place. So the ray meets the smooth surface at r + (d.n) / (e.n), up to terms of
second order in d.
"""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from flow.geometry import smooth_surface
from flow.geometry.surface import WALL
from flow.geometry.vectors import cosines_and_sines, dot, unit

NEXT_CORNER = np.array([1, 2, 0])


class Section:
    """One cross-section: a closed loop of segments (m, 2, 2) in mm in its plane, counter-clockwise about `origin`.

    The plane has the point origin (3,) and the unit vectors e1, e2 (3,). `centre` is the loop's centroid. facet_normals
    (m, 3), facets (m,): unit normal and number of each segment's facet. Two functions take segment numbers (k,) and
    places t (k,) from 0 to 1 on them. offset(segment, t) gives the vectors (k, 3) in mm from facet to smooth surface,
    normal_at(segment, t) the unit normals (k, 3) of the smooth surface.
    """

    def __init__(self, origin, e1, e2, segments, facet_normals, facets, offset, normal_at):
        self.e1, self.e2, self.facet_normals, self.facets = e1, e2, facet_normals, facets
        self.offset, self.normal_at = offset, normal_at
        a, b = segments[:, 0], segments[:, 1]
        cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        self.area = 0.5 * float(cross.sum())
        middle = ((a + b) * cross[:, None]).sum(axis=0) / (6.0 * self.area)
        self.segments = segments - middle
        self.centre = origin + middle[0] * e1 + middle[1] * e2

    def radii(self, angles):
        """(radius (k,) in mm, facet (k,), unit normals (k, 3)) at `angles` (k,) in rad.

        Returns None where the loop is not star-shaped about its centre, or a ray meets a facet at a grazing angle.
        """
        direction = np.stack(cosines_and_sines(angles), axis=1)
        a, b = self.segments[:, 0], self.segments[:, 1]
        side_a = direction[:, :1] * a[:, 1] - direction[:, 1:] * a[:, 0]
        side_b = direction[:, :1] * b[:, 1] - direction[:, 1:] * b[:, 0]
        ahead = dot(direction[:, None], a + b) > 0
        hit = ((side_a <= 0) != (side_b <= 0)) & ahead
        if np.any(hit.sum(axis=1) != 1):
            return None
        segment = np.argmax(hit, axis=1)
        rows = np.arange(len(angles))
        t = side_a[rows, segment] / (side_a[rows, segment] - side_b[rows, segment])
        point = (1 - t)[:, None] * a[segment] + t[:, None] * b[segment]
        radius = np.einsum("ij,ij->i", point, direction)
        ray = direction[:, :1] * self.e1 + direction[:, 1:] * self.e2
        facing = self.facet_normals[segment]
        slope = np.einsum("ij,ij->i", ray, facing)
        rise = np.einsum("ij,ij->i", self.offset(segment, t), facing)
        if np.any(radius <= 0) or np.any(slope < 0.1):
            return None
        return radius + rise / slope, self.facets[segment], self.normal_at(segment, t)


class Slicer:
    """Cuts cross-sections out of one lumen surface (geometry.surface.Surface)."""

    def __init__(self, surface):
        self.surface = surface
        self.edges, self.side = surface.edges()
        self.normals = smooth_surface.vertex_normals(surface, self.edges, self.side)
        middles = smooth_surface.edge_middles(surface, self.edges, self.side)
        self.edge_offsets = middles - surface.points[self.edges].mean(axis=1)
        self.wall = np.flatnonzero(surface.region == WALL)
        self.facet_tree = cKDTree(surface.points[surface.triangles[self.wall]].mean(axis=1))
        self.facet_normals = unit(surface.area_vectors())

    def cut_section(self, origin, normal, e1, e2, reach):
        """Section by the plane through `origin` with the unit vectors normal, e1, e2.

        Returns None unless exactly one loop of wall facets within `reach` mm surrounds `origin`.
        """
        near = self.wall[np.sort(self.facet_tree.query_ball_point(origin, reach)).astype(int)]
        height = dot(self.surface.points[self.surface.triangles[near]] - origin, normal)
        height[height == 0.0] = 1e-12
        up = height > 0
        cut = up.any(axis=1) & ~up.all(axis=1)
        if cut.sum() < 3:
            return None
        crossed, height, up = near[cut], height[cut], up[cut]
        corners = self.surface.triangles[crossed]
        leaves, enters = up & ~up[:, NEXT_CORNER], ~up & up[:, NEXT_CORNER]
        ends, barycentric, edge_ids = [], [], []
        for which in (leaves, enters):  # segments run so that the loop is counter-clockwise about the normal
            k = np.argmax(which, axis=1)
            rows = np.arange(len(crossed))
            p, q = corners[rows, k], corners[rows, NEXT_CORNER[k]]
            # the smaller vertex comes first, so that both facets of an edge get the same bits
            low, high = np.minimum(p, q), np.maximum(p, q)
            ends_at = height[rows, k], height[rows, NEXT_CORNER[k]]
            at_low, at_high = np.where(p == low, ends_at, ends_at[::-1])
            t = at_low / (at_low - at_high)
            lam = np.zeros((len(crossed), 3))
            lam[rows, k], lam[rows, NEXT_CORNER[k]] = np.where(p == low, 1 - t, t), np.where(p == low, t, 1 - t)
            ends.append(self.surface.points[low] * (1 - t)[:, None] + self.surface.points[high] * t[:, None])
            barycentric.append(lam)
            edge_ids.append(self.side[crossed, k])
        flat = np.stack([np.stack([dot(x - origin, e1), dot(x - origin, e2)], axis=1) for x in ends], axis=1)
        chosen = _loop_around_origin(flat, edge_ids)
        if chosen is None:
            return None
        flat, facets = flat[chosen], crossed[chosen]
        lam0, lam1 = (lam[chosen] for lam in barycentric)

        def weights(segment, t):
            return (1 - t)[:, None] * lam0[segment] + t[:, None] * lam1[segment]

        def offset(segment, t):
            lam = weights(segment, t)
            return 4.0 * np.einsum(
                "ij,ijk->ik", lam * lam[:, NEXT_CORNER], self.edge_offsets[self.side[facets[segment]]]
            )

        def normal_at(segment, t):
            corners = self.surface.triangles[facets[segment]]
            return unit(np.einsum("ij,ijk->ik", weights(segment, t), self.normals[corners]))

        return Section(origin, e1, e2, flat, self.facet_normals[facets], facets, offset, normal_at)

    def rim_section(self, cap, origin, e1, e2):
        """Section whose loop is the rim of the cap with region id `cap`; plane as in `cut_section`."""
        in_cap, on_wall = self.surface.region == cap, self.surface.region == WALL
        _, first = np.unique(self.side[on_wall], return_index=True)
        wall_of = dict(zip(self.side[on_wall].ravel()[first], np.flatnonzero(on_wall)[first // 3]))
        rim = [edge for edge in np.unique(self.side[in_cap]) if edge in wall_of]
        a, b = (self.surface.points[self.edges[rim, k]] for k in (0, 1))
        flat = np.stack([np.stack([dot(x - origin, e1), dot(x - origin, e2)], axis=1) for x in (a, b)], axis=1)
        turn = flat[:, 0, 0] * flat[:, 1, 1] - flat[:, 0, 1] * flat[:, 1, 0]
        flip = turn < 0
        flat[flip] = flat[flip][:, ::-1]
        along = flat[:, 1] - flat[:, 0]
        facet_normals = unit(along[:, 1:] * e1 - along[:, :1] * e2)
        ends = np.where(flip[:, None], self.edges[rim][:, ::-1], self.edges[rim])
        edge_offsets = self.edge_offsets[rim]

        def offset(segment, t):
            return (4.0 * t * (1 - t))[:, None] * edge_offsets[segment]

        def normal_at(segment, t):
            p, q = self.normals[ends[segment, 0]], self.normals[ends[segment, 1]]
            return unit((1 - t)[:, None] * p + t[:, None] * q)

        facets = np.array([wall_of[edge] for edge in rim])
        return Section(origin, e1, e2, flat, facet_normals, facets, offset, normal_at)


def _loop_around_origin(flat, edge_ids):
    """Which segments (m,) bool form the loop that winds once around the origin; None unless there is exactly one.

    flat (m, 2, 2): the segments in the plane; edge_ids: the surface's edges on which they start (m,) and end (m,).
    """
    _, nodes = np.unique(np.concatenate(edge_ids), return_inverse=True)
    count, size = len(flat), nodes.max() + 1
    start, end = nodes[:count], nodes[count:]
    graph = coo_matrix((np.ones(count), (start, end)), (size, size))
    _, label = connected_components(graph, directed=False)
    angle = np.arctan2(flat[..., 1], flat[..., 0])
    turn = (np.diff(angle, axis=1)[:, 0] + np.pi) % (2 * np.pi) - np.pi
    winding = np.bincount(label[start], turn, minlength=label.max() + 1) / (2 * np.pi)
    found = np.flatnonzero(np.abs(winding - 1.0) < 1e-6)
    return label[start] == found[0] if len(found) == 1 else None
