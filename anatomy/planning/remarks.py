"""Remarks on a plan: disease that a proposal leaves untreated, rules that it could not follow, devices far too wide."""

import numpy as np

from . import landing, targets
from .profile import CAP_MARGIN_MM

WIDE_BRANCH_MM = 2.0  # diameter from which a side branch under a stent is usually treated too
TOLERANCE_MM = 0.05  # a margin short by less gives no remark; an end nearer to a limit lies on it
LANDING_PERCENT = 15  # a stent's end in a lumen farther off the reference, by diameter, gives a remark
# A device of a listed plan this many times as wide as the healthy vessel round it gives a remark. In practice
# balloons are at most about 1.2 times as wide.
LARGEST_DEVICE_RATIO = 1.4
DIFFUSE_PERCENT, DIFFUSE_MM = 10, 5.0  # least diameter stenosis beside a stent, and its least length, for a remark


def of_proposal(summary, proposal):
    """The remarks on a proposal.Proposal for the lumen of `summary` (anatomy.json), as a list of sentences."""
    sentences = [*_mild_lesions(proposal), *_untreated_lesions(summary, proposal)]
    for one in proposal.treatments:
        if one.stents:
            sentences += [
                *_short_margins(one),
                *_stent_row(one),
                *_landing_zones(one),
                *_diffuse_disease(one),
                *_jailed_branches(one),
            ]
        else:
            sentences.append(_balloon_alone(one))
    return sentences


def _balloon_alone(one):
    device = one.balloon["devices"][0]
    return (
        f"{one.target.name} takes a balloon alone, of {device['diameter_mm']:g} mm: {one.no_stent_error.what}"
        f" ({one.no_stent_error.value}). The vessel recoils more than with a stent, and may dissect. Check the file's"
        " units; a stent of that width in config/devices would be planned"
    )


def of_device_sizes(plan, sections):
    """Yields a sentence for each device of a listed plan that is far wider than the vessel, as by a slip of the pen.

    plan: result of plan.procedure(). sections: result of lumen_results.read_sections().
    """
    for step in plan["procedure"]:
        for use in step["devices"]:
            device = plan["devices"][use["device"]]
            half = device["length_mm"] / 2
            healthy = [
                row["reference_diameter_mm"]
                for row in sections.get(use["branch"], ())
                if abs(row["s_mm"] - use["centre_s_mm"]) <= half
            ]
            if healthy and device["nominal_diameter_mm"] > LARGEST_DEVICE_RATIO * max(healthy):
                yield (
                    f"{step['name']}: {use['device']} is {device['nominal_diameter_mm']:.2f} mm wide,"
                    f" {device['nominal_diameter_mm'] / max(healthy):.1f} times the healthy vessel there"
                    f" ({max(healthy):.2f} mm)"
                )


def of_reference(reference):
    """Yields a sentence for each treated lesion whose stenosis in the plan differs from that in anatomy.json.

    They differ if the plan has another reference. reference: result of plan.reference_document().
    """
    for lesion in reference["lesions"]:
        by_plan, by_anatomy = lesion["diameter_stenosis_percent"], lesion["anatomy_percent"]
        if round(by_plan) != round(by_anatomy):
            yield (
                f"{lesion['name']} narrows the vessel by {by_plan:.0f} % of the diameter that the {reference['by']}"
                f" gives, and by {by_anatomy:.0f} % of the healthy profile through the lumen (anatomy.json)"
            )


def _mild_lesions(proposal):
    for one in proposal.treatments:
        if one.target.percent < targets.SIGNIFICANT_PERCENT:
            yield (
                f"{one.target.name} narrows the diameter by {one.target.percent:.1f} % only: below"
                f" {targets.SIGNIFICANT_PERCENT} % a stent is rarely indicated, look at the FFR first"
            )


def _untreated_lesions(summary, proposal):
    treated = [lesion for one in proposal.treatments for lesion in one.target.lesions]
    failed = {lesion["name"]: error for target, error in proposal.untreatable for lesion in target.lesions}
    names = " and ".join(one.target.name for one in proposal.treatments)
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


def _short_margins(one):
    start, end = one.stented_ends
    sides = (("proximal", one.target.start - start), ("distal", end - one.target.end))
    for side, margin in sides:
        if margin < landing.MARGIN_MM - TOLERANCE_MM:
            reaches = "past" if margin >= 0 else "short of"
            yield (
                f"the stent reaches {abs(margin):.1f} mm {reaches} {one.target.name} at its {side} end,"
                f" {landing.MARGIN_MM} mm past it are wanted: {_short_margin_reason(one, side)}"
            )


