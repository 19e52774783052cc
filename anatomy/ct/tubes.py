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

    def least_radius(self, s_mm):
        """Smallest radius (mm) of the sections at arc lengths s_mm."""
        return np.interp(s_mm, self.s_mm, self.radii_mm.min(axis=1))

    def radius_at(self, s_mm, theta):
        """Radius (n,) in mm at arc lengths (n,) and angles (n,) in radians."""
        s_mm = np.clip(s_mm, 0, self.axis.length_mm)
        return self._spline.ev(s_mm, np.mod(theta, 2 * np.pi))

    def radius_slopes(self, s_mm, theta):
        """Derivatives of radius_at with respect to arc length and to angle: (n,) and (n,) in mm/rad."""
        inside, angle = np.clip(s_mm, 0, self.axis.length_mm), np.mod(theta, 2 * np.pi)
        along = np.where(inside == s_mm, self._spline.ev(inside, angle, dx=1), 0.0)
        return along, self._spline.ev(inside, angle, dy=1)


class TubeField(LumenField):
    """Smooth union of the tubes. The field of a tube at x is |x - c(s)| - r(s, theta), c(s) the nearest axis point."""

    def radius(self, branch, s_mm, offset_mm):
        """Radius (n,) in mm of one tube at arc lengths s_mm (n,), in the directions of offset_mm (n, 3)."""
        _, across, up = _in_section(branch, s_mm, offset_mm)
        return branch.radius_at(s_mm, np.arctan2(up, across))

    def radius_gradient(self, branch, s_mm, offset_mm, arc_gradient):
        """Gradient (n, 3) of `radius` at the points that lie offset_mm (n, 3) from the axis at s_mm (n,).

        The frame does not rotate about the axis, so the angle changes only across the section.
        """
        (normal, binormal), across, up = _in_section(branch, s_mm, offset_mm)
        along, around = branch.radius_slopes(s_mm, np.arctan2(up, across))
        squared = np.maximum(across**2 + up**2, 1e-12)
        angle_gradient = (across / squared)[:, None] * binormal - (up / squared)[:, None] * normal
        return along[:, None] * arc_gradient + around[:, None] * angle_gradient


def _in_section(branch, s_mm, offset_mm):
    """((normals, binormals), each (n, 3), and the components (n,) and (n,) of offsets (n, 3) along them)."""
    _, normal, binormal = branch.axis.frame(s_mm)
    return (normal, binormal), np.sum(offset_mm * normal, axis=1), np.sum(offset_mm * binormal, axis=1)


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

    def axis_radius(self, number, s_mm):
        """Radius (n,) in mm of a tube, by its number, at arc lengths s_mm (n,). The image decides, also near a root."""
        return self.branches[number].radius(s_mm)

    def value(self, points_mm, iterations=4):
        """Field (n,) in mm, limited to the grid's band, since a level set far from the wall is meaningless."""
        level = self._levels[self._section_tree.query(points_mm)[1]] if self._section_tree else self._level
        return np.clip((level - self._hu_at(points_mm)) / self._slope, -NARROW_BAND_MM, NARROW_BAND_MM)

    def value_and_gradient(self, points_mm, step_mm=1e-4):
        """Field (n,) in mm and its gradient (n, 3), by central differences of step_mm, at points (n, 3)."""
        shifts = step_mm * np.eye(3)
        differences = [self.value(points_mm + shift) - self.value(points_mm - shift) for shift in shifts]
        return self.value(points_mm), np.stack(differences, axis=1) / (2 * step_mm)
