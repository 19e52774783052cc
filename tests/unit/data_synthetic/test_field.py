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
