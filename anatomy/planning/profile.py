"""The lumen along one branch for planning: diameter, healthy reference, mouths of side branches."""

import numpy as np

from common.errors import InputError

REFERENCE_LENGTH_MM = 2.0  # length beyond a device's end over which its reference lumen is averaged
CAP_MARGIN_MM = 1.5  # least distance of a device from a cap: sections nearer to it would cut the cap
LANDING_HALF_MM = 0.5  # half the length of the landing zone round a stent's end
NORMAL_RANGE = (0.85, 1.05)  # limits of a lumen that shows the vessel's healthy size, as shares of the reference


class Profile:
    """The lumen along one branch, by its sections.

    s, diameter, reference (n,): arc length, diameter and healthy diameter in mm. stenosis (n,): per cent by diameter,
    negative where the lumen is wider than the reference. Arc lengths of a side branch count from its parent's axis; its
    first section is outside the parent's lumen.

    measured (n,): whether a section is away from the ends. usable (n,): whether it is so, and outside the mouths of
    side branches. mouths: {side branch: (s_low, s_high) in mm}. limits_mm: (s_low, s_high) between which a stent may be
    placed. is_side_branch: whether the branch leaves another one; otherwise it begins at a cut end of the vessel.
    """

    def __init__(self, summary, sections, branch):
        if branch not in sections:
            raise InputError("branch without cross-sections", "sections.csv", branch, "run `lumen process` again")
        rows = sections[branch]
        self.branch = branch
        entry = next(b for b in summary["branches"] if b["name"] == branch)
        self.length_mm = entry["length_mm"]
        self.s, self.diameter, self.reference = np.array(
            [[row[key] for key in ("s_mm", "equivalent_diameter_mm", "reference_diameter_mm")] for row in rows]
        ).T
        self.is_side_branch = entry["parent"] is not None
        first = float(self.s[0]) if self.is_side_branch else CAP_MARGIN_MM
        self.limits_mm = first, self.length_mm - CAP_MARGIN_MM
        self.stenosis = 100 * (1 - self.diameter / self.reference)
        self.measured = np.array([row["flag"] != "end" for row in rows])
        self.mouths = mouths(summary, branch)
        self.usable = np.array([row["flag"] == "ok" for row in rows])
        for low, high in self.mouths.values():
            self.usable &= (self.s < low) | (self.s > high)

    def stenosis_at(self, s_mm):
        """Diameter stenosis (per cent) at arc lengths s_mm, interpolated linearly between the sections."""
        return np.interp(s_mm, self.s, self.stenosis)

    def reference_at(self, s_mm):
        """Healthy diameter (mm) of the vessel at arc length s_mm."""
        return float(np.interp(s_mm, self.s, self.reference))

    def deviation_percent(self, s_mm):
        """Largest difference (per cent by diameter) of the lumen from the reference within LANDING_HALF_MM of s_mm."""
        return float(np.abs(self.stenosis_at(s_mm + np.linspace(-LANDING_HALF_MM, LANDING_HALF_MM, 5))).max())

    def mouth_at(self, s_mm):
        """Name of the side branch whose mouth contains s_mm, or None."""
        return next((name for name, (low, high) in self.mouths.items() if low < s_mm < high), None)

    def reference_lumen_mm(self, s_mm, direction):
        """Diameter (mm) of the lumen that sizes a device, at the device's end at s_mm.

        direction: -1 for the proximal end, 1 for the distal end. The diameter is averaged over the usable sections
        within REFERENCE_LENGTH_MM beyond the end. Without such sections the nearest usable one counts. A diffusely
        diseased or dilated lumen does not show the vessel's size. So the result is limited to the range NORMAL_RANGE of
        the healthy reference.
        """
        beyond = direction * (self.s - s_mm)
        chosen = self.usable & (beyond >= 0) & (beyond <= REFERENCE_LENGTH_MM)
        if not chosen.any():
            candidates = np.flatnonzero(self.usable if self.usable.any() else self.measured)
            chosen = candidates[np.abs(self.s[candidates] - s_mm).argmin()]
        healthy = float(np.mean(self.reference[chosen]))
        return float(np.clip(np.mean(self.diameter[chosen]), NORMAL_RANGE[0] * healthy, NORMAL_RANGE[1] * healthy))


def mouths(summary, parent):
    """{side branch: (s_low, s_high) in mm} of the mouths on the branch `parent`.

    A mouth is as wide as the outlet of its side branch.
    """
    width = {end["branch"]: end["diameter_mm"] for end in summary.get("ends", ()) if end["kind"] == "outlet"}
    sides = [branch for branch in summary["branches"] if branch.get("parent") == parent]
    middles = {side["name"]: side["s_on_parent_mm"] for side in sides}
    return {name: (s - width[name] / 2, s + width[name] / 2) for name, s in middles.items()}
