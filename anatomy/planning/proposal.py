"""A plan proposed from the lesions and the device catalogue: `plan: auto`, or `plan: {treat: culprit | all}`.

If the case sets least_stenosis_percent, lesions below it are not treated. If no stent of the catalogue is as wide as
the vessel, a balloon alone is proposed.
"""

import dataclasses
import math

from common.errors import InputError

from . import landing, sizing, targets
from .profile import Profile

CULPRIT, ALL = "culprit", "all"
GAP_MM = 3.0  # least length of lumen between two stents; with less they are planned as one row


@dataclasses.dataclass
class Treated:
    """A target (targets.Target) with its stents [sizing.Stent], the distal one first; or with a balloon alone.

    balloon: the balloon's step, if there is no stent. no_stent: the InputError that tells why no stent fits.
    """

    target: object
    stents: list
    balloon: dict = None
    no_stent: object = None

    @property
    def ends(self):
        """(start, end) of the stented length, mm."""
        return self.stents[-1].span.start, self.stents[0].span.end


@dataclasses.dataclass
class Proposal:
    """A proposed plan. steps: as in a case file, placed by centre_s_mm. treated: [Treated], the most severe first.

    left_out: [(Target, InputError that tells why it cannot be treated)].
    """

    steps: list
    treated: list
    left_out: list


def wanted(plan):
    """(CULPRIT or ALL, least diameter stenosis in per cent or None) if a case's `plan` asks for a proposal.

    None if the plan lists its steps.
    """
    if plan == "auto":
        return CULPRIT, None
    return (plan["treat"], plan.get("least_stenosis_percent")) if isinstance(plan, dict) else None


def propose(summary, sections, families, where, treat=CULPRIT, least_percent=None):
    """Proposal for the lesions of a measured lumen.

    summary, sections: as of measured.read_summary() and read_sections(). families: {name: document} of config/devices.
    where: the case file, for messages. With CULPRIT it treats the most severe lesion that stents of the catalogue fit,
    or if there is none the most severe that a balloon fits. With ALL it treats each lesion of targets.found(); if all
    are mild, the most severe one. Raises InputError if no lesion reaches least_percent by diameter, or if no device
    fits any lesion.
    """
    if not summary["lesions"]:
        requested = "auto" if treat == CULPRIT else f"{{treat: {treat}}}"
        raise InputError(
            "no lesion to plan for",
            where,
            f"plan: {requested}: {_narrowest(summary, sections)}",
            "look at `anatomy picture`: are inlet, ends and reference right? To treat the vessel all the same,"
            " list the plan's steps: each with its action and its devices, placed by branch"
            " and centre_s_mm (docs/design.md); a vessel narrowed all along its length has no healthy reference in the"
            " lumen: where its outer wall is known, give that (lumen: contours)",
        )
    for family in (sizing.PREDILATATION, sizing.STENT, sizing.POSTDILATATION):
        if family not in families:
            raise InputError(
                "plan: auto needs a device family", where, family, f"add {family}.yaml to config/devices (--devices)"
            )
    lesions = targets.found(summary, sections, least_percent)
    if not lesions:
        raise _too_mild(targets.every(summary, sections)[0], where, treat, least_percent)
    mild = least_percent is None and lesions[0].percent < targets.SIGNIFICANT_PERCENT
    one_alone = treat == CULPRIT or mild
    treated, left_out = [], []
    for target in lesions:
        try:
            treated.append(_stented(target, families, where))
        except InputError as error:
            left_out.append((target, error))
            continue
        if one_alone:
            break
    if not treated or not one_alone:
        treated, left_out = _with_balloons(treated, left_out, families, where)
        treated = treated[:1] if one_alone else treated
    if not treated:
        raise left_out[0][1]
    treated = _without_short_gaps(treated, families, where)
    return Proposal([step for one in _in_order(treated) for step in _steps(one, families, where)], treated, left_out)


def _too_mild(target, where, treat, least_percent):
    """The InputError for a vessel whose most severe lesion (a Target) is below the limit for treatment."""
    percent = max(int(target.percent), 1)
    return InputError(
        "no lesion severe enough to plan for",
        where,
        f"{target.name}, the most severe, narrows {target.profile.branch} at {target.s_mla:.1f} mm by"
        f" {target.percent:.1f} % of its diameter; lesions of {least_percent:g} % and more are treated",
        f"write plan: {{treat: {treat}, least_stenosis_percent: {percent}}}, or leave the limit out",
    )


