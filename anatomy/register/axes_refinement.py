"""Refines a placement that landmarks have chosen: by the axes alone, if the axes fix the place."""

import numpy as np

from . import placement_checks, search, sliding
from .match import match_branches
from .placement import cost, refine_placement


def refine_by_axes(target, tree, result, landmarks):
    """The SearchResult after refining its placement by the axes alone.

    Landmarks have chosen among several placements. But they are marked by hand, about a millimetre off. The axes of one
    vessel before and after fit within a tenth of that. The placement stays as it is if the refined one fits worse or
    has an unusual residual. It also stays if the axes do not fix the place along the vessel and the turn about it.
    Three landmarks that are not in one line decide alone.
    """
    if not len(landmarks[0]) or search.spans_a_plane(landmarks[1]) or not deviates_from_line(target.points):
        return result
    placement = refine_placement(target, tree, result.placement, sliding.NO_LANDMARKS)
    match, misfit = match_branches(target, tree, placement), cost(target, tree, placement)
    if misfit > cost(target, tree, result.placement) or placement_checks.is_residual_unusual(match):
        return result
    if sliding.fits_after_sliding(target, tree, placement, match):
        return result
    result.placement, result.cost = placement, misfit
    return result


def deviates_from_line(points):
    """Whether axes (n, 3) deviate from a straight line by 1 mm rms. Only then do they fix the turn about that line."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False) / np.sqrt(len(points))
    return spread[1] > 1.0
