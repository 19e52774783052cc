"""How a side branch begins inside its parent's lumen, and how the two are blended there."""

from dataclasses import dataclass

import numpy as np

BLEND_MM = 0.5  # two branches are blended where their fields differ by less than this, or by less in a narrow parent
STEEPEST_WIDENING = 1.5  # largest slope of a branch's radius at its root
LEAST_WIDENING = 0.2  # this slope is allowed at any angle
STEEPEST_SMOOTH_STEP = 1.875  # largest derivative of smooth_step, at x = 0.5


def smooth_step(x):
    """0 for x <= 0, 1 for x >= 1, twice continuously differentiable."""
    x = np.clip(x, 0, 1)
    return x * x * x * (10 - 15 * x + 6 * x * x)


def _smooth_step_slope(x):
    x = np.clip(x, 0, 1)
    return 30 * x * x * (1 - x) ** 2


@dataclass(frozen=True)
class Root:
    """The start of a side branch, which has a round end inside its parent.

    blend_mm: width of the blend with the parent. narrowing: share of the branch's radius that is missing at its start.
    widening_mm: length along its axis over which the branch becomes as wide as it is.

    If the round end were about as wide as the parent's lumen, it and the blend would bulge out of the opposite wall.
    So the start is narrower than the parent by the width of the blend. From there the branch widens with a slope of at
    most STEEPEST_WIDENING, and of at most the tangent of its angle to the parent. With a larger slope the edge of a
    section would come nearer to the opposite wall, though its centre moves away.
    """

    blend_mm: float = BLEND_MM
    narrowing: float = 0.0
    widening_mm: float = 1.0

    def share(self, s_mm):
        """Share (n,) of the branch's radius that it has at arc lengths s_mm (n,) from its start."""
        return 1 - self.narrowing * (1 - smooth_step(s_mm / self.widening_mm))

    def share_slope(self, s_mm):
        """Derivative (n,) of `share` with respect to arc length, 1/mm."""
        return self.narrowing * _smooth_step_slope(s_mm / self.widening_mm) / self.widening_mm


def root_of(branch, earlier):
    """The Root of a branch among `earlier` = [(branch, its Root)], the main vessel first.

    A branch that starts outside all others is not narrowed: it would not join them otherwise.
    """
    start, outward = branch.axis.point(0.0), branch.axis.frame(0.0)[0]
    room, tangent = max((_room_behind(start, outward, parent, root) for parent, root in earlier), default=(0.0, 0.0))
    if room <= 0:
        return Root()
    own = float(branch.radius(0.0))
    blend = min(BLEND_MM, 0.5 * room)
    missing = max(own - (room - blend), 0.0)
    length = STEEPEST_SMOOTH_STEP / min(STEEPEST_WIDENING, max(tangent, LEAST_WIDENING)) * missing
    return Root(blend, missing / own, length) if missing else Root(blend)


def _room_behind(point_mm, outward, parent, root):
    """(distance (mm) from a point in a parent's lumen to the wall behind it, tangent of the angle of its branch).

    The branch starts at the point in the direction outward, a unit vector (3,). The distance is 0 outside the lumen. A
    parent's section is taken as a circle.
    """
    s = parent.axis.nearest(point_mm[None])
    if parent.parent:
        s = np.maximum(s, 0.0)
    offset, tangent = point_mm - parent.axis.point(s)[0], parent.axis.frame(s)[0][0]
    radius = float((parent.least_radius(s) * root.share(s))[0])
    across = outward - (outward @ tangent) * tangent
    sine, cosine = float(np.linalg.norm(across)), abs(float(outward @ tangent))
    if np.linalg.norm(offset) >= radius:
        return 0.0, 0.0
    along = offset @ across / max(sine, 1e-12)
    return float(along + np.sqrt(radius**2 - offset @ offset + along**2)), sine / max(cosine, 1e-12)
