"""Places on a line in space: points (n, 3) in mm and their increasing arc lengths s_mm (n,)."""

import numpy as np


def point_at(points, s_mm, at_mm):
    """Points (..., 3) in mm at arc lengths at_mm (...), by linear interpolation. Beyond an end: the end point."""
    return np.stack([np.interp(at_mm, s_mm, points[:, k]) for k in range(3)], axis=-1)


def project(points, s_mm, point):
    """(arc length, distance) in mm of the place on the line that is nearest to `point` (3,)."""
    start, span = points[:-1], np.diff(points, axis=0)
    squared = np.maximum(np.einsum("ij,ij->i", span, span), 1e-300)  # two points may be at one place
    t = np.clip(np.einsum("ij,ij->i", point - start, span) / squared, 0.0, 1.0)
    distance = np.linalg.norm(start + t[:, None] * span - point, axis=1)
    nearest = int(distance.argmin())
    s = s_mm[nearest] + t[nearest] * (s_mm[nearest + 1] - s_mm[nearest])
    return float(s), float(distance[nearest])
