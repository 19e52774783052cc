"""Healthy radii of a tree: they step by a power law at bifurcations, and taper between them.

Along an ostium neither vessel tapers. So the radii on its three sides obey R_before^m = R_after^m + R_side^m exactly,
and the exponent m can be measured on the finished vessel.
"""

from dataclasses import dataclass

import numpy as np

from common.implicit.roots import BLEND_MM, smooth_step

TRANSITION_HALF_MM = 2.0  # half the length over which the main radius falls at a bifurcation


@dataclass(frozen=True)
class Bifurcation:
    """Healthy radii (mm) of the main vessel just before and after a side branch, and of that branch.

    s_mm: arc length at which the branch leaves the main axis. start_mm, end_mm: stretch of the main axis without taper.
    side_level_mm: length of the side branch's axis without taper, from its root. after_mm is 0 if the side branch is so
    wide that Murray's law leaves nothing for the main vessel; `patient.check` refuses that.
    """

    s_mm: float
    start_mm: float
    end_mm: float
    side_level_mm: float
    before_mm: float
    after_mm: float
    side_mm: float


def ordered_side_branches(vessel):
    """Side branches in the order in which they leave the main vessel: side1, side2, ..."""
    return sorted(vessel["side_branches"], key=lambda side: side["s_mm"])


def bifurcations(vessel):
    """[Bifurcation] of a vessel (defaults filled in), in the order of ordered_side_branches."""
    found, exponent = [], vessel["murray_exponent"]
    for side in ordered_side_branches(vessel):
        start = side["s_mm"] - TRANSITION_HALF_MM
        left = np.prod([(b.after_mm / b.before_mm) if b.before_mm else 0.0 for b in found])
        before = float(0.5 * vessel["main"]["ostial_diameter_mm"] * left * _main_taper(vessel, found, start))
        radius, angle = 0.5 * side["diameter_mm"], np.radians(side["angle_deg"])
        after = max(before**exponent - radius**exponent, 0.0) ** (1 / exponent)
        # `rim` is the distance along the main axis to the distal edge of the ostium on the main wall. Beyond the
        # distance `level` along the side branch, the branch is clear of that wall all round.
        rim = before / np.tan(angle) + radius / np.sin(angle) + BLEND_MM
        level = before / np.sin(angle) + radius / abs(np.tan(angle)) + BLEND_MM
        end = side["s_mm"] + max(TRANSITION_HALF_MM, rim)
        found.append(Bifurcation(side["s_mm"], start, end, level, before, after, radius))
    return found


def main_healthy_radius(vessel, s_mm):
    """Healthy main radius (mm) at arc lengths s_mm of the main vessel's axis before any lesion."""
    s_mm, found, exponent = np.asarray(s_mm, float), bifurcations(vessel), vessel["murray_exponent"]
    share = np.ones(s_mm.shape)
    for b in found:
        transition = smooth_step((s_mm - b.start_mm) / (2 * TRANSITION_HALF_MM))
        lost_share = 1 - (b.after_mm / b.before_mm) ** exponent if b.before_mm else 0.0
        share = share * (1 - transition * lost_share)
    return 0.5 * vessel["main"]["ostial_diameter_mm"] * share ** (1 / exponent) * _main_taper(vessel, found, s_mm)


def side_healthy_radius(side, bifurcation, s_mm):
    """Healthy radius (mm) of a side branch at arc lengths s_mm from its root: constant in its ostium, then tapered."""
    return bifurcation.side_mm * _taper(side, np.maximum(np.asarray(s_mm, float) - bifurcation.side_level_mm, 0))


def _taper(branch, length_mm):
    return (1 - 0.01 * branch["taper_percent_per_cm"]) ** (length_mm / 10)


def _main_taper(vessel, bifurcations, s_mm):
    """Factor (0 ... 1) by which taper reduces the main radius at s_mm. There is none in the ostia of `bifurcations`."""
    untapered_mm, reached = 0.0, -np.inf
    for b in bifurcations:
        start = max(b.start_mm, reached)  # ostia may overlap
        untapered_mm = untapered_mm + np.clip(s_mm - start, 0, max(b.end_mm - start, 0))
        reached = max(reached, b.end_mm)
    return _taper(vessel["main"], s_mm - untapered_mm)
