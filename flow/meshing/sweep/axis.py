"""Cross-section planes along a branch: perpendicular to its axis, turned into the caps' planes towards its ends."""

import numpy as np

from flow.geometry.vectors import dot, unit

# Section planes turn from the plane of a cap until they are perpendicular to the axis over this length, in radii of the
# cap.
BLEND_RADII = 2.5


class Axis:
    """The axis of one branch, and the inlet or outlet caps at its ends.

    first, last: (centre (3,), unit normal (3,) along the branch, radius) in mm of the cap at the start and at the end.
    They are None without a cap: a side branch starts within another vessel. If the cap lies beyond the branch's end,
    the axis continues straight to the cap, so length_mm may exceed the branch's length.
    """

    def __init__(self, branch, first=None, last=None):
        points = branch.points
        if last is not None:
            more = float(dot(last[0] - points[-1], last[1]))
            if more > 1e-6:
                points = np.concatenate([points, (points[-1] + more * last[1])[None]])
        self.branch, self.first, self.last = branch, first, last
        self.points = points
        self.s_mm = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        # the branch keeps its own s_mm, though its polyline may be slightly shorter
        own = len(branch.points)
        self.s_mm = np.concatenate(
            [branch.s_mm - branch.s_mm[0], branch.length_mm + self.s_mm[own:] - self.s_mm[own - 1]]
        )
        slope = np.gradient(points, self.s_mm, axis=0)
        self.tangents = unit(slope)

    @property
    def length_mm(self):
        """Length of the axis in mm."""
        return float(self.s_mm[-1])

    def radius(self, s_mm):
        """Radius in mm of the branch at s_mm."""
        return self.branch.radius(s_mm)

    def planes(self, s_mm):
        """(origins (m, 3) in mm, unit normals (m, 3)) of the section planes at arc lengths s_mm (m,)."""
        origin = np.stack([np.interp(s_mm, self.s_mm, self.points[:, k]) for k in range(3)], axis=-1)
        normal = np.stack([np.interp(s_mm, self.s_mm, self.tangents[:, k]) for k in range(3)], axis=-1)
        for cap, end, distance in ((self.first, 0, s_mm), (self.last, -1, self.length_mm - s_mm)):
            if cap is not None:
                centre, direction, radius = cap
                share = np.clip(1.0 - distance / (BLEND_RADII * radius), 0.0, 1.0)
                share = (share**2 * (3.0 - 2.0 * share))[:, None]
                gap = dot(centre - self.points[end], direction)
                origin = origin + share * gap * direction
                normal = normal + share * (direction - self.tangents[end])
        return origin, unit(normal)


def frames(origins, normals):
    """Unit vectors e1, e2 (m, 3) that span each section plane and turn as little as possible along the axis.

    origins, normals: as `Axis.planes` gives them. Rotation-minimising frames by double reflection (Wang, Juettler,
    Zheng, Liu 2008, ACM Trans Graph 27).
    """
    start = np.eye(3)[np.argmin(np.abs(normals[0]))]
    e1 = [unit(np.cross(normals[0], start))]
    for k in range(len(origins) - 1):
        step = origins[k + 1] - origins[k]
        reflected = e1[-1] - 2.0 * dot(step, e1[-1]) / dot(step, step) * step
        tangent = normals[k] - 2.0 * dot(step, normals[k]) / dot(step, step) * step
        other = normals[k + 1] - tangent
        square = dot(other, other)
        turned = reflected - 2.0 * dot(other, reflected) / square * other if square > 1e-24 else reflected
        e1.append(unit(turned - dot(turned, normals[k + 1]) * normals[k + 1]))
    e1 = np.array(e1)
    return e1, np.cross(normals, e1)
