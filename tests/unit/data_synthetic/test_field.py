import numpy as np
import pytest

from common.implicit import field


def test_smooth_minimum_is_below_by_at_most_a_quarter_width():
    a, b = np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-1, 1, 41))
    gap = np.minimum(a, b) - field.smooth_minimum(a, b)
    assert gap.min() >= 0 and gap.max() == pytest.approx(field.BLEND_MM / 4)
    assert np.all(gap[np.abs(a - b) >= field.BLEND_MM] == 0)


def test_value_is_the_distance_to_the_wall_of_one_branch(branches):
    lumen, main = field.LumenField(branches), branches[0]
    s, theta = np.array([4.0, 8.0, 11.0]), np.array([0.1, 2.0, 4.0])
    _, n, b = main.axis.frame(s)
    ray = np.cos(theta)[:, None] * n + np.sin(theta)[:, None] * b
    for offset in (-0.1, 0.0, 0.2):
        points = main.axis.point(s) + (main.radius(s) + offset)[:, None] * ray
        assert lumen.value(points) == pytest.approx(offset, abs=1e-9)


def test_projection_lands_on_the_wall(branches):
    lumen = field.LumenField(branches)
    low, values = field.sample_grid(lumen, 0.4)
    near = np.argwhere(np.abs(values) < 0.3)[::7]
    points = lumen.project(low + 0.4 * near)
    assert np.sqrt(np.mean(lumen.value(points) ** 2)) < 1e-6


def test_ends_are_the_inlet_and_one_outlet_a_branch(branches):
    names = [name for name, *_ in field.open_ends(branches)]
    assert names == ["inlet", "outlet1", "outlet2"]
    (_, centre, normal, radius) = field.open_ends(branches)[0]
    assert np.allclose(centre, branches[0].axis.point(0.0)) and radius == pytest.approx(1.7)
    assert normal @ (branches[0].axis.point(1.0) - centre) < 0


def near_the_wall(lumen):
    low, values = field.sample_grid(lumen, 0.4)
    return low + 0.4 * np.argwhere(np.abs(values) < 0.3)[::7]


def central_differences(lumen, points, step_mm=1e-4):
    shifts = step_mm * np.eye(3)
    return np.stack([(lumen.value(points + d) - lumen.value(points - d)) / (2 * step_mm) for d in shifts], axis=1)


def test_gradient_is_that_of_the_value(branches):
    """Also where branches are blended, in the round end of the side branch, and beyond the open ends."""
    lumen = field.LumenField(branches)
    side = branches[1]
    tangent, normal, _ = side.axis.frame(0.0)
    in_round_end = side.axis.point(0.0) - tangent * 0.3 + normal * 0.2
    points = np.concatenate([near_the_wall(lumen), [in_round_end]])
    value, gradient = lumen.value_and_gradient(points)
    assert np.array_equal(value, lumen.value(points))
    # Half the points next to a sample of the radius are differenced over two pieces of a cubic.
    assert np.abs(gradient - central_differences(lumen, points)).max() < 1e-5
    blended = np.abs(lumen.branch_value(0, points) - lumen.branch_value(1, points)) < field.BLEND_MM
    beyond = branches[0].axis.nearest(points) < 0
    assert blended.sum() > 5 and beyond.sum() > 5
