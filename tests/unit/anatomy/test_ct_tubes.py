"""Lumens found in an image as implicit fields: their gradient, and branches that start in a narrow parent."""

import numpy as np
import pytest
import scipy.ndimage

from anatomy.ct import segment, tubes
from common.implicit import field
from common.implicit.curves import Curve

THETA = np.linspace(0, 2 * np.pi, 32, endpoint=False)


def bent_tube(parent, points, radius_mm):
    """A tube with an oval section that turns, and a radius that changes along it by a tenth."""
    axis = Curve(points)
    s = np.arange(0, axis.length_mm + 0.4, 0.5)
    along = radius_mm * (1 + 0.1 * np.sin(s / 2))
    return tubes.Tube(parent, axis, s, THETA, along[:, None] * (1 + 0.15 * np.cos(2 * THETA - 0.2 * s[:, None])))


def tubes_of(radius_mm, off_axis_mm=0.0, side_mm=0.9):
    """A main tube of this radius, and a side tube of radius side_mm that starts so far off the main tube's axis."""
    x = np.linspace(0, 20, 201)
    main = bent_tube(None, np.stack([x, 0.02 * (x - 10) ** 2, 0 * x], axis=1), radius_mm)
    out = np.linspace(0, 9, 91)
    outward = np.array([0.5, -0.8, 0.33])
    tangent = main.axis.frame(9.0)[0]
    across = outward - (outward @ tangent) * tangent
    start = main.axis.point(9.0) + off_axis_mm * across / np.linalg.norm(across)
    return [main, bent_tube("main", start + out[:, None] * outward, side_mm)]


@pytest.fixture(scope="module", params=[1.6, 0.5])
def tree(request):
    """A TubeField of a main tube of this radius (mm), and a side tube that starts on its axis."""
    return tubes.TubeField(tubes_of(request.param))


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


@pytest.mark.parametrize("off_axis_mm", [-1.0, 0.5, 1.2, 1.39, 1.41, 1.6])
def test_a_side_tube_that_starts_off_its_parents_axis_is_joined_to_it(off_axis_mm):
    """As where the parent's axis was moved after the branch's start was found. The parent's least radius is 1.4 mm."""
    lumen = tubes.TubeField(tubes_of(1.6, off_axis_mm))
    s = np.linspace(0, 6, 61)
    assert (-lumen.value(lumen.branches[1].axis.point(s))).min() > 0.6
    low, values = field.sample_grid(lumen, 0.2)
    assert scipy.ndimage.label(values < 0)[1] == 1


def test_a_level_of_the_image_is_searched_also_where_a_branch_begins_narrower():
    """The image shows a branch of full width inside a narrow parent. No root narrows the band that is searched."""
    main, side = tubes_of(0.5, side_mm=1.6)

    def hu_at(points):
        offset = [np.linalg.norm(points - b.axis.point(b.axis.nearest(points)), axis=1) for b in (main, side)]
        return 100 * np.maximum(0.5 - offset[0], 1.6 - offset[1])

    low, values = field.sample_grid(tubes.LevelField([main, side], hu_at, 0.0, 100.0), 0.2)
    points = low + 0.2 * np.argwhere(np.ones(values.shape, bool))
    near = np.linalg.norm(points - side.axis.point(0.3), axis=1) < 1.5
    assert np.all((values.ravel()[near] < 0) == (hu_at(points[near]) > 0))


def test_a_branch_starts_on_its_parents_axis_once_that_is_centred():
    main, side = tubes_of(1.6, off_axis_mm=0.8)
    axis = segment._centred_axis(side, main)
    start = axis.point(0.0)
    assert np.linalg.norm(start - main.axis.point(main.axis.nearest(start[None]))[0]) < 0.05
    assert np.linalg.norm(axis.point(axis.length_mm) - side.axis.point(side.axis.length_mm)) < 0.3
