"""Distances between two deployments of one lumen, and the summary of the meshes over the cases."""

import numpy as np
import pytest

from common import vtp
from vci.benchmarks import coarse_walls

RADIUS, LENGTH, AROUND = 1.5, 6.0, 40


def tube(radius=lambda z: RADIUS):
    """Open tube of triangles with edges of about 2 pi R / AROUND; radius(z) in mm."""
    rings = int(round(LENGTH / (2 * np.pi * RADIUS / AROUND))) + 1
    z, angle = np.meshgrid(np.linspace(0, LENGTH, rings), 2 * np.pi * np.arange(AROUND) / AROUND, indexing="ij")
    r = np.vectorize(radius)(z)
    points = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1).reshape(-1, 3)
    first = (np.arange(rings - 1)[:, None] * AROUND + np.arange(AROUND)).ravel()
    after = (np.arange(rings - 1)[:, None] * AROUND + (np.arange(AROUND) + 1) % AROUND).ravel()
    triangles = np.concatenate(
        [np.stack([first, after, first + AROUND], 1), np.stack([after, after + AROUND, first + AROUND], 1)]
    )
    return vtp.surface(points, triangles)


def test_distances_are_along_the_normal():
    """A shift along the tube has a distance of 0. A wider tube is further out by the difference of the radii."""
    before, wide = tube(), tube(lambda z: 2.0)
    along = vtp.surface(vtp.points(wide) + [0, 0, 0.3], vtp.triangles(wide))
    assert coarse_walls.normal_distances(before, along, wide) == pytest.approx((0, 0), abs=1e-12)
    assert coarse_walls.normal_distances(before, tube(lambda z: 2.1), wide) == pytest.approx((0.1, 0.1), abs=1e-3)


def test_points_at_rest_do_not_count():
    """Half of the tube stays where it was. Only the other half is measured."""
    before, half = tube(), tube(lambda z: 2.0 if z < LENGTH / 2 else RADIUS)
    rms, worst = coarse_walls.normal_distances(before, tube(lambda z: 2.1 if z < LENGTH / 2 else RADIUS + 1), half)
    assert rms == pytest.approx(0.1, rel=0.05) and worst < 0.11


def test_summary_takes_the_median_time_and_the_largest_error_of_each_mesh():
    keys = ("case", "wall_edge_mm", "device_edge_mm", "cpu_seconds", *coarse_walls.ERROR_COLUMNS)
    rows_of_cases = [
        dict(zip(keys, row))
        for row in (("a", 0.8, 0.9, 2, 0.1, -0.5), ("b", 0.8, 0.9, 4, -0.3, 0.2), ("a", None, None, 9, 0, 0))
    ]
    rows = list(coarse_walls.summary_rows(rows_of_cases))
    assert [row["balanced"] for row in rows] == ["2 of 2", "1 of 2"]
    assert rows[0]["median_cpu_seconds"] == 3 and rows[0]["largest_cpu_seconds"] == 4
    assert [rows[0][f"largest_{key}"] for key in coarse_walls.ERROR_COLUMNS] == [-0.3, -0.5]
    assert rows[0]["median_mean_csa_error_percent"] == pytest.approx(0.2)


def test_errors_are_over_the_sections_that_both_runs_have():
    """A section that has no area in one of the two runs is left out of both."""
    nan = float("nan")
    errors = coarse_walls.area_errors(np.array([4.0, nan, 6.6, 2.1]), np.array([4.0, 9.0, nan, 2.0]))
    assert list(errors.values()) == pytest.approx([100 * (6.1 / 6.0 - 1), 5.0])
