"""Curvature of lines whose curvature is known exactly."""

import numpy as np
import pytest

from common.errors import InputError
from reports.measuring.curvature import line_curvature, mean_over_length
from reports.inputs.polyline import Polyline


def helix(radius, pitch, s):
    """Helix by arc length; curvature radius / (radius^2 + c^2), c = pitch / (2 pi)."""
    c = pitch / (2 * np.pi)
    angle = s / np.hypot(radius, c)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), c * angle], -1), radius / (radius**2 + c**2)


@pytest.mark.parametrize("radius, pitch", [(3.33, 0.0), (10.0, 0.0), (4.0, 12.0)])
def test_arc_and_helix(radius, pitch):
    s = np.linspace(0.0, 40.0, 161)
    points, exact = helix(radius, pitch, s)
    at = np.linspace(5.0, 35.0, 101)
    kappa = line_curvature(Polyline(points, s, "helix"), at)
    assert kappa == pytest.approx(np.full(101, exact), rel=1e-5)
    assert mean_over_length(kappa, at) == pytest.approx(exact, rel=1e-6)


def test_straight_line_has_none():
    s = np.linspace(0.0, 20.0, 41)
    assert line_curvature(Polyline(np.outer(s, [0.6, 0.0, 0.8]), s, "line"), s) == pytest.approx(0.0, abs=1e-9)


def test_independent_of_rigid_motion_uneven_points_and_single_precision():
    rng = np.random.default_rng(5)
    s = np.sort(rng.uniform(0.0, 40.0, 400))
    s[0], s[-1] = 0.0, 40.0
    points, exact = helix(5.0, 0.0, s)
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    moved = (points @ rotation.T + [30.0, -20.0, 50.0]).astype(np.float32).astype(float)
    at = np.linspace(2.0, 38.0, 101)
    assert mean_over_length(line_curvature(Polyline(moved, s, "moved"), at), at) == pytest.approx(exact, rel=2e-3)


def test_a_curvature_that_varies_is_followed():
    """Parabola y = a x^2: kappa = 2 a / (1 + (2 a x)^2)^1.5."""
    a, x = 0.08, np.linspace(-8.0, 8.0, 4001)
    slope = np.sqrt(1 + (2 * a * x) ** 2)
    s = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(x))])
    at = np.linspace(s[0] + 1, s[-1] - 1, 50)
    x_at = np.interp(at, s, x)
    line = Polyline(np.stack([x, a * x**2, 0 * x], -1)[::40], s[::40], "parabola")
    assert line_curvature(line, at) == pytest.approx(2 * a / (1 + (2 * a * x_at) ** 2) ** 1.5, rel=1e-3)


def test_mean_is_over_length_not_over_points():
    assert mean_over_length([0.0, 0.0, 1.0, 1.0], [0.0, 8.0, 9.0, 10.0]) == pytest.approx(0.15)


def test_refuses_a_line_with_too_few_points():
    s = np.arange(5.0)
    with pytest.raises(InputError, match="too few points"):
        line_curvature(Polyline(np.outer(s, [1.0, 0, 0]), s, "short"), s)


def test_independent_of_the_parameter():
    """The parameter may be a chord length, which only approximates arc length. Curvature must not depend on it."""
    s = np.linspace(0.0, 40.0, 161)
    points, exact = helix(5.0, 8.0, s)
    kappa = line_curvature(Polyline(points, 1.5 * s, "stretched"), np.linspace(6.0, 54.0, 50))
    assert kappa == pytest.approx(np.full(50, exact), rel=1e-4)
