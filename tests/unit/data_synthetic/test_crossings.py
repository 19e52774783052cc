"""Crossing triangles: found where they are, and only there."""

import numpy as np

from common.implicit import field, surface
from data_synthetic import crossings

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def two_tetrahedra(shift, size=1.0):
    points = np.concatenate([CORNERS, size * CORNERS + shift])
    return points, np.concatenate([TETRAHEDRON, TETRAHEDRON + 4])


def test_overlapping_bodies_cross_and_others_do_not():
    assert len(crossings.crossing_pairs(*two_tetrahedra([0.2, 0.1, 0.15]))) >= 3
    assert len(crossings.crossing_pairs(*two_tetrahedra([1.1, 0.0, 0.0]))) == 0
    inside = crossings.crossing_pairs(*two_tetrahedra([0.1, 0.1, 0.1], 0.5))
    assert len(inside) == 0, "one within the other does not cross it"


def test_a_pair_of_very_different_sizes_is_found():
    points, triangles = two_tetrahedra([0.3, 0.3, -0.005], 0.01)
    pairs = crossings.crossing_pairs(points, triangles)
    assert len(pairs) and np.all(pairs[:, 0] < 4) and np.all(pairs[:, 1] >= 4)


def test_a_vertex_pushed_through_the_opposite_wall_is_found(branches):
    points, triangles, on_cap = surface.build(field.LumenField(branches), 0.4)
    assert len(crossings.crossing_pairs(points, triangles)) == 0
    s = branches[0].axis.nearest(points)
    vertex = int(np.argmin(np.where(on_cap, np.inf, np.abs(s - 5.0))))
    spoiled = points.copy()
    spoiled[vertex] += 2.2 * (branches[0].axis.point(s[vertex]) - points[vertex])
    pairs = crossings.crossing_pairs(spoiled, triangles)
    fan = np.flatnonzero((triangles == vertex).any(axis=1))
    assert len(pairs) and np.isin(pairs, fan).any(axis=1).all()
