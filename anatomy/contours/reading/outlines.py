"""Closed outlines in the plane of a frame: separates, checks and measures them."""

from collections import Counter

import numpy as np
from matplotlib.path import Path

from common.errors import InputError

SAME_POINT_MM = 1e-6  # points nearer to each other count as one point
COLUMNS_HINT = "Without names frame, x, y, z over them the columns are taken in that order"
FEWEST_POINTS = 8  # an outline needs this many: with fewer a round lumen cannot be told from a square one
WIDEST_MM = 15.0  # coronary arteries, even with ectasia, are narrower; outlines in pixels are wider
LEAST_AREA_MM2 = 0.03  # area of a circle with a radius of 0.1 mm; even the catheter is wider
LARGEST_GAP_RATIO = 1.5  # a line nearly closes if its gap is at most this many times its longest step
LEAST_WITHIN_SHARE = 0.9  # an outline lies within another if this share of its points does; the others may touch it
LEAST_BRIDGE_RATIO = 3.0  # steps between two joined outlines are at least this many times as long as both gaps


def area_mm2(outline):
    """Signed area in mm2 of the polygon of an outline (n, 2); positive if it runs counter-clockwise."""
    x, y = outline.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def centroid(outline):
    """Centroid (2,) of the area within a closed outline (n, 2)."""
    step = np.roll(outline, -1, axis=0)
    cross = outline[:, 0] * step[:, 1] - step[:, 0] * outline[:, 1]
    return ((outline + step) * cross[:, None]).sum(axis=0) / (3 * cross.sum())


def split_outlines(points):
    """Splits a list of points (m, 2) into its outlines: [points (n, 2) of each outline].

    Outlines in a row can be told apart if each ends on the point where it began; otherwise all points are one outline.
    Some files close a polygon with holes by repeating its very first point at the end. Such a last point is left out.
    """
    found, first = [], 0
    while first < len(points):
        if found and first == len(points) - 1 and _distance(points[first], points[0]) < SAME_POINT_MM:
            break
        again = np.flatnonzero(_distance(points[first + 3 :], points[first]) < SAME_POINT_MM)
        if not again.size:
            return [points]
        last = first + 3 + again[0]
        found.append(points[first : last + 1])
        first = last + 1
    return found


def checked_outline(points, where, split_remedy, may_be_ring=False):
    """The outline (m, 2) in mm of points (n, 2), counter-clockwise, without repeated points.

    where: place of the outline in the tables, for messages. split_remedy: remedy to print if several outlines were
    joined into one. may_be_ring: whether the outline may run round the vessel and back within itself, as round a sheet
    of calcium. Raises InputError for points listed twice, a line that crosses itself, a second outline appended, too
    few points, or a size that no coronary artery has.
    """
    points = points[_distance(points, np.roll(points, 1, axis=0)) > SAME_POINT_MM]
    if len(points) < FEWEST_POINTS:
        remedy = f"at least {FEWEST_POINTS} different ones, or leave the frame out (drop_frames). {COLUMNS_HINT}"
        raise InputError("too few points for an outline", where, len(points), remedy)
    size = np.ptp(points, axis=0).max()
    if size > WIDEST_MM:
        remedy = f"at most {WIDEST_MM:g} mm: image pixels must be multiplied by their size, and units declared"
        raise InputError("too wide for a coronary artery", where, f"{size:.4g} mm", remedy)
    _raise_at("points of an outline are listed twice", _repeated_step(points), where, f"list each once; {split_remedy}")
    _raise_at(
        "the outline crosses itself", _crossing(points), where, f"trace the frame again, or drop_frames; {split_remedy}"
    )
    _raise_at("two outlines in one", _second_outline_start(points, may_be_ring), where, split_remedy)
    area = area_mm2(points)
    if abs(area) < LEAST_AREA_MM2:
        remedy = f"at least {LEAST_AREA_MM2} mm2: check units, or leave out what is no outline, or points listed twice"
        raise InputError("hardly any area within the outline", where, f"{abs(area):.3g} mm2", remedy)
    return points if area > 0 else points[::-1]


