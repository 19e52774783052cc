"""Remarks on a proposed plan: disease that it leaves untreated, and places where it could not follow its rules."""

import numpy as np

from . import landing, targets
from .profile import EDGE_MM

WIDE_BRANCH_MM = 2.0  # diameter from which a side branch under a stent is usually treated too
TOLERANCE_MM = 0.05  # by which a margin may be shorter, or an end off a limit, without counting
LANDING_PERCENT = 15  # difference of a landing zone from the reference, by diameter, from which a remark is made
DIFFUSE_PERCENT, DIFFUSE_MM = 10, 5.0  # least diameter stenosis beside a stent, and its least length, for a remark


def of_proposal(summary, proposal):
    """The remarks on a proposal.Proposal for the lumen of `summary` (anatomy.json), as a list of sentences."""
    said = [*_severity(proposal), *_left(summary, proposal)]
    for one in proposal.treated:
        if one.stents:
            said += [*_covered(one), *_row(one), *_landing(one), *_diffuse(one), *_sides(one)]
        else:
            said.append(_balloon_alone(one))
    return said


def _balloon_alone(one):
    device = one.balloon["devices"][0]
    return (
        f"{one.target.name} takes a balloon alone, of {device['diameter_mm']:g} mm: {one.no_stent.what}"
        f" ({one.no_stent.value}). The vessel recoils more than with a stent, and may dissect. Check the file's units;"
        " a stent of that width in config/devices would be planned"
    )


def of_reference(reference):
    """Yields a sentence for each treated lesion whose stenosis by the plan's reference is not that of anatomy.json.

    reference: as plan.sized_by() returns it.
    """
    for lesion in reference["lesions"]:
        here, there = lesion["diameter_stenosis_percent"], lesion["anatomy_percent"]
        if round(here) != round(there):
            yield (
                f"{lesion['name']} narrows the vessel by {here:.0f} % of the diameter that the {reference['by']} gives,"
                f" and by {there:.0f} % of the healthy profile through the lumen (anatomy.json)"
            )


def _severity(proposal):
    for one in proposal.treated:
        if one.target.percent < targets.SIGNIFICANT_PERCENT:
            yield (
                f"{one.target.name} narrows the diameter by {one.target.percent:.1f} % only: below"
                f" {targets.SIGNIFICANT_PERCENT} % a stent is rarely indicated, look at the FFR first"
            )


def _left(summary, proposal):
    treated = [lesion for one in proposal.treated for lesion in one.target.lesions]
    failed = {lesion["name"]: error for target, error in proposal.left_out for lesion in target.lesions}
    names = " and ".join(one.target.name for one in proposal.treated)
    for lesion in summary["lesions"]:
        mild = lesion["diameter_stenosis_percent"] < targets.SIGNIFICANT_PERCENT
        if lesion in treated or (mild and lesion["name"] not in failed):
            continue
        which = (
            f"{lesion['name']} ({lesion['diameter_stenosis_percent']:.0f} % on {lesion['branch']} at"
            f" {lesion['s_mla_mm']:.1f} mm) is left as it is: "
        )
        why = f"the plan treats {names} alone"
        if lesion["name"] in failed:
            error = failed[lesion["name"]]
            why = f"{error.what}, {error.value}"
        yield which + why


def _covered(one):
    start, end = one.ends
    sides = (("proximal", one.target.start - start), ("distal", end - one.target.end))
    for side, margin in sides:
        if margin < landing.MARGIN_MM - TOLERANCE_MM:
            reaches = "past" if margin >= 0 else "short of"
            yield (
                f"the stent reaches {abs(margin):.1f} mm {reaches} {one.target.name} at its {side} end,"
                f" {landing.MARGIN_MM} mm past it are wanted: {_cut_short(one, side)}"
            )


