import numpy as np
import pytest

from common.implicit.curves import Curve, curve_from_curvatures


@pytest.fixture
def helix():
    angle = np.linspace(0, 3 * np.pi, 400)
    return Curve(np.stack([8 * np.cos(angle), 8 * np.sin(angle), 2 * angle], axis=1))


def test_arc_length_and_curvature_of_a_helix(helix):
    assert helix.length_mm == pytest.approx(3 * np.pi * np.hypot(8, 2), rel=1e-6)
    s = np.linspace(2, helix.length_mm - 2, 50)
    assert np.abs(helix.curvature(s) - 8 / (64 + 4)).max() < 1e-5


def test_frame_is_orthonormal_and_turns_no_more_than_needed(helix):
    s = np.linspace(0, helix.length_mm, 2000)
    t, n, b = helix.frame(s)
    assert np.abs(np.sum(t * n, axis=1)).max() < 1e-12
    assert np.allclose(np.cross(t, n), b)
    spin = np.sum(np.gradient(n, s, axis=0) * b, axis=1)[5:-5]
    assert np.abs(spin).max() < 2e-3  # torsion would be 2/68 = 0.029 for the Frenet frame


def test_nearest_point_is_perpendicular(helix):
    rng = np.random.default_rng(1)
    s = rng.uniform(1, helix.length_mm - 1, 200)
    t, n, b = helix.frame(s)
    angle = rng.uniform(0, 2 * np.pi, 200)
    x = helix.point(s) + 2 * (np.cos(angle)[:, None] * n + np.sin(angle)[:, None] * b)
    assert np.abs(helix.nearest(x) - s).max() < 1e-8


def test_nearest_runs_straight_beyond_the_ends(helix):
    tangent = helix.frame(helix.length_mm)[0]
    assert helix.nearest((helix.point(helix.length_mm) + 3 * tangent)[None])[0] == pytest.approx(
        helix.length_mm + 3, abs=1e-6
    )


def test_integrated_curvature_is_that_of_the_curve():
    step, count = 0.1, 301
    curve = Curve(curve_from_curvatures(np.full(count, 0.1), np.zeros(count), step))
    assert curve.length_mm == pytest.approx(30, rel=1e-4)
    assert np.abs(curve.curvature(np.linspace(1, 29, 20)) - 0.1).max() < 2e-4
