"""Pairs of triangles of a surface that cross one another."""

import numpy as np
from scipy.spatial import cKDTree

PAIRS_AT_ONCE = 200_000  # number of pairs tested at once, to limit the memory


def crossing_pairs(points, triangles):
    """Pairs (k, 2) of triangles that share no vertex and cross, sorted; empty for a surface that does not cross itself.

    points (n, 3), triangles (m, 3). Two triangles cross if an edge of one pierces the other. Overlap of coplanar
    triangles, as in a flat cap, is not found. Pairs that share a vertex are not tested: if they fold over each other,
    other neighbours cross too.
    """
    corners = points[triangles]
    middle = corners.mean(axis=1)
    radius = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    found = [np.empty((0, 2), int)]
    # Only triangles whose middles are near can cross. One search has a radius that fits 99 % of the triangles. Each
    # larger triangle searches by itself, so that a few long triangles do not enlarge the search of all others.
    tree, sorted_radii = cKDTree(middle), np.sort(radius)
    typical = sorted_radii[int(0.99 * (len(sorted_radii) - 1))]
    pairs = [tree.query_pairs(2 * typical, output_type="ndarray")]
    for large in np.flatnonzero(radius > typical):
        near = np.array(tree.query_ball_point(middle[large], radius[large] + sorted_radii[-1]))
        pairs.append(np.sort(np.stack([np.full(len(near), large), near], axis=1), axis=1))
    pairs = np.unique(np.concatenate(pairs), axis=0)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    low, high = corners.min(axis=1), corners.max(axis=1)
    for start in range(0, len(pairs), PAIRS_AT_ONCE):
        i, j = pairs[start : start + PAIRS_AT_ONCE].T
        near = np.all((low[i] <= high[j]) & (low[j] <= high[i]), axis=1)
        i, j = i[near], j[near]
        disjoint = ~np.any(triangles[i][:, :, None] == triangles[j][:, None, :], axis=(1, 2))
        i, j = i[disjoint], j[disjoint]
        cross = _edge_pierces(corners[i], corners[j]) | _edge_pierces(corners[j], corners[i])
        found.append(np.stack([i[cross], j[cross]], axis=1))
    return np.concatenate(found)


def _edge_pierces(a, b):
    """(n,) bool: whether an edge of triangle a passes through the inside of triangle b. a, b (n, 3, 3): corners."""
    hit = np.zeros(len(a), bool)
    u, v = b[:, 1] - b[:, 0], b[:, 2] - b[:, 0]
    normal = np.cross(u, v)
    height = np.einsum("nkd,nd->nk", a - b[:, :1], normal)
    for k in range(3):
        h0, h1 = height[:, k], height[:, (k + 1) % 3]
        through = h0 * h1 < 0
        share = np.where(through, h0 / np.where(through, h0 - h1, 1.0), 0.0)
        place = a[:, k] + share[:, None] * (a[:, (k + 1) % 3] - a[:, k]) - b[:, 0]
        # Barycentric coordinates of the intersection in b.
        scale = np.einsum("nd,nd->n", normal, normal)
        scale = np.where(scale > 0, scale, 1.0)
        s = np.einsum("nd,nd->n", np.cross(place, v), normal) / scale
        t = np.einsum("nd,nd->n", np.cross(u, place), normal) / scale
        hit |= through & (s > 0) & (t > 0) & (s + t < 1)
    return hit
