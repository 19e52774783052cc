"""Carrying a fine wall by the displacement of a coarse one: exact for what it must be exact for, second order else."""

import numpy as np
import pytest

from common import vtp
from vci.benchmarks import coarse_walls

RADIUS, LENGTH = 1.5, 6.0


def tube(around, radius=lambda z: RADIUS):
    """Open tube of triangles about 2 pi R / around long; radius(z) in mm."""
    rings = int(round(LENGTH / (2 * np.pi * RADIUS / around))) + 1
    z, angle = np.meshgrid(np.linspace(0, LENGTH, rings), 2 * np.pi * np.arange(around) / around, indexing="ij")
    r = np.vectorize(radius)(z)
    points = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1).reshape(-1, 3)
    first = (np.arange(rings - 1)[:, None] * around + np.arange(around)).ravel()
    after = (np.arange(rings - 1)[:, None] * around + (np.arange(around) + 1) % around).ravel()
    triangles = np.concatenate(
        [np.stack([first, after, first + around], 1), np.stack([after, after + around, first + around], 1)]
    )
    return vtp.surface(points, triangles)


def widened(surface):
    """The tube with a bulge: each point moved out by up to 0.4 mm."""
    points, triangles = vtp.arrays(surface)
    out = points * [1, 1, 0] / np.linalg.norm(points[:, :2], axis=1, keepdims=True)
    return vtp.surface(points + 0.4 * np.sin(np.pi * points[:, 2:] / LENGTH) ** 2 * out, triangles)


def test_a_linear_field_on_a_plane_is_met_exactly():
    x, y = np.meshgrid(np.arange(4.0), np.arange(3.0), indexing="ij")
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    corners = np.array([3 * i + j for i in range(3) for j in range(2)])
    triangles = np.concatenate(
        [np.stack([corners, corners + 3, corners + 1], 1), np.stack([corners + 3, corners + 4, corners + 1], 1)]
    )
    slope = np.array([[0.1, -0.2, 0.3], [0.4, 0.5, -0.6]])
    at = np.random.default_rng(2).uniform(
        [0, 0, -0.2], [3, 2, 0.2], (50, 3)
    )  # beside the plane: the nearest point counts
    found = coarse_walls.interpolated(vtp.surface(points, triangles), points[:, :2] @ slope, at)
    assert found == pytest.approx(at[:, :2] @ slope, abs=1e-12)


def test_a_shifted_vessel_is_carried_exactly():
    pairs = []
    for around in (12, 40):
        before = tube(around)
        pairs.append((before, vtp.surface(vtp.points(before) + [0.3, -0.2, 0.1], vtp.triangles(before))))
    assert coarse_walls.carried_errors(*pairs) == pytest.approx((0, 0, 0), abs=1e-12)


def test_a_widened_tube_is_carried_to_second_order():
    fine = tube(96)
    rms = [
        coarse_walls.carried_errors((coarse := tube(around), widened(coarse)), (fine, widened(fine)))[1]
        for around in (12, 24)
    ]
    assert 0.0005 < rms[0] < 0.03
    assert 3 < rms[0] / rms[1] < 5  # halved edges: a quarter


def test_points_at_rest_do_not_count():
    fine, coarse = tube(40), tube(12)
    moved = coarse_walls.carried_errors((coarse, coarse), (fine, widened(fine)))
    assert moved[2] == pytest.approx(0.4, abs=0.02) and moved[0] < -0.15  # left behind by what the wall moved