def _raise_at(what, place, where, remedy):
    """Raises InputError if there is a place (2,) at which something is wrong; None means that all is well."""
    if place is not None:
        raise InputError(what, where, f"at x, y = {np.round(place, 3).tolist()} mm", remedy)


def _distance(points, others):
    """Distances (n,) between points (n, 2) and others (n, 2) or (2,)."""
    return np.linalg.norm(points - others, axis=-1)


def _repeated_step(points):
    """A point (2,) from which a closed outline takes the same step twice, or None.

    A step back along the same edge cancels a step. So a spike without width is allowed, as outlines traced along pixels
    may have it.
    """
    keys = [tuple(point) for point in np.round(points / SAME_POINT_MM).astype(np.int64)]
    times = Counter(zip(keys, keys[1:] + keys[:1]))
    for k, (one, other) in enumerate(zip(keys, keys[1:] + keys[:1])):
        if times[one, other] - times[other, one] > 1:
            return points[k]
    return None


def _crossing(points):
    """A place (2,) where two edges of the closed outline cross, or None."""
    begin, along = points, np.roll(points, -1, axis=0) - points

    def side(i, j):  # positive if edge j begins to the left of edge i, negative to its right
        return along[i, 0] * (points[j, 1] - begin[i, 1]) - along[i, 1] * (points[j, 0] - begin[i, 0])

    n = len(points)
    i, j = np.triu_indices(n, 2)
    keep = ~((i == 0) & (j == n - 1))
    i, j = i[keep], j[keep]
    first = side(i, j) * side(i, (j + 1) % n) < 0
    i, j = i[first], j[first]
    both = side(j, i) * side(j, (i + 1) % n) < 0
    return begin[i[both][0]] if both.any() else None


def _second_outline_start(points, may_be_ring):
    """The point (2,) of a closed outline (n, 2) at which a second outline begins, or None.

    Two outlines that were joined form one line. It runs along the first, steps to the second, runs along that and steps
    back. Such a line is recognised by two parts that each nearly close. The gap of a part, from its last to its first
    point, must be at most LARGEST_GAP_RATIO times its longest step. It must also be at most half the radius of the part
    (half the width of a slender one). If both steps between the parts are longer than all others, a gap of a third of
    the shorter one is small enough too. With may_be_ring a part that runs back within the other is no outline: it is
    the second line round a sheet of calcium.
    """
    step = _distance(np.roll(points, -1, axis=0), points)
    k = np.arange(FEWEST_POINTS, len(points) - FEWEST_POINTS + 1)
    longest = np.maximum.accumulate(step)[k - 2], np.maximum.accumulate(step[-2::-1])[::-1][k]
    gaps = _distance(points[k - 1], points[0]), _distance(points[-1], points[k])
    even = (gaps[0] <= LARGEST_GAP_RATIO * longest[0]) & (gaps[1] <= LARGEST_GAP_RATIO * longest[1])
    for first, *both in zip(k[even], gaps[0][even], gaps[1][even]):
        bridge, others = min(step[first - 1], step[-1]), np.delete(step, [first - 1, -1])
        over = bridge / LEAST_BRIDGE_RATIO if bridge > others.max() else 0.0
        parts = np.split(points, [first])
        if may_be_ring and _is_folded_back(*parts):
            continue
        if all(gap <= max(_half_radius(part), over) for gap, part in zip(both, parts)):
            return points[first]
    return None


def _is_folded_back(one, other):
    """Whether one part of an outline lies within the other and runs in the opposite direction.

    This holds for the inner and the outer line round a sheet of calcium that encloses the lumen.
    """
    if area_mm2(one) * area_mm2(other) > 0:
        return False
    outer, inner = sorted((one, other), key=lambda part: -abs(area_mm2(part)))
    return Path(outer).contains_points(inner).mean() > LEAST_WITHIN_SHARE


def _half_radius(outline):
    """Area over perimeter in mm: half the radius of a round outline, half the width of a slender one."""
    return abs(area_mm2(outline)) / _distance(outline, np.roll(outline, 1, axis=0)).sum()
