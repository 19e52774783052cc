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
LEAST_GAP_MM = 3.0  # least length of bare lumen between two stents; nearer ones are planned as one row


@dataclasses.dataclass
class Treatment:
    """A targets.Target and the devices that treat it: stents, or a balloon alone.

    stents: [sizing.Stent], the distal one first. balloon: the plan's step of the balloon, if there is no stent.
    no_stent_error: the InputError that tells why no stent fits.
    """

    target: object
    stents: list
    balloon: dict = None
    no_stent_error: object = None

    @property
    def stented_ends(self):
        """(start, end) of the stented length, mm."""
        return self.stents[-1].span.start, self.stents[0].span.end


@dataclasses.dataclass
class Proposal:
    """A proposed plan.

    steps: the steps as a case file lists them, placed by centre_s_mm. treatments: [Treatment], the most severe first.
    untreatable: [(Target, InputError that tells why it cannot be treated)].
    """

    steps: list
    treatments: list
    untreatable: list


def requested_treatment(plan):
    """(CULPRIT or ALL, least diameter stenosis in per cent or None) if a case's `plan` asks for a proposal.

    None if the plan lists its steps.
    """
    if plan == "auto":
        return CULPRIT, None
    return (plan["treat"], plan.get("least_stenosis_percent")) if isinstance(plan, dict) else None


def propose(summary, sections, families, where, treat=CULPRIT, least_percent=None):
    """Proposal for the lesions of a measured lumen.

    summary, sections: results of lumen_results.read_summary() and read_sections(). families: {name: document} of
    config/devices. where: the case file, for messages. treat: with CULPRIT the most severe lesion that stents of the
    catalogue fit is treated; if there is none, the most severe that a balloon fits. With ALL each lesion of
    targets.targets_to_treat() is treated; if all are mild, the most severe one. Raises InputError if no lesion reaches
    least_percent by diameter, or if no device fits any lesion.
    """
    if not summary["lesions"]:
        requested = "auto" if treat == CULPRIT else f"{{treat: {treat}}}"
        raise InputError(
            "no lesion to plan for",
            where,
            f"plan: {requested}: {_narrowest_place(summary, sections)}",
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
    lesions = targets.targets_to_treat(summary, sections, least_percent)
    if not lesions:
        raise _mild_lesion_error(targets.all_targets(summary, sections)[0], where, treat, least_percent)
    mild = least_percent is None and lesions[0].percent < targets.SIGNIFICANT_PERCENT
    only_one = treat == CULPRIT or mild
    treatments, untreatable = [], []
    for target in lesions:
        try:
            treatments.append(_stent_target(target, families, where))
        except InputError as error:
            untreatable.append((target, error))
            continue
        if only_one:
            break
    if not treatments or not only_one:
        treatments, untreatable = _add_balloons(treatments, untreatable, families, where)
        treatments = treatments[:1] if only_one else treatments
    if not treatments:
        raise untreatable[0][1]
    treatments = _join_short_gaps(treatments, families, where)
    return Proposal(
        [step for one in _in_treatment_order(treatments) for step in _treatment_steps(one, families, where)],
        treatments,
        untreatable,
    )


def _mild_lesion_error(target, where, treat, least_percent):
    """The InputError for a vessel whose most severe lesion (a Target) is below the limit for treatment."""
    percent = max(int(target.percent), 1)
    return InputError(
        "no lesion severe enough to plan for",
        where,
        f"{target.name}, the most severe, narrows {target.profile.branch} at {target.s_mla:.1f} mm by"
        f" {target.percent:.1f} % of its diameter; lesions of {least_percent:g} % and more are treated",
        f"write plan: {{treat: {treat}, least_stenosis_percent: {percent}}}, or leave the limit out",
    )


def _add_balloons(treatments, untreatable, families, where):
    """(treatments, untreatable) after lesions without a fitting stent got a balloon alone, if one fits.

    treatments: the most severe first. untreatable: [(Target, InputError)].
    """
    done, left = list(treatments), []
    for target, error in untreatable:
        balloon = sizing.balloon_alone(families, target, where) if isinstance(error, sizing.NoFittingStent) else None
        if balloon:
            done.append(Treatment(target, [], balloon, error))
        else:
            left.append((target, error))
    return sorted(done, key=lambda one: -one.target.percent), left


def _narrowest_place(summary, sections):
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


def _stent_target(target, families, where):
    """The Treatment for a Target, with as many stents as its length and the vessel's taper need."""
    lengths = families[sizing.STENT]["lengths_mm"]
    spans = landing.stent_spans(target, lengths, where)
    while True:
        try:
            return Treatment(target, sizing.size_stents(target.profile, spans, families, where))
        except sizing.TooTapered:
            if len(spans) == landing.MOST_STENTS:
                raise
            spans = landing.stent_spans(target, lengths, where, fewest=len(spans) + 1)


def _join_short_gaps(treatments, families, where):
    """[Treatment] after joining targets of one branch whose stents overlap or are less than LEAST_GAP_MM apart."""
    stented = [one for one in treatments if one.stents]
    for k, one in enumerate(stented):
        for other in stented[k + 1 :]:
            gap = max(one.stented_ends[0] - other.stented_ends[1], other.stented_ends[0] - one.stented_ends[1])
            if one.target.profile is other.target.profile and gap < LEAST_GAP_MM:
                rest = [kept for kept in treatments if kept is not one and kept is not other]
                joined = _stent_target(one.target.joined_with(other.target), families, where)
                return _join_short_gaps(sorted([joined, *rest], key=lambda t: -t.target.percent), families, where)
    return treatments


def _in_treatment_order(treatments):
    """[Treatment] in the order of treatment. No device then has to pass a stent.

    The branch with the worst lesion comes first. On a branch the distal target comes first.
    """
    branches = list(dict.fromkeys(one.target.profile.branch for one in treatments))
    return sorted(treatments, key=lambda one: (branches.index(one.target.profile.branch), -one.target.start))


def _treatment_steps(one, families, where):
    """The steps for a Treatment: all predilatations, then all stents, then all post-dilatations; or the balloon alone.

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
        centre = _balloon_centre(low, high, target.s_mla, length, stent.span)
        before.append(sizing.plan_step(families, "predilatation", *size, branch, centre, (diameter, math.inf), where))
        size = (sizing.STENT, stent.diameter, stent.span.length)
        centre = stent.span.centre
        stents.append(sizing.plan_step(families, "stent", *size, branch, centre, (stent.diameter, math.inf), where))
        diameter, length, centre, wide = sizing.postdilatation(families, stent, where)
        size = (sizing.POSTDILATATION, diameter, length)
        after.append(sizing.plan_step(families, "postdilatation", *size, branch, centre, wide, where))
    return before + stents + after


def _balloon_centre(low, high, tightest, length, span):
    """Arc length (mm) at which a balloon of `length` (mm) is centred over the stretch from `low` to `high` (mm).

    If the balloon is shorter than the stretch, it is moved over the `tightest` place, if that is in the stretch. The
    whole balloon lies within the stent's `span`: beyond it, it would injure a wall that no stent covers.
    """
    middle = 0.5 * (low + high)
    if low <= tightest <= high:
        middle = min(max(middle, tightest - length / 2), tightest + length / 2)
    return round(min(max(middle, span.start + length / 2), span.end - length / 2), 3)
