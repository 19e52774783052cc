"""Checks whether a placement can be trusted. Each refusal gives the figure that is out of range, and a remedy."""

import numpy as np
from scipy.spatial import cKDTree

from common.errors import InputError

from . import search, sliding
from .match import match_branches
from .tree import MIRROR, Line, Tree

# A right pair is one vessel before and after. Residuals and distances are in usual radii (Tree.usual_radius_mm).
# Least share of both lumens' axes (with landmarks: of the shorter lumen's) that must coincide. Right pairs with a third
# cut off have 0.8, different vessels 0.55.
LEAST_AXIS_SHARE = 0.6
USUAL_RESIDUAL = 0.1  # above it a warning is given: right pairs have up to 0.05, with noise, cuts or a stent
LARGEST_RESIDUAL = 0.3  # above it a placement is refused: different vessels on each other have 0.11 to 0.48
LARGEST_RESIDUAL_WITH_LANDMARKS = 0.6  # the same limit if the user gives landmarks
DOUBTFUL_LANDMARK_RADII = 0.5  # a warning is given if a landmark's two places are farther apart after the placement
LARGEST_LANDMARK_RADII = 1.0  # the placement is refused if they are farther apart
# Largest distance of a landmark from its vessel's axes. Landmarks are spots on the wall, mouths of branches or the rim
# of the ostium.
LARGEST_AXIS_RADII = 3.0
LANDMARKS_REMEDY = "give `registration: landmarks` (pre_mm, post_mm of each): places that are seen in both lumens"


def axis_shares(target, tree, placement):
    """(share of both axes together, larger of the two single shares) that lies within a usual radius of the other axes.

    The second value is large also if one lumen is a piece of the other. target: the lumen before (Target). tree: the
    lumen afterwards (Tree), moved by the placement.
    """
    moved = placement.apply(tree.points)
    _, to_pre, _ = target.offsets(moved)
    to_post, _ = cKDTree(moved).query(target.points)
    near_post, near_pre = to_pre < target.usual_radius_mm, to_post < target.usual_radius_mm
    return float(np.concatenate([near_post, near_pre]).mean()), float(max(near_post.mean(), near_pre.mean()))


def check_landmarks(case_file, pre, post, landmarks):
    """Raises InputError if a landmark lies farther than LARGEST_AXIS_RADII from its own Tree.

    It is then probably given in other coordinates. landmarks: (pre (m, 3), post (m, 3)) in mm, their places in the two
    lumens. The radius is the usual one, or the vessel's own at the nearest place if that is larger.
    """
    for tree, points, key, of in ((pre, landmarks[0], "pre_mm", "lumen"), (post, landmarks[1], "post_mm", "post")):
        for number, point in enumerate(points, start=1):
            away = np.linalg.norm(tree.points - point, axis=1)
            radius = max(tree.usual_radius_mm, tree.radius[away.argmin()])
            if away.min() > LARGEST_AXIS_RADII * radius:
                x, y, z = tree.points[away.argmin()]
                raise InputError(
                    "a landmark lies far from its vessel",
                    f"{case_file}: registration: landmark {number}, {key}",
                    f"{away.min():.1f} mm from the axis at {x:.2f}, {y:.2f}, {z:.2f}, where the vessel's radius is "
                    f"{radius:.2f} mm",
                    f"a place within {LARGEST_AXIS_RADII:g} radii of the axis, in mm and in the coordinates of `{of}` "
                    "(straight contours: z of their table, x and y from the frame's centre)",
                )


