"""Cuts a wall surface at the plane of a vessel's end. The new edge lies in the plane and on the wall."""

import numpy as np

# If the plane cuts an edge within this share of its length from a vertex, the vertex is moved onto the plane. This
# avoids thin triangles.
SNAP_SHARE = 0.3
RIM_PASSES = 8


def cut_at_end(field, points, triangles, centre, normal, radius):
    """(points (n, 3) mm, triangles (m, 3)) of a wall without the part beyond the plane of one end.

    centre (3,) in mm, normal (3,) outward and radius in mm describe that end. Every triangle that crosses the plane is
    split along it. Removing whole triangles left a saw-tooth edge, and the strips between that edge and a new rim
    intersected themselves. Only the surface near the end is cut, since the whole plane would cut other branches too.
    """
    height, local = reach_of_cut(points, centre, normal, radius)
    edges = _edges(triangles)
    edges = edges[local[edges].all(axis=1)]
    snapped = _vertices_near_plane(edges, height)
    points = points.copy()
    points[snapped] = _project_to_rim(field, points[snapped], centre, normal)
    height[snapped] = 0.0
    crossed = edges[height[edges[:, 0]] * height[edges[:, 1]] < 0]
    h0, h1 = height[crossed].T
    share = (h0 / (h0 - h1))[:, None]
    middle = (1 - share) * points[crossed[:, 0]] + share * points[crossed[:, 1]]
    points = np.concatenate([points, _project_to_rim(field, middle, centre, normal)])
    height = np.concatenate([np.where(local, height, -np.inf), np.zeros(len(crossed))])
    return points, _triangles_below(points, triangles, height, crossed)


def reach_of_cut(points, centre, normal, radius):
    """(height (n,) in mm, near (n,) bool) of points (n, 3) in mm, for a cut at an end as in `cut_at_end`.

    height: signed distance from the end's plane, positive beyond the end. near: whether a point is so near to the end
    that the surface is cut there.
    """
    offset = points - centre
    height = offset @ normal
    across = np.linalg.norm(offset - height[:, None] * normal, axis=1)
    return height, (np.linalg.norm(offset, axis=1) < 3.5 * radius + 1) & (across < 1.6 * radius)


def _edges(triangles):
    return np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)


def _vertices_near_plane(edges, height):
    """Numbers of the vertices to be moved onto the plane (SNAP_SHARE). edges (e, 2); height (n,) of all vertices."""
    h0, h1 = height[edges].T
    edges, h0, h1 = (x[h0 * h1 < 0] for x in (edges, h0, h1))
    share = h0 / (h0 - h1)
    return np.unique(np.concatenate([edges[share < SNAP_SHARE, 0], edges[share > 1 - SNAP_SHARE, 1]]))


def _project_to_rim(field, points, centre, normal):
    """Points (n, 3) moved onto the wall and onto the end's plane by turns, the plane last."""
    for _ in range(RIM_PASSES):
        points = field.project(points, 1)
        points = points - ((points - centre) @ normal)[:, None] * normal
    return points


def _triangles_below(points, triangles, height, crossed):
    """The wall's triangles (m, 3) on the inner side of an end's plane; those that cross the plane are cut along it.

    height (n + k,): each vertex's signed distance in mm from the plane, positive beyond the end. The last k vertices
    are the new ones on the plane. crossed (k, 2): the edge on which each new vertex lies.
    """
    first = len(height) - len(crossed)
    new_vertex = {(int(a), int(b)): first + index for index, (a, b) in enumerate(crossed)}
    heights = height[triangles]
    # A triangle with all corners on the rim lies in the plane of the cap: it is no part of the wall.
    whole = (heights.max(axis=1) <= 0) & (heights.min(axis=1) < 0)
    kept = [triangles[whole]]
    split = triangles[(heights.max(axis=1) > 0) & (heights.min(axis=1) < 0) & np.isfinite(heights).all(axis=1)]
    pieces = []
    for triangle in split.tolist():
        ring = []
        for a, b in zip(triangle, triangle[1:] + triangle[:1]):
            if height[a] <= 0:
                ring.append(a)
            if height[a] * height[b] < 0:
                ring.append(new_vertex[min(a, b), max(a, b)])
        pieces += _triangulate_ring(points, ring)
    return np.concatenate(kept + ([np.array(pieces)] if pieces else []))


def _triangulate_ring(points, ring):
    """Triangles of a ring of three or four vertices. A quadrilateral is split along its shorter diagonal."""
    if len(ring) == 3:
        return [ring]
    a, b, c, d = ring
    if np.linalg.norm(points[a] - points[c]) <= np.linalg.norm(points[b] - points[d]):
        return [[a, b, c], [a, c, d]]
    return [[b, c, d], [b, d, a]]
