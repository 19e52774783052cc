"""Middles of edges on the smooth surface converge to a cylinder, and rims stay in their plane."""

import numpy as np
import pytest

import tubes
from flow.geometry import smooth_surface


def _radius_errors(edge_mm):
    """Largest errors in mm: (radius at the middles of straight edges and of smooth edges, both away from the ends,
    radius of smooth edges at the rims, shift of the rims out of their plane)."""
    tube = tubes.tube(8, lambda s: 1.5, edge_mm)
    edges, side = tube.edges()
    on_wall, on_rim = smooth_surface.edge_kinds(tube, edges, side)
    middles = smooth_surface.edge_middles(tube, edges, side)
    straight = tube.points[edges].mean(axis=1)
    inner = on_wall & (np.abs(straight[:, 0] - 4) < 2.5)
    error = [np.abs(np.hypot(x[:, 1], x[:, 2]) - 1.5) for x in (straight, middles)]
    rim_plane = np.abs(middles[on_rim, 0] - tube.points[edges[on_rim]].mean(axis=1)[:, 0]).max()
    return error[0][inner].max(), error[1][inner].max(), error[1][on_rim].max(), rim_plane


def test_middles_converge_to_the_cylinder():
    coarse, fine = _radius_errors(0.6), _radius_errors(0.3)
    assert coarse[1] < 0.02 * coarse[0]
    assert np.log2(coarse[1] / fine[1]) > 3.5  # the order is four; that of straight edges is two
    assert np.log2(coarse[0] / fine[0]) == pytest.approx(2, abs=0.2)
    assert coarse[2] < 1e-12  # a circular rim is met exactly


def test_rims_stay_in_their_plane():
    assert _radius_errors(0.5)[3] < 1e-12