def check_fit(where, target, tree, result, match, landmarks):
    """Raises InputError if the placement does not fit, or if another one fits equally well.

    target, tree: the lumen before (Target) and afterwards (Tree). result, match: search.SearchResult and Match.
    landmarks: (pre (m, 3), post (m, 3)) in mm. where: the case file's place, for messages.
    """
    radius = f"{match.usual_radius_mm:.2f} mm, the vessel's usual radius"
    both, contained = axis_shares(target, tree, result.placement)
    has_landmarks = len(landmarks[0]) > 0
    distances_mm = landmark_distances_mm(result.placement, landmarks)
    if has_landmarks and distances_mm.max() > LARGEST_LANDMARK_RADII * match.usual_radius_mm:
        raise InputError(
            "a landmark does not fit",
            f"{where}: landmark {1 + int(distances_mm.argmax())}",
            f"{distances_mm.max():.2f} mm off, at most {radius}; the axes fit within {match.trimmed_mm:.2f} mm",
            "correct its place in the one lumen or the other",
        )
    share, of = (contained, "the shorter lumen's axes") if has_landmarks else (both, "both lumens' axes")
    largest = LARGEST_RESIDUAL_WITH_LANDMARKS if has_landmarks else LARGEST_RESIDUAL
    value = None
    if share < LEAST_AXIS_SHARE:
        value = f"{100 * share:.0f} % of {of} lie on the other's, "
        value += f"{100 * LEAST_AXIS_SHARE:.0f} % are wanted (within {radius})"
    elif match.trimmed_mm > largest * match.usual_radius_mm:
        value = f"residual {match.trimmed_mm:.2f} mm (without the worst fifth), at most {largest:g} of {radius}"
    if value:
        _check_fit_without_landmarks(where, target, tree, landmarks)
        raise InputError(
            "the lumen after the procedure does not fit on the one before",
            where,
            value,
            "is it the same vessel, with the right units and inlet? Cut what only one of them has, or "
            + ("check the landmarks' places" if has_landmarks else LANDMARKS_REMEDY),
        )
    if result.rival is not None and result.rival_cost < result.cost + search.EQUAL_COST:
        apart = result.placement.mean_distance_mm(result.rival, tree.points)
        raise InputError(
            "two placements of the lumen after the procedure fit alike",
            where,
            f"misfits {result.cost:.2f} and {result.rival_cost:.2f} of 1, {apart:.1f} mm apart",
            LANDMARKS_REMEDY,
        )


def _check_fit_without_landmarks(where, target, tree, landmarks):
    """Raises InputError with the worst landmark if the axes alone fit well: a landmark is wrong then, not the axes."""
    if not len(landmarks[0]):
        return
    alone = search.find_placement(target.tree, tree, sliding.NO_LANDMARKS)
    match = match_branches(target, tree, alone.placement)
    both, _ = axis_shares(target, tree, alone.placement)
    if (
        is_residual_unusual(match)
        or both < LEAST_AXIS_SHARE
        or alone.rival is not None
        and alone.rival_cost < alone.cost + search.EQUAL_COST
    ):
        return
    distances_mm = landmark_distances_mm(alone.placement, landmarks)
    raise InputError(
        "a landmark does not fit",
        f"{where}: landmark {1 + int(distances_mm.argmax())}",
        f"{distances_mm.max():.2f} mm off where the axes alone fit within {match.trimmed_mm:.2f} mm",
        "correct its place in the one lumen or the other, or leave the landmarks out",
    )


def check_direction(where, pre, post, target, result, landmarks):
    """Raises InputError if the lumen afterwards is reversed: its inlet lies where an outlet was.

    This happens if a wrong landmark reverses a straight vessel. It is also raised if a vessel without branches would
    fit better reversed. pre, post: the Trees.
    """
    along = sliding.direction_cosine(target, post, result.placement)
    if along < 0:
        raise _reversed_error(where, post, "lies", f"its main vessel runs against that before (cosine {along:.2f})")
    if len(post.branches) > 1 or len(pre.branches) > 1 or search.spans_a_plane(landmarks[1]):
        return
    line = post.branches["main"]
    turned = Line(line.points[::-1], line.radius[::-1], line.branch)
    other = search.find_placement(pre, Tree({"main": turned}, {"main": turned}, post.summary), landmarks)
    if other.cost + search.EQUAL_COST < result.cost:
        raise _reversed_error(
            where, post, "fits better", f"misfit {result.cost:.2f} of 1, turned round {other.cost:.2f}"
        )


def _reversed_error(where, post, what, value):
    x, y, z = post.summary["ends"][-1]["centre_mm"]
    remedy = (
        f"if its inlet is at {x:.2f}, {y:.2f}, {z:.2f} mm give that as post.inlet_point_mm (or correct lumen's);"
        " of contours z_from says at which end z begins; or a landmark is at the wrong place"
    )
    return InputError(f"the lumen after the procedure {what} the other way round", where, value, remedy)


