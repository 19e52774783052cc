"""Turns outlines into rings of equally many corresponding points with exact area, and interpolates between frames."""

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from .reading import outlines
from .reading.outlines import centroid

FINE_POINTS = 1000  # points of an outline resampled along its spline, for areas, lengths and distances


def smooth(outline, count=FINE_POINTS):
    """`count` points (count, 2) spaced evenly by length on the periodic cubic spline through an outline (n, 2)."""
    closed = np.vstack([outline, outline[:1]])
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    spline = CubicSpline(length, closed, bc_type="periodic")
    fine = spline(np.linspace(0, length[-1], max(4 * FINE_POINTS, 8 * len(outline)) + 1))
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
    wanted = np.linspace(0, along[-1], count, endpoint=False)
    return np.column_stack([np.interp(wanted, along, fine[:, k]) for k in range(2)])


def area_mm2(outline):
    """Area in mm2 within the smooth curve through an outline (n, 2); the polygon of its points encloses less."""
    return outlines.area_mm2(smooth(outline))


def ring_from_outline(outline, count):
    """Ring of `count` points (count, 2) on an outline (n, 2), evenly spaced by length, from about angle 0 on.

    Points of two rings correspond by their number, but hand-drawn outlines begin anywhere. So the start is shifted
    along the outline. Then the points' angles about the centroid agree on average with those of points on a circle that
    begins at angle 0.
    """
    fine = smooth(outline)
    centre = centroid(fine)
    angle = np.unwrap(np.arctan2(*(fine - centre).T[::-1]))
    behind = np.mean(
        angle - 2 * np.pi * np.arange(FINE_POINTS) / FINE_POINTS
    )  # mean angle by which the points lead those of a circle that begins at angle 0
    start = -behind / (2 * np.pi) * FINE_POINTS
    at = (start + np.arange(count) * FINE_POINTS / count) % FINE_POINTS
    closed = np.vstack([fine, fine[:1]])
    return np.column_stack([np.interp(at, np.arange(FINE_POINTS + 1), closed[:, k]) for k in range(2)])


def interpolator(z_mm, values):
    """Function that interpolates `values` (frames, ...), given at z_mm (frames,), rising, at any z (k,) in mm.

    It returns (k, ...). It is a monotone cubic, so between two frames its values lie between theirs. Beyond the ends it
    is constant.
    """
    if len(z_mm) == 1:
        return lambda z: np.repeat(values[:1], len(np.atleast_1d(z)), axis=0)
    curve = PchipInterpolator(z_mm, values, axis=0)
    return lambda z: curve(np.clip(np.atleast_1d(z), z_mm[0], z_mm[-1]))


def scale_to_areas(ring_list, areas_mm2):
    """Rings (k, n, 2) widened about their centroids until their polygons enclose areas_mm2 (k,).

    A polygon encloses a little less than its outline. Interpolated rings may even be narrower than both frames: between
    two slit-like lumens at an angle to each other they would show a stenosis that no frame has.
    """
    out = np.empty_like(ring_list)
    for k, (one, area) in enumerate(zip(ring_list, areas_mm2)):
        centre = centroid(one)
        out[k] = centre + np.sqrt(area / outlines.area_mm2(one)) * (one - centre)
    return out
