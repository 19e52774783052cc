"""Outlines as rings of equally many corresponding points with exact area, and interpolation between frames."""

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from .reading import outlines
from .reading.outlines import centroid

FINE = 1000  # points of an outline resampled along its spline, for areas, lengths and distances


def smooth(outline, count=FINE):
    """`count` points (count, 2) spaced evenly by length on the periodic cubic spline through an outline (n, 2)."""
    closed = np.vstack([outline, outline[:1]])
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    spline = CubicSpline(length, closed, bc_type="periodic")
    fine = spline(np.linspace(0, length[-1], max(4 * FINE, 8 * len(outline)) + 1))
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
    wanted = np.linspace(0, along[-1], count, endpoint=False)
    return np.column_stack([np.interp(wanted, along, fine[:, k]) for k in range(2)])


def area_mm2(outline):
    """Area within the spline through an outline (n, 2), the one measure of frames; its corners alone enclose less."""
    return outlines.area_mm2(smooth(outline))


def ring(outline, count):
    """Ring (count, 2) of an outline (n, 2), evenly spaced by length, which begins at about angle 0.

    Points of two rings correspond by their number. Hand-drawn outlines begin anywhere. So the ring's start is shifted
    along the outline until the angles round the centroid differ least, on average, from a circle's.
    """
    fine = smooth(outline)
    centre = centroid(fine)
    angle = np.unwrap(np.arctan2(*(fine - centre).T[::-1]))
    behind = np.mean(angle - 2 * np.pi * np.arange(FINE) / FINE)  # mean lead over a circle that begins at angle 0
    start = -behind / (2 * np.pi) * FINE
    at = (start + np.arange(count) * FINE / count) % FINE
    closed = np.vstack([fine, fine[:1]])
    return np.column_stack([np.interp(at, np.arange(FINE + 1), closed[:, k]) for k in range(2)])


def between(z_mm, values):
    """Function of z through `values` (frames, ...) at the rising z_mm, constant beyond the ends.

    It is a monotone cubic: between two frames its values are between theirs.
    """
    if len(z_mm) == 1:
        return lambda z: np.repeat(values[:1], len(np.atleast_1d(z)), axis=0)
    curve = PchipInterpolator(z_mm, values, axis=0)
    return lambda z: curve(np.clip(np.atleast_1d(z), z_mm[0], z_mm[-1]))


def scaled(ring_list, areas_mm2):
    """Rings (k, n, 2) widened about their centroids to enclose areas_mm2 (k,).

    A polygon loses a little of its outline's area. Between two slits at an angle to each other interpolated rings would
    be narrower than both, a stenosis that no frame shows.
    """
    out = np.empty_like(ring_list)
    for k, (one, area) in enumerate(zip(ring_list, areas_mm2)):
        centre = centroid(one)
        out[k] = centre + np.sqrt(area / outlines.area_mm2(one)) * (one - centre)
    return out