def _with_balloons(treated, left_out, families, where):
    """(treated, left_out), of which `treated` now has a balloon alone for each lesion in a vessel no stent is made for.

    treated: the most severe first.
    """
    done, left = list(treated), []
    for target, error in left_out:
        balloon = sizing.alone(families, target, where) if isinstance(error, sizing.NoWidth) else None
        if balloon:
            done.append(Treated(target, [], balloon, error))
        else:
            left.append((target, error))
    return sorted(done, key=lambda one: -one.target.percent), left


def _narrowest(summary, sections):
    """The place and degree of the largest diameter stenosis of the lumen, in words."""
    worst = None
    for branch in sections:
        profile = Profile(summary, sections, branch)
        for s, percent in zip(profile.s[profile.measured], profile.stenosis_at(profile.s[profile.measured])):
            if worst is None or percent > worst[0]:
                worst = (percent, s, branch)
    if worst is None:
        return "no section of it is measured"
    percent, s, branch = worst
    return f"the narrowest place, at {s:.1f} mm of {branch}, is {percent:.1f} % below the healthy profile by diameter"


def _stented(target, families, where):
    """The Treated for a Target, with as many stents as its length and the vessel's taper need."""
    lengths = families[sizing.STENT]["lengths_mm"]
    spans = landing.spans(target, lengths, where)
    while True:
        try:
            return Treated(target, sizing.sized(target.profile, spans, families, where))
        except sizing.TooTapered:
            if len(spans) == landing.MOST_STENTS:
                raise
            spans = landing.spans(target, lengths, where, least=len(spans) + 1)


def _without_short_gaps(treated, families, where):
    """[Treated] after joining targets of one branch whose stents overlap or are less than GAP_MM apart."""
    stented = [one for one in treated if one.stents]
    for k, one in enumerate(stented):
        for other in stented[k + 1 :]:
            gap = max(one.ends[0] - other.ends[1], other.ends[0] - one.ends[1])
            if one.target.profile is other.target.profile and gap < GAP_MM:
                rest = [kept for kept in treated if kept is not one and kept is not other]
                joined = _stented(one.target.joined(other.target), families, where)
                return _without_short_gaps(sorted([joined, *rest], key=lambda t: -t.target.percent), families, where)
    return treated


def _in_order(treated):
    """[Treated] in the order of treatment: the branch with the worst lesion first, on a branch the distal target first.

    So no device has to pass a stent.
    """
    branches = list(dict.fromkeys(one.target.profile.branch for one in treated))
    return sorted(treated, key=lambda one: (branches.index(one.target.profile.branch), -one.target.start))


def _steps(one, families, where):
    """The steps for a Treated: all predilatations, then all stents, then all post-dilatations; or the balloon alone.

    Distal devices come first.
    """
    if one.balloon:
        return [one.balloon]
    branch, target = one.target.profile.branch, one.target
    before, stents, after = [], [], []
    for stent in one.stents:
        low, high = max(stent.span.start, target.start), min(stent.span.end, target.end)
        diameter, length = sizing.predilatation(families, stent, high - low, where)
        size = (sizing.PREDILATATION, diameter, length)
        centre = _over(low, high, target.s_mla, length, stent.span)
        before.append(sizing.step(families, "predilatation", *size, branch, centre, (diameter, math.inf), where))
        size = (sizing.STENT, stent.diameter, stent.span.length)
        centre = stent.span.centre
        stents.append(sizing.step(families, "stent", *size, branch, centre, (stent.diameter, math.inf), where))
        diameter, length, centre, wide = sizing.postdilatation(families, stent, where)
        size = (sizing.POSTDILATATION, diameter, length)
        after.append(sizing.step(families, "postdilatation", *size, branch, centre, wide, where))
    return before + stents + after


def _over(low, high, tightest, length, span):
    """Arc length (mm) of the middle of a balloon of a length (mm) over the stretch from low to high (mm).

    A balloon shorter than the stretch is moved over the tightest place, if that is in the stretch. The whole balloon
    lies within the stent's span: beyond it, it would injure a wall that no stent covers.
    """
    middle = 0.5 * (low + high)
    if low <= tightest <= high:
        middle = min(max(middle, tightest - length / 2), tightest + length / 2)
    return round(min(max(middle, span.start + length / 2), span.end - length / 2), 3)
