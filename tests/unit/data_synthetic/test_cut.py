"""The cut at a vessel's end: the edge lies in the plane and on the wall, and the wall is kept whole."""

import numpy as np
import pytest

from common import vtp
from common.implicit import cut, field, surface


@pytest.fixture(scope="module")
def opened(branches):
    """The wall cut at the inlet alone: (field, points, triangles, centre, normal, radius)."""
    lumen = field.LumenField(branches)
    low, values = field.sample_grid(lumen, 0.3)
    points, triangles = vtp.points_and_triangles(surface._smoothed(surface._contour(low, values, 0.3)))
    points = lumen.project(points)
    _, centre, normal, radius = field.open_ends(branches)[0]
    points, triangles = cut.cut_at_end(lumen, points, triangles[:, ::-1], centre, normal, radius)
    return lumen, *surface._largest_component(points, triangles), centre, normal, radius


def test_the_edge_lies_in_the_plane_and_on_the_wall(opened):
    lumen, points, triangles, centre, normal, radius = opened
    (loop,) = surface._boundary_loops(triangles)
    rim = points[loop]
    assert np.abs((rim - centre) @ normal).max() < 1e-12
    assert np.abs(lumen.value(rim)).max() < 1e-6
    assert np.linalg.norm(rim - centre, axis=1) == pytest.approx(np.full(len(rim), radius), rel=1e-3)
    step = np.linalg.norm(rim - np.roll(rim, -1, axis=0), axis=1)
    assert step.sum() == pytest.approx(2 * np.pi * radius, rel=0.01), "once round, without turning back"


def test_nothing_is_left_beyond_the_plane_and_nothing_is_turned_over(opened):
    lumen, points, triangles, centre, normal, radius = opened
    near = np.linalg.norm(points - centre, axis=1) < 2 * radius  # the other ends are still open stubs
    assert ((points[near] - centre) @ normal).max() < 1e-12
    corners = points[triangles[near[triangles].all(axis=1)]]
    _, outward = lumen.value_and_gradient(corners.mean(axis=1))
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    cosine = np.sum(outward * facing, axis=1) / np.linalg.norm(outward, axis=1) / np.linalg.norm(facing, axis=1)
    assert cosine.min() > 0.5