def _cut_short(one, side):
    """Why a stent's margin is short, and what to do. Its branch begins there, or the vessel has a cut end."""
    profile, (start, end) = one.target.profile, one.ends
    if not _at_a_cut_end(profile, side, start if side == "proximal" else end):
        return "the branch begins there"
    low, high = (0.0, start) if side == "proximal" else (end, profile.length_mm)
    at = np.append(profile.s[(profile.s > low) & (profile.s < high)], start if side == "proximal" else end)
    worst = float(profile.stenosis_at(at).max())
    name, which, more = "begin", "first", ", with the left main or the aorta before it"
    if side == "distal":
        name, which, more = "end", "last", ""
    left = f". The {which} {high - low:.1f} mm, narrowed by up to {worst:.0f} %, stay uncovered"
    return (
        f"no stent is planned within {EDGE_MM:g} mm of the vessel's cut {name}{left * (worst >= DIFFUSE_PERCENT)}."
        f" Give a longer lumen{more}, or place the stent by the plan's steps"
    )


def _at_a_cut_end(profile, side, end):
    """Whether a stent's end, at arc length `end` (mm), is as near to a cut end of the vessel as stents are planned.

    A side branch has a cut end at its distal side only.
    """
    limit = profile.limits_mm[0 if side == "proximal" else 1]
    return abs(end - limit) < TOLERANCE_MM and not (side == "proximal" and profile.is_side)


def _row(one):
    if len(one.stents) > 1:
        yield (
            f"{one.target.name} takes {len(one.stents)} stents that overlap by {landing.OVERLAP_MM} mm:"
            f" {one.ends[1] - one.ends[0]:.1f} mm in all"
        )
    for stent in one.stents:
        if stent.short:
            yield (
                f"the {stent.span.length:g} mm stent at {one.target.name} is too short for a balloon in its proximal"
                f" part alone: it is post-dilated whole, to at most {stent.widest_balloon:.2f} mm for its distal end's"
                f" sake; the vessel is {stent.proximal:.2f} mm wide at its proximal end"
            )
        if stent.distal > stent.diameter:
            yield (
                f"the vessel at {one.target.name} is {stent.distal:.2f} mm wide, the largest stent"
                f" {stent.diameter:.2f} mm: it is opened to the vessel by post-dilatation"
            )


def _landing(one):
    profile = one.target.profile
    for side, end in zip(("proximal", "distal"), one.ends):
        mouth = profile.in_a_mouth(end)
        if mouth:
            low, high = profile.mouths[mouth]
            yield f"the stent ends in the mouth of {mouth} ({low:.1f} to {high:.1f} mm), which no length avoids"
        elif profile.unlike(end) > LANDING_PERCENT:
            off = f"{profile.unlike(end):.0f} % off the reference"
            why = f"{landing.WITHIN_MM:g} mm hold no better"
            if _at_a_cut_end(profile, side, end):
                why = "none is planned nearer to the vessel's cut end"
            yield f"the stent's {side} end, at {end:.1f} mm, lies where the lumen is up to {off}: {why}"


def _diffuse(one):
    """Yields remarks on diffuse narrowing that continues beyond the stented length."""
    profile = one.target.profile
    for beyond, end in ((profile.s[::-1], one.ends[0]), (profile.s, one.ends[1])):
        outside = beyond[beyond < end] if beyond[0] > beyond[-1] else beyond[beyond > end]
        percent = np.where(np.isin(outside, profile.s[profile.measured]), profile.stenosis_at(outside), 0)
        healthy = np.flatnonzero(percent < DIFFUSE_PERCENT)
        run = outside[: healthy[0]] if healthy.size else outside
        if run.size and np.ptp(run) >= DIFFUSE_MM:
            low, high = sorted((run[0], run[-1]))
            worst = profile.stenosis_at(run).max()
            yield f"diffuse narrowing by up to {worst:.0f} % from {low:.1f} to {high:.1f} mm is left beside the stent"


def _sides(one):
    for name, (low, high) in one.target.profile.mouths.items():
        if high - low >= WIDE_BRANCH_MM and one.ends[0] < (low + high) / 2 < one.ends[1]:
            yield f"the stent lies across {name} ({high - low:.1f} mm wide): consider opening it towards that branch"
