"""The narrowings to treat, and the stretches that stents must cover.

A lesion of at least SIGNIFICANT_PERCENT by diameter is usually treated. The SYNTAX score counts such lesions (Sianos et
al., EuroIntervention 2005;1:219-27). If all are milder the most severe is treated. The case may set another limit.

A stent must cover the lesion's stretch of significant narrowing: at least 30 % by diameter (half by area). This is the
threshold of Dietz et al. (Heart 2006;92:80-84), who stented only such stretches. They found less restenosis than with
full coverage; narrowing below 45 % left beside the stent did not matter. In a lesion below 60 % the stretch is where
the narrowing is at least half the lesion's own. Milder disease beyond the stretch is left.
"""

import dataclasses

import numpy as np

from .profile import Profile

SIGNIFICANT_PERCENT = 50  # diameter stenosis from which a lesion is usually treated
STRETCH_PERCENT = 30  # diameter stenosis from which a stent must cover a narrowing
JOIN_DIAMETERS = 3  # narrowings fewer vessel diameters apart are one lesion (SYNTAX score)


@dataclasses.dataclass
class Target:
    """The stretch of a branch that one stent covers, or several that overlap: from arc length `start` to `end`, mm.

    lesions: entries of anatomy.json for the lesions in it. s_mla: arc length (mm) of the worst lesion's smallest area.
    percent: diameter stenosis of the worst lesion.
    """

    profile: Profile
    lesions: list
    start: float
    end: float
    s_mla: float
    percent: float

    @property
    def name(self):
        """The lesions' names, for messages."""
        return " and ".join(lesion["name"] for lesion in self.lesions)

    def joined_with(self, other):
        """One target from this and another of the same branch."""
        worst = max(self, other, key=lambda target: target.percent)
        return Target(
            self.profile,
            self.lesions + [lesion for lesion in other.lesions if lesion not in self.lesions],
            min(self.start, other.start),
            max(self.end, other.end),
            worst.s_mla,
            worst.percent,
        )


def stretch_to_cover(profile, lesion, percent):
    """(start, end) as arc lengths in mm of the stretch of a lesion that a stent must cover.

    percent: the lesion's own diameter stenosis. The stretch is the unbroken row of sections round the narrowest one
    with a diameter stenosis of at least 30 %. In a lesion below 60 % the limit is half of `percent` instead.
    """
    threshold = min(STRETCH_PERCENT, percent / 2)
    narrow = profile.stenosis >= threshold
    at = int(np.abs(profile.s - lesion["s_mla_mm"]).argmin())
    healthy = np.flatnonzero(~narrow)
    before, behind = healthy[healthy < at], healthy[healthy > at]
    first = before[-1] + 1 if before.size else 0
    last = behind[0] - 1 if behind.size else len(narrow) - 1
    return float(profile.s[first]), float(profile.s[last])


def all_targets(summary, sections):
    """[Target] of all lesions, one for each, the most severe first. summary, sections: as for Profile."""
    profiles = {}

    def target_of(lesion):
        branch = lesion["branch"]
        if branch not in profiles:
            profiles[branch] = Profile(summary, sections, branch)
        profile = profiles[branch]
        percent = float(profile.stenosis_at(lesion["s_mla_mm"]))
        return Target(profile, [lesion], *stretch_to_cover(profile, lesion, percent), lesion["s_mla_mm"], percent)

    return sorted(map(target_of, summary["lesions"]), key=lambda target: -target.percent)


def targets_to_treat(summary, sections, least_percent=None):
    """[Target] of the lesions with a diameter stenosis of at least least_percent, the most severe first.

    Without least_percent the limit is SIGNIFICANT_PERCENT; if no lesion reaches that, each lesion is a target. Lesions
    above the limit with less than JOIN_DIAMETERS between their stretches become one target, since a stent for one
    would end just before the other (Sianos et al., EuroIntervention 2005;1:219-27).
    """
    all_lesions = all_targets(summary, sections)
    least = SIGNIFICANT_PERCENT if least_percent is None else least_percent
    chosen = join_close([target for target in all_lesions if target.percent >= least])
    return chosen or (all_lesions if least_percent is None else [])


def join_close(targets):
    """[Target] after joining those on one branch with less than JOIN_DIAMETERS between their stretches."""
    done = []
    for target in targets:
        while (near := _close_target(target, done)) is not None:
            done.remove(near)
            target = near.joined_with(target)
        done.append(target)
    return sorted(done, key=lambda target: -target.percent)


def _close_target(target, others):
    """The first of other Targets that lies on the same branch less than JOIN_DIAMETERS away, or None."""
    for other in others:
        gap = max(other.start - target.end, target.start - other.end)
        between = 0.5 * (max(other.start, target.start) + min(other.end, target.end))
        if other.profile is target.profile and gap < JOIN_DIAMETERS * target.profile.reference_at(between):
            return other
    return None
