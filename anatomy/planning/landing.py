"""Places the stents' ends in the most normal lumen beside the stretch that they cover.

A stent's end is MARGIN_MM to SEARCH_MM beyond the stretch, where the lumen is nearest to the vessel's reference.

This follows the ACC consensus on intravascular ultrasound. Its reference is the most normal lumen beside the stenosis
in the same segment of the vessel, without a large side branch between (Mintz et al., J Am Coll Cardiol
2001;37:1478-92).

Imaging-guided stents have the same landing zones (EAPCI consensus, Raeber et al., Eur Heart J 2018;39:3281-3300).
ULTIMATE also asks for a plaque burden below 50 % within 5 mm of the stent's edges (Zhang et al., J Am Coll Cardiol
2018;72:3126-37). A lumen alone does not show the plaque burden.
"""

import dataclasses
import itertools

import numpy as np

from common.errors import InputError

MARGIN_MM = 2.0  # least length of stent beyond the stretch
SEARCH_MM = 5.0  # the most normal lumen is sought up to this distance beyond the stretch
SIMILAR_PERCENT = 5  # percentage points by which an end may be farther off the reference than the best place
OVERLAP_MM = 2.5  # length over which two stents in a row overlap, so that no gap opens between them
STEP_MM = 0.5  # distance between the places that are tried
MOST_STENTS = 3  # three of 38 mm cover a whole left anterior descending artery; more is the operator's decision


@dataclasses.dataclass
class Span:
    """One stent's place along its branch, in mm.

    start: arc length of the proximal end. length: the stent's length in the catalogue.
    """

    start: float
    length: float

    @property
    def end(self):
        """Arc length of the distal end, mm."""
        return self.start + self.length

    @property
    def centre(self):
        """Arc length of the middle in mm, rounded to a micrometre."""
        return round(self.start + 0.5 * self.length, 3)


def stent_spans(target, lengths, where, fewest=1):
    """[Span] of the stents that cover a targets.Target, the distal one first; at least `fewest` stents.

    One stent is used if the catalogue's `lengths` (mm) suffice. Otherwise several of about equal length overlap by
    OVERLAP_MM. where: the plan's place, for messages. Raises InputError if they cannot be placed.
    """
    window = _edge_ranges(target, where)
    for count in range(fewest, MOST_STENTS + 1):
        candidates = []
        for row in _length_combinations(lengths, count):
            candidates += _candidate_places(target.profile, window, row)
        if candidates:
            return _overlapping_spans(*min(candidates, key=lambda candidate: candidate[0])[1:])
    shortest = lengths[0] * fewest - OVERLAP_MM * (fewest - 1)
    lowest, highest = target.profile.limits_mm
    room = highest - lowest
    if room < max(shortest, target.end - target.start):
        value = f"{target.name} of {target.end - target.start:.1f} mm, stents from {shortest:g} mm on, which fit"
        value += f" from {lowest:.1f} to {highest:.1f} mm of {target.profile.branch}"
        remedy = (
            "give more of the vessel, write the plan's steps (balloons alone), or add a shorter stent to the catalogue"
        )
        raise InputError("the stent is longer than the branch has room for", where, value, remedy)
    raise InputError(
        "no stents of the catalogue are long enough",
        where,
        f"{target.end - target.start:.1f} mm of {target.name}, and {MARGIN_MM} mm beyond each end",
        f"{MOST_STENTS} of {lengths[-1]} mm are the most that are proposed: write the plan's steps",
    )


def _edge_ranges(target, where):
    """((nearest, farthest) start, (nearest, farthest) end) of the stented length, as arc lengths in mm.

    The nearest places are MARGIN_MM beyond the target's stretch, the farthest SEARCH_MM. Both are limited to where
    stents may lie (Profile.limits_mm).
    """
    lowest, highest = target.profile.limits_mm
    if not lowest <= target.s_mla <= highest:
        raise InputError(
            "the lesion's narrowest place is too near an end of its branch for a stent",
            where,
            f"{target.name} at {target.s_mla:.1f} mm, a stent fits from {lowest:.1f} to {highest:.1f} mm of"
            f" {target.profile.branch}",
            "give more of the vessel, or write the plan's steps",
        )
    starts = max(target.start - MARGIN_MM, lowest), max(target.start - SEARCH_MM, lowest)
    ends = min(target.end + MARGIN_MM, highest), min(target.end + SEARCH_MM, highest)
    return starts, ends


def _length_combinations(lengths, count):
    """Yields the possible lengths (mm) of `count` stents in a row, proximal first.

    They differ by at most one size of the catalogue.
    """
    for first in range(len(lengths)):
        yield from itertools.product(lengths[first : first + 2], repeat=count)


def _candidate_places(profile, window, row):
    """[(cost, start, row)] of a row of stents at every place where it covers the stretch and stays in the branch.

    row: lengths (mm) of the stents. window: result of _edge_ranges(). start: arc length (mm) of the proximal end. cost:
    a tuple; the smallest is best, and earlier items count first. Its items are

    - the length beyond the farthest places for the ends, in steps;
    - the number of ends in side branches' mouths;
    - how much less normal an end lies than SIMILAR_PERCENT allows, in percentage points;
    - the total length, and the distance from the middle of the window.
    """
    (start_near, start_far), (end_near, end_far) = window
    total = sum(row) - OVERLAP_MM * (len(row) - 1)
    lowest, highest = profile.limits_mm
    first = max(lowest, end_near - total)
    last = min(start_near, highest - total)
    if first > last + 1e-9:
        return []
    best = [_most_normal(profile, near, far) for near, far in window]
    middle = 0.5 * (start_near + end_near)
    found = []
    for start in np.append(np.arange(last, first, -STEP_MM), first):
        ends = (start, start + total)
        beyond = max(start_far - start, 0.0) + max(start + total - end_far, 0.0)
        mouths = sum(profile.mouth_at(end) is not None for end in ends)
        unlike = max(profile.deviation_percent(end) - least for end, least in zip(ends, best))
        cost = (
            round(beyond / STEP_MM),
            mouths,
            max(round(unlike - SIMILAR_PERCENT), 0),
            total,
            abs(start + total / 2 - middle),
        )
        found.append((cost, float(start), row))
    return found


def _most_normal(profile, near, far):
    """Least difference (per cent by diameter) of the lumen from the reference, at places from near to far.

    Places in side branches' mouths do not count. If all places are in mouths, the result is 0.
    """
    steps = np.append(np.arange(min(near, far), max(near, far), STEP_MM), max(near, far))
    return min((profile.deviation_percent(at) for at in steps if profile.mouth_at(at) is None), default=0.0)


def _overlapping_spans(start, row):
    """[Span] of stents of the lengths `row` from arc length `start` on, the distal one first."""
    found = []
    for length in row:
        found.append(Span(start, length))
        start += length - OVERLAP_MM
    return found[::-1]
