"""A smooth surface through the vertices of the lumen triangulation, given by a point for the middle of each edge.

Plane facets would make an error of 2-6 % in a Poiseuille pressure drop. The middle points on the wall are those of PN
triangles (Vlachos et al. 2001, Curved PN triangles), weighted so that they are exact on a circle. With the edge
d = p1 - p0, unit normals n0, n1 at its ends and sin t_i = d.n_i / |d|, the middle point is

    m = (p0 + p1) / 2 + [ (d.n1) n1 / ((1 + cos t1) cos t1) - (d.n0) n0 / ((1 + cos t0) cos t0) ] / 4

At a rim, where a cap meets the wall, all wall triangles of a vertex lie on one side of it. The mean of their normals
would be tilted. Instead a rim vertex gets the normal of the circle through it and its two neighbours on the rim. This
normal lies in the cap's plane, as if the vessel went on straight behind the cap.
"""

import numpy as np

from flow.geometry import vectors
from flow.geometry.surface import WALL
from flow.geometry.vectors import dot

# Largest distance of a middle point from its straight edge, over the edge's length. The limit is for kinks, where the
# normals do not determine the surface between the vertices.
LARGEST_OFFSET = 0.2


def wall_normals(surface):
    """Unit normals (n, 3) of a Surface's wall at its vertices, zero elsewhere.

    The facets' normals are weighted so that the result is exact on a sphere (Max 1999, J Graph Tools 4).
    """
    wall = surface.triangles[surface.region == WALL]
    points, normals = surface.points, np.zeros_like(surface.points)
    for k in range(3):
        apex, left, right = wall[:, k], wall[:, (k + 1) % 3], wall[:, (k + 2) % 3]
        a, b = points[left] - points[apex], points[right] - points[apex]
        weight = np.einsum("ij,ij->i", a, a) * np.einsum("ij,ij->i", b, b)
        np.add.at(normals, apex, np.cross(a, b) / weight[:, None])
    length = np.linalg.norm(normals, axis=1)
    normals[length > 0] /= length[length > 0, None]
    return normals


def edge_kinds(surface, edges, side):
    """(on_wall (e,), on_rim (e,)) bool: whether an edge is a side of a wall triangle, and of a cap's triangle as well.

    edges (e, 2), side (m, 3): as `Surface.edges` gives them.
    """
    on_wall = np.zeros(len(edges), bool)
    on_cap = np.zeros(len(edges), bool)
    on_wall[side[surface.region == WALL].ravel()] = True
    on_cap[side[surface.region != WALL].ravel()] = True
    return on_wall, on_wall & on_cap


def vertex_normals(surface, edges, side):
    """Unit normals (n, 3) of the smooth surface at the wall's vertices, zero elsewhere."""
    _, on_rim = edge_kinds(surface, edges, side)
    normals = wall_normals(surface)
    for vertex, normal in _rim_normals(surface.points, edges[on_rim]).items():
        normals[vertex] = normal
    return normals


def edge_middles(surface, edges, side, normals=None):
    """Points (e, 3) in mm of the smooth surface at the middle of each edge; edges within a cap are straight.

    normals (n, 3): unit normals of the smooth surface at the vertices, zero elsewhere; by default `vertex_normals`.
    """
    a, b = surface.points[edges[:, 0]], surface.points[edges[:, 1]]
    middle = 0.5 * (a + b)
    on_wall, _ = edge_kinds(surface, edges, side)
    normals = vertex_normals(surface, edges, side) if normals is None else normals
    n0, n1, d = normals[edges[:, 0]], normals[edges[:, 1]], b - a
    offset = _end_offset(d, n1) - _end_offset(d, n0)
    offset[~on_wall] = 0.0
    size = np.linalg.norm(offset, axis=1)
    limit = LARGEST_OFFSET * np.linalg.norm(d, axis=1)
    scale = np.minimum(1.0, limit / np.maximum(size, 1e-300))
    return middle + scale[:, None] * offset


def _end_offset(d, normal):
    """Offset (e, 3) in mm of the edges' middle points that the normals at one end of the edges make.

    d (e, 3): the edges; normal (e, 3): the normals at that end.
    """
    rise = np.einsum("ij,ij->i", d, normal)
    square = np.maximum(np.einsum("ij,ij->i", d, d), 1e-300)
    cosine = np.sqrt(np.maximum(0.0, 1.0 - rise**2 / square))
    return (0.25 * rise / ((1.0 + cosine) * np.maximum(cosine, 0.5)))[:, None] * normal


def _rim_normals(points, rim):
    """{vertex: outward unit normal} of rim vertices, from the circle through each and its two neighbours."""
    neighbours = {}
    for a, b in rim:
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    normal = {}
    for vertex, (left, right) in neighbours.items():
        u, v = points[left] - points[vertex], points[right] - points[vertex]
        # |u|^2 v - |v|^2 u is tangential to the circle at the vertex; turned by a right angle in its plane it is normal
        axis = np.cross(u, v)
        tangent = dot(u, u) * v - dot(v, v) * u
        outward = -np.cross(tangent, axis) if dot(axis, axis) > 1e-12 * dot(u, u) * dot(v, v) else np.zeros(3)
        length = vectors.length(outward)
        outward = outward / length if length > 0 else outward
        normal[vertex] = -outward if dot(outward, u + v) > 0 else outward
    return normal