def _short_margin_reason(one, side):
    """The reason for a stent's short margin, and the remedy, in words.

    Either its branch begins there, or the vessel has a cut end.
    """
    profile, (start, end) = one.target.profile, one.stented_ends
    if not _is_at_cut_end(profile, side, start if side == "proximal" else end):
        return "the branch begins there"
    low, high = (0.0, start) if side == "proximal" else (end, profile.length_mm)
    at = np.append(profile.s[(profile.s > low) & (profile.s < high)], start if side == "proximal" else end)
    worst = float(profile.stenosis_at(at).max())
    name, which, more = "begin", "first", ", with the left main or the aorta before it"
    if side == "distal":
        name, which, more = "end", "last", ""
    left = f". The {which} {high - low:.1f} mm, narrowed by up to {worst:.0f} %, stay uncovered"
    return (
        f"no stent is planned within {CAP_MARGIN_MM:g} mm of the vessel's cut"
        f" {name}{left * (worst >= DIFFUSE_PERCENT)}."
        f" Give a longer lumen{more}, or place the stent by the plan's steps"
    )


def _is_at_cut_end(profile, side, end):
    """Whether a stent's end, at arc length `end` (mm), is as near to a cut end of the vessel as stents may be.

    A side branch has a cut end at its distal side only.
    """
    limit = profile.limits_mm[0 if side == "proximal" else 1]
    return abs(end - limit) < TOLERANCE_MM and not (side == "proximal" and profile.is_side_branch)


def _stent_row(one):
    if len(one.stents) > 1:
        yield (
            f"{one.target.name} takes {len(one.stents)} stents that overlap by {landing.OVERLAP_MM} mm:"
            f" {one.stented_ends[1] - one.stented_ends[0]:.1f} mm in all"
        )
    for stent in one.stents:
        if stent.is_too_short:
            yield (
                f"the {stent.span.length:g} mm stent at {one.target.name} is too short for a balloon in its proximal"
                f" part alone: it is post-dilated whole, to at most {stent.widest_balloon:.2f} mm for its distal end's"
                f" sake; the vessel is {stent.proximal_reference:.2f} mm wide at its proximal end"
            )
        if stent.distal_reference > stent.diameter:
            yield (
                f"the vessel at {one.target.name} is {stent.distal_reference:.2f} mm wide, the largest stent"
                f" {stent.diameter:.2f} mm: it is opened to the vessel by post-dilatation"
            )


def _landing_zones(one):
    profile = one.target.profile
    for side, end in zip(("proximal", "distal"), one.stented_ends):
        mouth = profile.mouth_at(end)
        if mouth:
            low, high = profile.mouths[mouth]
            yield f"the stent ends in the mouth of {mouth} ({low:.1f} to {high:.1f} mm), which no length avoids"
        elif profile.deviation_percent(end) > LANDING_PERCENT:
            off = f"{profile.deviation_percent(end):.0f} % off the reference"
            why = f"{landing.SEARCH_MM:g} mm hold no better"
            if _is_at_cut_end(profile, side, end):
                why = "none is planned nearer to the vessel's cut end"
            yield f"the stent's {side} end, at {end:.1f} mm, lies where the lumen is up to {off}: {why}"


def _diffuse_disease(one):
    """Yields remarks on diffuse narrowing that continues beyond the stented length."""
    profile = one.target.profile
    for beyond, end in ((profile.s[::-1], one.stented_ends[0]), (profile.s, one.stented_ends[1])):
        outside = beyond[beyond < end] if beyond[0] > beyond[-1] else beyond[beyond > end]
        percent = np.where(np.isin(outside, profile.s[profile.measured]), profile.stenosis_at(outside), 0)
        healthy = np.flatnonzero(percent < DIFFUSE_PERCENT)
        run = outside[: healthy[0]] if healthy.size else outside
        if run.size and np.ptp(run) >= DIFFUSE_MM:
            low, high = sorted((run[0], run[-1]))
            worst = profile.stenosis_at(run).max()
            yield f"diffuse narrowing by up to {worst:.0f} % from {low:.1f} to {high:.1f} mm is left beside the stent"


def _jailed_branches(one):
    for name, (low, high) in one.target.profile.mouths.items():
        if high - low >= WIDE_BRANCH_MM and one.stented_ends[0] < (low + high) / 2 < one.stented_ends[1]:
            yield f"the stent lies across {name} ({high - low:.1f} mm wide): consider opening it towards that branch"
