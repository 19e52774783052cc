"""Tells whether the course of a vessel fixes the place along it, and whether the vessel afterwards is reversed."""

import numpy as np

from .match import KEPT_SHARE
from .search import fit_stretch
from .tree import STEP_MM

# All lengths and residuals here are in usual radii.
SLID_RADII = 1.0  # distance by which the lumen afterwards is slid along the vessel
SLID_RESIDUAL = (
    0.07  # a slid lumen fits well below this residual; right pairs in place have 0.05, 30 mm of a real artery slid 0.10
)
STRAIGHT_SLID_RESIDUAL = 0.14  # the same limit for a vessel that counts as straight
STRAIGHT_SPREAD = (
    0.25  # below this rms distance of its axis from a line a vessel counts as straight; eccentric lumens have so much
)
NO_LANDMARKS = (np.zeros((0, 3)), np.zeros((0, 3)))


def fits_after_sliding(target, tree, placement, match):
    """Whether nothing but the ends tells where along the vessel the lumen afterwards lies.

    This is so if it also fits after it is slid along the vessel by a radius and fitted again. If the main vessel is
    straight, a worse fit counts too. Only the overlap is compared: the ends show where a piece was cut, not where it
    lies. Radii do not count, since the procedure has changed them. A second branch in both lumens fixes the place.
    """
    if _shares_a_branch(target, match):
        return False
    straight = _is_straight(target, tree)
    residual = slid_residual(target, tree, placement)
    if residual is None:
        return straight
    return residual < (STRAIGHT_SLID_RESIDUAL if straight else SLID_RESIDUAL)


def depends_on_landmark(target, tree, placement, match):
    """Whether a lone landmark may be all that fixes the place along the vessel.

    This is true of every straight vessel without a second common branch, whatever fits_after_sliding() says. If the
    landmark has put the lumen at a wrong place, the residual after sliding tells nothing.
    """
    if _shares_a_branch(target, match):
        return False
    return _is_straight(target, tree) or fits_after_sliding(target, tree, placement, match)


def _shares_a_branch(target, match):
    return sum(name in target.tree.branches for name in match.names.values()) > 1


def _is_straight(target, tree):
    points = tree.branches["main"].points
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] / np.sqrt(len(points))
    return spread < STRAIGHT_SPREAD * target.usual_radius_mm


def slid_residual(target, tree, placement):
    """The residual of the main vessel after it is slid along the vessel by a radius and fitted again.

    It is in usual radii, without the worst fifth, and the smaller one of sliding to either side. None without enough
    overlap. target, tree: the lumen before (Target) and afterwards (Tree).
    """
    moved = placement.apply(tree.branches["main"].points)
    on, nearest, route = max(
        (_overlap(target, line, moved) for line in target.tree.routes.values()), key=_overlap_count
    )
    shift = max(1, round(SLID_RADII * target.usual_radius_mm / STEP_MM))
    residuals = []
    for step in (-shift, shift):
        k = np.flatnonzero(on & (nearest + step >= 0) & (nearest + step < len(route.points)))
        if len(k) > shift:
            residuals.append(_refit_residual(route.points[nearest[k] + step], moved[k], target.usual_radius_mm))
    return min(residuals, default=None)


def _overlap(target, route, moved):
    """(which moved points (n,) lie beside a route before, their nearest samples (n,) on the route, the route)."""
    away = np.linalg.norm(moved[:, None] - route.points[None], axis=2)
    return away.min(axis=1) < target.usual_radius_mm, away.argmin(axis=1), route


def _overlap_count(overlap):
    return np.count_nonzero(overlap[0])


def _refit_residual(before, after, usual_radius_mm):
    _, placement = fit_stretch(before, after, len(before), len(after), usual_radius_mm, NO_LANDMARKS)
    off = np.sort(np.linalg.norm(placement.apply(after) - before, axis=1))[: max(1, int(KEPT_SHARE * len(before)))]
    return float(np.sqrt(np.mean(off**2))) / usual_radius_mm


def direction_cosine(target, tree, placement):
    """Mean cosine between the directions of both lumens' axes, over the first half of the shared main vessel.

    It is about 1 if both run in the same direction, and -1 if the lumen afterwards is reversed. Without overlap it is
    1.
    """
    moved = placement.apply(tree.branches["main"].points)
    _, distance, nearest = target.offsets(moved)
    tangents = np.gradient(moved, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    along = np.einsum("ij,ij->i", tangents, target.tangents[nearest])[distance < target.usual_radius_mm]
    return float(along[: (len(along) + 1) // 2].mean()) if along.size else 1.0
