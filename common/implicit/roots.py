"""How a side branch begins inside its parent's lumen, and how the two are blended there."""

from dataclasses import dataclass

import numpy as np

BLEND_MM = 0.5  # two branches are blended where their fields differ by less than this, or by less in a narrow parent
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
    So the start is narrower than the parent by the width of the blend, and the branch widens with a slope of at most 1.
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
    """The Root of a branch among the branches `earlier`, the main vessel first. The main vessel has a plain one.

    A branch that starts outside all others is not narrowed: it would not join them otherwise.
    """
    depth = max((_depth(branch.axis.point(0.0), parent) for parent in earlier), default=0.0)
    if depth <= 0:
        return Root()
    own = float(branch.radius(0.0))
    blend = min(BLEND_MM, 0.5 * depth)
    missing = max(own - (depth - blend), 0.0)
    return Root(blend, missing / own, STEEPEST_SMOOTH_STEP * missing) if missing else Root(blend)


def _depth(point_mm, parent):
    """Distance (mm) from a point to the nearest wall of `parent`, negative outside its lumen."""
    s = parent.axis.nearest(point_mm[None])
    return float(parent.least_radius(s)[0] - np.linalg.norm(point_mm - parent.axis.point(s)[0]))