def check_place_along(where, target, tree, result, match, landmarks):
    """Raises InputError if neither landmarks nor the vessel's course fix the place along it (as if it is straight)."""
    if len(landmarks[0]) or not sliding.fits_after_sliding(target, tree, result.placement, match):
        return
    residual = sliding.slid_residual(target, tree, result.placement)
    slid = "a straight vessel" if residual is None else f"slid by a radius it has a residual of {residual:.2f} of it"
    raise InputError(
        "the vessel's course does not fix the place along it",
        where,
        f"{slid}, in place {match.trimmed_mm / target.usual_radius_mm:.2f} (radius {target.usual_radius_mm:.2f} mm)",
        LANDMARKS_REMEDY,
    )


def check_handedness(where, pre, post, target, result, match, landmarks):
    """Raises InputError if the lumen afterwards does not fit as right pairs do, but its mirror image does.

    This is checked only if the residual is unusual or a branch has no partner: landmarks can place a mirror image so
    that it nearly fits. A vessel whose axis lies in a plane is its own mirror image.
    """
    unmatched = len(match.missing_branches) + len(match.new_branches)
    if not is_residual_unusual(match) and not unmatched:
        return
    other = search.find_placement(pre, post.mirrored(), (landmarks[0], landmarks[1] * MIRROR))
    mirrored = match_branches(target, post.mirrored(), other.placement)
    better = (
        mirrored.trimmed_mm < 0.5 * match.trimmed_mm
        and len(mirrored.missing_branches) + len(mirrored.new_branches) <= unmatched
    )
    if other.cost < result.cost and not is_residual_unusual(mirrored) and better:
        raise InputError(
            "the lumen after the procedure is a mirror image of the one before",
            where,
            f"residual {match.trimmed_mm:.2f} mm, mirrored {mirrored.trimmed_mm:.2f} mm",
            "one of the two has an axis the wrong way round (as between left and right in an image's frame): negate"
            " one of its coordinates, or export it again",
        )


def is_residual_unusual(match):
    """Whether the residual of a Match is larger than right pairs have."""
    return match.trimmed_mm > USUAL_RESIDUAL * match.usual_radius_mm


def warnings(target, tree, result, match, landmarks):
    """List of warnings on a placement that is not refused, yet may be wrong; mostly empty."""
    sentences = []
    distances_mm = landmark_distances_mm(result.placement, landmarks)
    for k in np.flatnonzero(distances_mm > DOUBTFUL_LANDMARK_RADII * match.usual_radius_mm):
        sentences.append(
            f"landmark {k + 1} lies {distances_mm[k]:.2f} mm from where the axes put it, which fit within"
            f" {match.trimmed_mm:.2f} mm: check its two places"
        )
    if is_residual_unusual(match):
        share = match.trimmed_mm / match.usual_radius_mm
        sentences.append(
            f"the axes after the procedure lie {match.trimmed_mm:.2f} mm off those before (without the worst fifth),"
            f" {share:.2f} of the usual radius. Pairs of one vessel have {USUAL_RESIDUAL:g} at most: it may be"
            " another vessel, another scale, or a vessel that has changed its course"
        )
    if len(landmarks[0]) == 1 and sliding.depends_on_landmark(target, tree, result.placement, match):
        sentences.append(
            "nothing but the landmark fixes the place along a straight vessel: what the landmark is off, all areas"
            " are off. Check its two places, or give a second landmark, which checks the first"
        )
    return sentences


def check_outlets(where, match, landmarks):
    """Raises InputError if the two lumens have different outlets, since flow needs a resistance at each outlet."""
    if match.new_branches or match.missing_branches:
        sentences = []
        if match.missing_branches:
            sentences.append(f"{', '.join(match.missing_branches)} of `lumen` not found in `post`")
        if match.new_branches:
            sentences.append(f"{', '.join(match.new_branches.values())} of `post` not found in `lumen`")
        raise InputError(
            "the two lumens have not the same branches",
            where,
            "; ".join(sentences),
            ("correct the landmarks' places; " if len(landmarks[0]) else "")
            + "close or cut off what only one of them has, or compare areas only: `registration: {compare: areas}`",
        )


def landmark_distances_mm(placement, landmarks):
    """Distances (m,) in mm between each landmark's two places, after the placement has moved the later one.

    landmarks: (pre (m, 3), post (m, 3)) in mm.
    """
    pre, post = landmarks
    return np.linalg.norm(placement.apply(post) - pre, axis=1) if len(pre) else np.zeros(0)
