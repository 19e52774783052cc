"""Comparison of the slices with other models: areas of curves, errors by region, stations of the mesh."""

import numpy as np
import pytest

from data_synthetic.reference.checks import against_solid
from data_synthetic.reference.tube import procedure as tube_procedure


def test_area_of_a_smooth_closed_curve():
    theta = 2 * np.pi * np.arange(24) / 24
    radius = 1 + 0.2 * np.cos(3 * theta)
    curves = np.stack([radius, 2 * radius])
    area = tube_procedure.enclosed_area(curves * np.cos(theta), curves * np.sin(theta))
    assert area == pytest.approx(np.pi * (1 + 0.02) * np.array([1, 4]), rel=1e-12)


def test_stations_have_corners_at_the_breaks():
    s = tube_procedure.station_positions([2.0, 5.0, 11.0], 2.0)
    corners = s[::2]
    assert {2.0, 5.0, 11.0} <= set(corners) and len(s) % 2 == 1
    assert np.diff(corners).max() <= 2.0 + 1e-12
    assert s[1::2] == pytest.approx(0.5 * (corners[1:] + corners[:-1]))


def test_errors_are_told_by_region():
    s = np.arange(0, 20, 0.1)
    against = 8 + 0.5 * np.cos(s)
    inside = (s > 4.99) & (s < 15.01)
    area = against * np.where(inside, 1.01, 0.98)
    found = against_solid.area_errors(s, area, against, (4.99, 15.01))
    assert found["stent_area_percent"]["mean"] == pytest.approx(1.0)
    assert found["beyond_area_percent"]["largest"] == pytest.approx(-2.0)
    assert -2 < found["stent_edges_area_percent"]["mean"] < 1
    assert found["minimal_lumen_area_in_stent_percent"] == pytest.approx(1.0)
    share = np.where(inside, 1.01, 0.98) ** -2
    expected = 100 * (np.sum(share * against**-2) / np.sum(against**-2) - 1)
    assert found["resistance_percent"] == pytest.approx(expected)
