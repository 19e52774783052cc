import numpy as np
import pytest

from common import vtp
from data_synthetic.ct import evaluate


def test_area_of_an_oblique_cut_and_of_a_missed_one(ct_tubes):
    poly, direction = ct_tubes.tube(lambda z: np.full(len(z), 1.5), around=96)
    mesh = vtp.points_and_triangles(poly)
    centre = 7.0 * direction
    chords = 0.5 * 96 * np.sin(2 * np.pi / 96) / np.pi  # area of the regular polygon over that of the circle
    assert evaluate.section_area(*mesh, centre, direction) == pytest.approx(np.pi * 2.25 * chords, rel=1e-3)
    across = np.cross(direction, [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    oblique = (direction + across) / np.sqrt(2)
    area = evaluate.section_area(*mesh, centre, oblique)
    assert area == pytest.approx(np.pi * 2.25 * chords * np.sqrt(2), rel=2e-3)
    assert np.isnan(evaluate.section_area(*mesh, centre + 20 * direction, direction))
    assert np.isnan(evaluate.section_area(*mesh, centre + 5 * across, direction))


def test_compare_says_bias_limits_and_resistance(ct_tubes):
    true, direction = ct_tubes.tube(lambda z: 1.2 + 0.02 * z)
    found, _ = ct_tubes.tube(lambda z: (1.2 + 0.02 * z) * 1.05)
    places = [("main", s, s * direction, direction) for s in np.arange(2, 12, 0.5)]
    result = evaluate.compare_areas(vtp.points_and_triangles(true), vtp.points_and_triangles(found), places)
    area = np.pi * (1.2 + 0.02 * np.arange(2, 12, 0.5)) ** 2
    assert result["sections"] == 20 and result["lost_sections"] == 0
    assert result["resistance_ratio"] == pytest.approx(1.05**-4, rel=1e-3)
    assert result["mean_difference_mm2"] == pytest.approx((0.1025 * area).mean(), rel=0.01)
    assert result["sd_mm2"] == pytest.approx((0.1025 * area).std(ddof=1), rel=0.02)
    radius = 0.05 * np.sqrt(area / np.pi)
    assert result["mean_radius_difference_mm"] == pytest.approx(radius.mean(), rel=0.01)
    assert result["sd_radius_mm"] == pytest.approx(radius.std(ddof=1), rel=0.02)
    half = evaluate.compare_areas(
        vtp.points_and_triangles(true), vtp.points_and_triangles(found), places, {"main": (2, 6)}
    )
    assert half["sections"] == 9 and half["mean_difference_mm2"] < result["mean_difference_mm2"]


def test_sections_keep_clear_of_ends_and_ostia(branches):
    found = evaluate.comparison_sections(branches)
    main, side = branches
    s = np.array([row[1] for row in found if row[0] == "main"])
    assert s.min() > 1.5 * main.radius_mm[0] and s.max() < main.axis.length_mm - 1.5 * main.radius_mm[-1]
    assert np.abs(s - side.s_on_parent_mm).min() > 1.0
    on_side = np.stack([row[2] for row in found if row[0] == side.name])
    away = np.linalg.norm(on_side - main.axis.point(main.axis.nearest(on_side)), axis=1)
    assert away.min() > main.radius_mm.min()
