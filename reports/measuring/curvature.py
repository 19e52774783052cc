"""Curvature of a centreline, and its mean over arc length."""

import numpy as np
from scipy.integrate import trapezoid
from scipy.interpolate import make_lsq_spline

from common.errors import InputError

DEGREE = 5
KNOT_SPACING_MM = 0.5  # with finer knots the spline would follow the rounding of single-precision points


def line_curvature(line, s_mm):
    """Curvature in 1/mm at the arc lengths s_mm (n,) of a Polyline.

    kappa = |r' x r''| / |r'|^3. Here r is a quintic least-squares spline of the line's points over s. It has a knot
    every 0.5 mm. If the points are far apart, it has one knot for two points.
    Raises InputError if the line has too few points for a second derivative.
    """
    count = len(line.s_mm)
    if count < 2 * DEGREE + 2:
        raise InputError("too few points for a curvature", line.source, count, f"at least {2 * DEGREE + 2} are needed")
    length = line.s_mm[-1] - line.s_mm[0]
    intervals = max(1, min(int(length / KNOT_SPACING_MM), (count - DEGREE) // 2))
    # knots lie at points of the line, so that each interval holds data even if the points are unevenly spaced
    inner = line.s_mm[np.linspace(0, count - 1, intervals + 1).round().astype(int)][1:-1]
    knots = np.concatenate([np.full(DEGREE + 1, line.s_mm[0]), inner, np.full(DEGREE + 1, line.s_mm[-1])])
    spline = make_lsq_spline(line.s_mm, line.points, knots, k=DEGREE)
    first, second = spline(s_mm, nu=1), spline(s_mm, nu=2)
    return np.linalg.norm(np.cross(first, second), axis=-1) / np.linalg.norm(first, axis=-1) ** 3


def mean_over_length(values, s_mm):
    """Mean of a profile over arc length, (1/L) integral of values ds by the trapezoidal rule."""
    return float(trapezoid(values, s_mm) / (s_mm[-1] - s_mm[0]))
