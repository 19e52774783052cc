"""Lumens found in an image as implicit fields: their gradient, and branches that start in a narrow parent."""

import numpy as np
import pytest

from anatomy.ct import tubes
from common.implicit.curves import Curve

THETA = np.linspace(0, 2 * np.pi, 32, endpoint=False)


def bent_tube(parent, points, radius_mm):
    """A tube with an oval section that turns, and a radius that changes along it by a tenth."""
    axis = Curve(points)
    s = np.arange(0, axis.length_mm + 0.4, 0.5)
    along = radius_mm * (1 + 0.1 * np.sin(s / 2))
    return tubes.Tube(parent, axis, s, THETA, along[:, None] * (1 + 0.15 * np.cos(2 * THETA - 0.2 * s[:, None])))


@pytest.fixture(scope="module", params=[1.6, 0.5])
def tree(request):
    """A TubeField of a main tube of this radius (mm), and a side tube of radius 0.9 mm that starts on its axis."""
    x = np.linspace(0, 20, 201)
    main = bent_tube(None, np.stack([x, 0.02 * (x - 10) ** 2, 0 * x], axis=1), request.param)
    out = np.linspace(0, 9, 91)
    side = bent_tube("main", main.axis.point(9.0) + out[:, None] * np.array([0.5, -0.8, 0.33]), 0.9)
    return tubes.TubeField([main, side])


def test_gradient_is_that_of_the_value(tree):
    rng, points = np.random.default_rng(3), []
    for number, branch in enumerate(tree.branches):
        s = rng.uniform(-1, branch.axis.length_mm + 1, 300)
        _, normal, binormal = branch.axis.frame(s)
        angle, distance = rng.uniform(0, 2 * np.pi, 300), tree.axis_radius(number, s) * rng.uniform(0.7, 1.3, 300)
        ray = np.cos(angle)[:, None] * normal + np.sin(angle)[:, None] * binormal
        points.append(branch.axis.point(s) + distance[:, None] * ray)
    points = np.concatenate(points)
    value, gradient = tree.value_and_gradient(points)
    step = 1e-4 * np.eye(3)
    differences = np.stack([(tree.value(points + d) - tree.value(points - d)) / 2e-4 for d in step], axis=1)
    assert np.array_equal(value, tree.value(points))
    # Frames are splines through samples, so they turn about the axis by a little.
    assert np.percentile(np.abs(gradient - differences).max(axis=1), 99) < 1e-3


def test_a_side_tube_leaves_the_opposite_wall_alone(tree):
    main, side = tree.branches
    s = np.linspace(7, 11, 41)
    tangent, normal, binormal = main.axis.frame(s)
    away = -side.axis.frame(0.0)[0]
    for turn in np.radians([-40, 0, 40]):
        angle = np.arctan2(binormal @ away, normal @ away) + turn
        radius = main.radius_at(s, angle)[:, None]
        wall = main.axis.point(s) + radius * (np.cos(angle)[:, None] * normal + np.sin(angle)[:, None] * binormal)
        assert np.abs(tree.value(wall)).max() < 1e-6
