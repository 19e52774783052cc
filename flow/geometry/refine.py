"""Refinement of the lumen surface where its edges are too long; new vertices lie on the smooth surface."""

import numpy as np

from flow.geometry.smooth_surface import edge_middles
from flow.geometry.surface import Surface

SPLIT_RATIO = 1.4  # an edge longer than this times its target is split, so that halves have at least .7 of the target
MOST_ROUNDS = 4  # most rounds of splitting


def refine(surface, target_mm):
    """The Surface with its long edges split, in up to MOST_ROUNDS rounds; new vertices lie on geometry.smooth_surface.

    target_mm(points (n, 3)) -> wanted edge length (n,) in mm. An edge longer than SPLIT_RATIO times its target is
    split.
    """
    for _ in range(MOST_ROUNDS):
        edges, side = surface.edges()
        a, b = surface.points[edges[:, 0]], surface.points[edges[:, 1]]
        length = np.linalg.norm(b - a, axis=1)
        marked = length > SPLIT_RATIO * target_mm(0.5 * (a + b))
        if not marked.any():
            break
        marked = _mark_longest_sides(marked, side, length)
        surface = _split_edges(surface, marked, edges, side)
    return surface


def _mark_longest_sides(marked, side, length):
    """Marks the longest side of every triangle that has a marked side, until nothing changes (Rivara's rule).

    marked (e,) bool and length (e,) of the edges; side (m, 3): the edges of each triangle.
    """
    longest = side[np.arange(len(side)), np.argmax(length[side], axis=1)]
    while True:
        more = marked[side].any(axis=1) & ~marked[longest]
        if not more.any():
            return marked
        marked[longest[more]] = True


def _split_edges(surface, marked, edges, side):
    """The Surface with its marked edges split, so that a triangle with one, two or three of them becomes two to four.

    If a side of a triangle is marked, its longest side must be marked, too.
    """
    new = np.full(len(edges), -1)
    new[marked] = len(surface.points) + np.arange(marked.sum())
    points = np.concatenate([surface.points, edge_middles(surface, edges, side)[marked]])
    triangles, region = [], []
    length = np.linalg.norm(surface.points[edges[:, 1]] - surface.points[edges[:, 0]], axis=1)
    first = np.argmax(length[side], axis=1)
    rows = np.arange(len(side))
    # turn each triangle so that its longest side is 01
    corner = np.stack([surface.triangles[rows, (first + k) % 3] for k in range(3)], axis=1)
    m01, m12, m20 = (new[side[rows, (first + k) % 3]] for k in range(3))
    whole = m01 < 0
    halves = [
        (m12 < 0, ((m01, corner[:, 1], corner[:, 2]),)),
        (m12 >= 0, ((m01, corner[:, 1], m12), (m01, m12, corner[:, 2]))),
        (m20 < 0, ((corner[:, 0], m01, corner[:, 2]),)),
        (m20 >= 0, ((corner[:, 0], m01, m20), (m20, m01, corner[:, 2]))),
    ]
    triangles.append(surface.triangles[whole])
    region.append(surface.region[whole])
    for condition, pieces in halves:
        chosen = ~whole & condition
        for piece in pieces:
            triangles.append(np.stack([vertex[chosen] for vertex in piece], axis=1))
            region.append(surface.region[chosen])
    return Surface(points, np.concatenate(triangles), np.concatenate(region))
