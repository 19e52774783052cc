"""Lumens found in an image as implicit fields, negative inside, for surface.build() to mesh."""

import numpy as np
from scipy.interpolate import RectBivariateSpline
from scipy.spatial import cKDTree

from common.implicit.field import NARROW_BAND_MM, LumenField


class Tube:
    """A branch whose radius depends on arc length and angle.

    parent: name of the branch that it leaves, or None. axis: Curve. radii_mm (n, m): radii at arc lengths s_mm (n,) and
    angles theta (m,) in radians. It has the attributes by which LumenField uses a branch of a synthetic tree.
    """

    def __init__(self, parent, axis, s_mm, theta, radii_mm):
        self.name, self.parent, self.axis = "main", parent, axis
        wrapped = np.concatenate([radii_mm[:, -3:], radii_mm, radii_mm[:, :3]], axis=1)
        step = theta[1] - theta[0]
        angles = np.concatenate([theta[0] + step * np.arange(-3, 0), theta, theta[-1] + step * np.arange(1, 4)])
        self._spline = RectBivariateSpline(s_mm, angles, wrapped)
        self.s_mm, self.radii_mm = s_mm, radii_mm
        self.healthy_radius_mm = radii_mm.max(axis=1)
        self._mean = np.sqrt(np.mean(radii_mm**2, axis=1))

    def radius(self, s_mm):
        """Equivalent radius (mm) at arc lengths s_mm."""
        return np.interp(s_mm, self.s_mm, self._mean)

    def radius_at(self, s_mm, theta):
        """Radius (n,) in mm at arc lengths (n,) and angles (n,) in radians."""
        s_mm = np.clip(s_mm, 0, self.axis.length_mm)
        return self._spline.ev(s_mm, np.mod(theta, 2 * np.pi))


class TubeField(LumenField):
    """Smooth union of the tubes. The field of a tube at x is |x - c(s)| - r(s, theta), c(s) the nearest axis point."""

    def branch_value(self, branch, points_mm, iterations=4):
        """Field (n,) in mm of one tube alone at points (n, 3)."""
        s = branch.axis.nearest(points_mm, iterations)
        if branch.parent:
            s = np.maximum(s, 0.0)
        offset = points_mm - branch.axis.point(s)
        _, normal, binormal = branch.axis.frame(s)
        theta = np.arctan2(np.sum(offset * binormal, axis=1), np.sum(offset * normal, axis=1))
        return np.linalg.norm(offset, axis=1) - branch.radius_at(s, theta)


class LevelField(LumenField):
    """The surface of one CT number in the image, near the tubes' axes, as an implicit field.

    The value (level - HU) over a typical slope is roughly a distance in mm.
    """

    def __init__(self, branches, hu_at, level_hu, slope_hu_per_mm, levels=None):
        """hu_at: function of points (n, 3) that gives the image's HU. slope_hu_per_mm: usual fall of HU at the wall.

        levels: for each branch the level (n,) in HU at its sections. It is needed if the level follows the blood's CT
        number along the branch; with None, level_hu holds everywhere.
        """
        super().__init__(branches)
        self._hu_at, self._level, self._slope = hu_at, level_hu, slope_hu_per_mm
        self._section_tree = cKDTree(np.concatenate([b.axis.point(b.s_mm) for b in branches])) if levels else None
        self._levels = np.concatenate(levels) if levels else None

    def value(self, points_mm, iterations=4):
        """Field (n,) in mm, limited to the grid's band, since a level set far from the wall is meaningless."""
        level = self._levels[self._section_tree.query(points_mm)[1]] if self._section_tree else self._level
        return np.clip((level - self._hu_at(points_mm)) / self._slope, -NARROW_BAND_MM, NARROW_BAND_MM)
