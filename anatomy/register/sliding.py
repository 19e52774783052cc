"""Whether the course of a vessel fixes the place along it, and which way round the vessel afterwards lies."""

import numpy as np

from .match import KEPT
from .search import stretch
from .tree import STEP_MM

SLID_RADII = 1.0  # by how much the lumen afterwards is slid, in usual radii
AS_WELL = 0.07  # of the usual radius: right pairs have up to 0.05, 30 mm of a real artery slid by a radius 0.10
DIFFERS = 0.14  # of the usual radius: a piece that fits so badly when slid is not straight, whatever its spread
STRAIGHT = 0.25  # of the usual radius: rms distance from a straight line, as of the centres of an eccentric lumen
NO_LANDMARKS = (np.zeros((0, 3)), np.zeros((0, 3)))


def slides(target, tree, placement, match):
    """Whether nothing but the ends says where along the vessel the lumen afterwards lies.

    Its main vessel is straight, or it fits well when it is slid by a radius and fitted again. The overlap alone is
    compared: the ends say where a piece was cut, not where it lies. Radii do not count, since the procedure has changed
    them. A second branch seen in both lumens fixes the place.
    """
    if _shares_a_branch(target, match):
        return False
    straight = _is_straight(target, tree)
    residual = slid_residual(target, tree, placement)
    if residual is None:
        return straight
    return residual < (DIFFERS if straight else AS_WELL)


def may_slide(target, tree, placement, match):
    """Whether a lone landmark may be all that fixes the place along the vessel: also any straight one, since the slid
    residual at a wrong place says nothing."""
    if _shares_a_branch(target, match):
        return False
    return _is_straight(target, tree) or slides(target, tree, placement, match)


def _shares_a_branch(target, match):
    return sum(name in target.tree.branches for name in match.names.values()) > 1


def _is_straight(target, tree):
    points = tree.branches["main"].points
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] / np.sqrt(len(points))
    return spread < STRAIGHT * target.usual_radius_mm


def slid_residual(target, tree, placement):
    """Residual, without the worst fifth and in usual radii, after the better slide of the two; None without overlap."""
    moved = placement.apply(tree.branches["main"].points)
    on, nearest, route = max((_overlap(target, line, moved) for line in target.tree.routes.values()), key=_count)
    shift = max(1, round(SLID_RADII * target.usual_radius_mm / STEP_MM))
    found = []
    for step in (-shift, shift):
        k = np.flatnonzero(on & (nearest + step >= 0) & (nearest + step < len(route.points)))
        if len(k) > shift:
            found.append(_refitted(route.points[nearest[k] + step], moved[k], target.usual_radius_mm))
    return min(found, default=None)


def _overlap(target, route, moved):
    """(mask (n,) of the moved points beside a route before, their nearest samples (n,) of it, the route)."""
    away = np.linalg.norm(moved[:, None] - route.points[None], axis=2)
    return away.min(axis=1) < target.usual_radius_mm, away.argmin(axis=1), route


def _count(overlap):
    return np.count_nonzero(overlap[0])


def _refitted(before, after, usual_radius_mm):
    _, placement = stretch(before, after, len(before), len(after), usual_radius_mm, NO_LANDMARKS)
    off = np.sort(np.linalg.norm(placement.apply(after) - before, axis=1))[: max(1, int(KEPT * len(before)))]
    return float(np.sqrt(np.mean(off**2))) / usual_radius_mm


def runs_along(target, tree, placement):
    """Mean cosine between the axes of both lumens, from the inlet on, over the first half of the shared main vessel.

    It is 1 if both run the same way and -1 if the inlet afterwards lies towards an outlet before; 1 without overlap.
    """
    moved = placement.apply(tree.branches["main"].points)
    _, distance, nearest = target.offsets(moved)
    tangents = np.gradient(moved, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    along = np.einsum("ij,ij->i", tangents, target.tangents[nearest])[distance < target.usual_radius_mm]
    return float(along[: (len(along) + 1) // 2].mean()) if along.size else 1.0
