"""Searches the placement of the lumen after the procedure: tries all pairs of routes and offsets, refines the best."""

import numpy as np

from .placement import LANDMARK_WEIGHT, Target, cost, fit_rigid, refine_placement

LEAST_OVERLAP_SHARE = 0.5  # share of the shorter route that must overlap; shorter stretches may be similar by chance
MOST_REFINED_PLACEMENTS = 12  # number of placements that are refined at most
REWEIGHTINGS = 3  # two stretches are fitted again this many times, with new weights
EQUAL_COST = 0.1  # difference in cost (0 to 1) below which placements are equally good
DISTINCT_RADII = 1.0  # mean distance, in usual radii, beyond which two placements of the lumen are different


class SearchResult:
    """The best placement and its cost. rival, rival_cost: the best of the clearly different ones, None without one.

    ranked: [(cost, Placement)], the best first.
    """

    def __init__(self, ranked, target, tree):
        self.cost, self.placement = ranked[0]
        far = DISTINCT_RADII * target.usual_radius_mm
        others = [(c, p) for c, p in ranked[1:] if p.mean_distance_mm(self.placement, tree.points) > far]
        self.rival_cost, self.rival = others[0] if others else (None, None)


def find_placement(pre, post, landmarks):
    """The SearchResult for two Trees. landmarks: (pre (m, 3), post (m, 3)) in mm.

    Three landmarks that are not in one line decide alone. Otherwise every route from the inlet to an end of one tree is
    fitted to every route of the other, at every offset along it. The best dozen are refined with all branches.
    """
    target = Target(pre)
    if spans_a_plane(landmarks[1]):
        placement = fit_rigid(landmarks[1], landmarks[0])
        return SearchResult([(cost(target, post, placement), placement)], target, post)
    starts = sorted(candidates(pre, post, landmarks), key=lambda pair: pair[0])
    ranked = []
    for _, start in distinct_starts(starts, target, post):
        placement = refine_placement(target, post, start, landmarks)
        ranked.append(
            (cost(target, post, placement) + landmark_distance_radii(landmarks, placement, target), placement)
        )
    return SearchResult(sorted(ranked, key=lambda pair: pair[0]), target, post)


def spans_a_plane(points):
    """Whether points (m, 3) fix a rigid motion: three or more, not in one line."""
    if len(points) < 3:
        return False
    return np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] > 1.0  # mm; it is 0 for points in one line


def landmark_distance_radii(landmarks, placement, target):
    """Mean distance, in usual radii, between the landmarks' two places after the motion; 0 without landmarks."""
    pre, post = landmarks
    if not len(pre):
        return 0.0
    return float(np.linalg.norm(placement.apply(post) - pre, axis=1).mean()) / target.usual_radius_mm


def candidates(pre, post, landmarks):
    """Yields (misfit, Placement) of every pair of routes at every offset, by fit_stretch()."""
    usual_radius = pre.usual_radius_mm
    for route in pre.routes.values():
        for other in post.routes.values():
            n, m = len(route.points), len(other.points)
            least = int(LEAST_OVERLAP_SHARE * min(n, m))
            for offset in range(least - m, n - least + 1):  # sample k of `other` goes to sample k + offset of `route`
                start, end = max(0, offset), min(n, m + offset)
                yield fit_stretch(
                    route.points[start:end], other.points[start - offset : end - offset], n, m, usual_radius, landmarks
                )


def fit_stretch(pre, post, n, m, usual_radius, landmarks):
    """(misfit, Placement) of two stretches (k, 3), fitted sample by sample, of routes with n and m samples.

    The misfit is that of cost(), for these two routes alone: each sample outside the stretches counts 1. The mean
    distance of the landmarks in usual radii is added.
    """
    marks = len(landmarks[0])
    first = np.concatenate([pre, landmarks[0]])
    second = np.concatenate([post, landmarks[1]])
    weights = np.ones(len(first))
    weights[len(pre) :] = LANDMARK_WEIGHT * len(pre) / max(marks, 1)
    for _ in range(1 + REWEIGHTINGS):
        placement = fit_rigid(second, first, weights)
        squared = np.sum((placement.apply(second) - first) ** 2, axis=1) / usual_radius**2
        weights[: len(pre)] = 1.0 / (1.0 + 4.0 * squared[: len(pre)]) ** 2
    near = 2.0 * np.minimum(squared[: len(pre)], 1.0).sum()
    missing = n + m - 2 * len(pre)
    return (near + missing) / (n + m) + (np.sqrt(squared[len(pre) :]).mean() if marks else 0.0), placement


def distinct_starts(starts, target, tree):
    """The first MOST_REFINED_PLACEMENTS of the sorted [(misfit, Placement)] that differ from each other.

    Two differ if they are more than half a usual radius apart on average.
    """
    kept = []
    for misfit, start in starts:
        if all(start.mean_distance_mm(other, tree.points) > 0.5 * target.usual_radius_mm for _, other in kept):
            kept.append((misfit, start))
            if len(kept) == MOST_REFINED_PLACEMENTS:
                break
    return kept
