"""Diameters of balloons and stents, from the lumen at the stent's two ends.

The rules are those of the EAPCI consensus on intracoronary imaging (Raeber et al., Eur Heart J 2018;39:3281-3300).

- The stent has the diameter of the distal reference lumen, rounded up to the catalogue.
- It is post-dilated by a non-compliant balloon of the proximal reference's diameter, at most half a millimetre above
the distal one.
- In a vessel that tapers by more than half a millimetre, only the stent's proximal half is post-dilated. If the stent
is too short for this, it is dilated over its whole length, by no more than the distal reference allows.
- No balloon opens a stent beyond its design. In a row of stents a balloon ends before a more distal stent that it would
over-expand.

A vessel that no stent fits gets a balloon alone. Its diameter is 0.8 to 1.05 times that of the lumen distal to the
lesion. The consensus on balloons without a stent asks for 0.8 to 1 (Jeger et al., JACC Cardiovasc Interv
2020;13:1391-1402).
"""

import dataclasses
import math

from common.documents import config
from common.errors import InputError

from . import catalogue, landing

LARGEST_OVERSIZE_MM = 0.5  # largest excess of the stent's diameter over the distal reference
LEAST_BALLOON_RATIO, LARGEST_BALLOON_RATIO = (
    0.8,  # least ratio of the diameters of a balloon alone and of the distal lumen
    1.05,  # largest such ratio, also for a balloon before a stent
)
BALLOON_MARGIN_MM = 2.0  # length of a balloon alone beyond each end of the stretch, as for a stent
LARGEST_TAPER_MM = (
    0.5  # largest excess of a balloon over the distal reference, if the balloon dilates the stent over its whole length
)
PREDILATATION, STENT, POSTDILATATION = "semi_compliant", "des", "non_compliant"


@dataclasses.dataclass
class Stent:
    """A planned stent: its landing.Span, nominal diameter, and the reference lumens at its two ends, mm.

    limit: widest diameter (mm) to which its design opens. If another stent overlaps its proximal end, that stent's
    design counts too. distal_limit: widest diameter (mm) of the stent that overlaps its distal end; infinite without
    one. shortest_balloon: length (mm) of the catalogue's shortest post-dilatation balloon.
    """

    span: object
    diameter: float
    proximal_reference: float
    distal_reference: float
    limit: float
    distal_limit: float
    shortest_balloon: float

    @property
    def target_diameter(self):
        """The diameter (mm) that post-dilatation should reach: that of the proximal reference, within `limit`.

        It may be too wide for the stent's distal end (widest_balloon).
        """
        return min(max(self.proximal_reference, self.diameter), self.limit)

    @property
    def widest_balloon(self):
        """The widest diameter (mm) that a balloon over the whole stent may reach."""
        return min(self.distal_reference + LARGEST_TAPER_MM, self.limit, self.distal_limit)

    @property
    def tapers_too_much(self):
        """Whether the proximal reference is too wide for a balloon that also dilates the distal end."""
        return self.target_diameter > self.distal_reference + LARGEST_TAPER_MM

    @property
    def proximal_part_mm(self):
        """Length (mm) of the proximal part that can be post-dilated to target_diameter."""
        if self.tapers_too_much:
            return self.span.length / 2
        return self.span.length - landing.OVERLAP_MM * (self.target_diameter > self.distal_limit)

    @property
    def is_too_short(self):
        """Whether the proximal part is too short for any balloon. The whole stent is then dilated, but less."""
        return self.proximal_part_mm < self.shortest_balloon


class NoFittingStent(InputError):
    """No stent of the catalogue fits the distal reference. A balloon alone may fit."""


class TooTapered(InputError):
    """No stent that fits the distal reference can be expanded to the proximal one. Two in a row might fit."""


def size_stents(profile, spans, families, where):
    """[Stent] for the Spans of a row of stents, the distal one first.

    profile: the branch's profile. Where two stents overlap, the lumen is diseased. So their common reference is the
    healthy vessel at the middle of the overlap. Raises InputError for lumens that the catalogue does not fit.
    """
    joints = [_overlap_reference(profile, after, before) for before, after in zip(spans, spans[1:])]
    distal = [profile.reference_lumen_mm(spans[0].end, 1), *joints]
    proximal = [*joints, profile.reference_lumen_mm(spans[-1].start, -1)]
    diameters = [stent_diameter(families, *ends, where) for ends in zip(distal, proximal)]
    limits = [math.inf, *(_largest_expansion(families, size) for size in diameters), math.inf]
    own_and_next = [min(pair) for pair in zip(limits[1:], limits[2:])]
    shortest = families[POSTDILATATION]["lengths_mm"][0]
    rows = zip(spans, diameters, proximal, distal, own_and_next, limits)
    return [Stent(*row, shortest) for row in rows]


def _overlap_reference(profile, proximal, distal):
    return profile.reference_at(0.5 * (proximal.end + distal.start))


def stent_diameter(families, distal, proximal, where):
    """The least diameter (mm) of a stent that suits the distal and the proximal reference diameter (mm).

    It is not below the distal reference, and its design can be expanded to the proximal one. In a vessel wider than the
    catalogue it is the largest diameter, if its design can be expanded to the vessel. Raises NoFittingStent or
    TooTapered.
    """
    sizes = families[STENT]["diameters_mm"]
    fitting = [size for size in sizes if distal - 1e-9 <= size <= distal + LARGEST_OVERSIZE_MM]
    if distal > sizes[-1] and _largest_expansion(families, sizes[-1]) >= distal:
        fitting = sizes[-1:]
    if not fitting:
        raise NoFittingStent(
            "no stent diameter of the catalogue fits the vessel",
            where,
            f"distal reference {distal:.2f} mm, stents of {sizes[0]} to {sizes[-1]} mm",
            "check the file's units; if the vessel is of that size, add devices for it to config/devices, or treat"
            " another lesion by the plan's steps",
        )
    for size in fitting:
        if _largest_expansion(families, size) >= max(proximal, size):
            return size
    raise TooTapered(
        "no stent that fits the distal reference can be expanded to the proximal one",
        where,
        f"distal reference {distal:.2f} mm, proximal {proximal:.2f} mm",
        "write the plan's steps: two overlapping stents of different diameters, or a landing in less tapered lumen",
    )


def _largest_expansion(families, size):
    """Widest diameter (mm) to which the design of a stent of nominal diameter `size` (mm) opens."""
    designs = families[STENT]["designs"]
    return next(d for d in designs if size <= d["up_to_diameter_mm"])["maximal_diameter_mm"]


def predilatation(families, stent, stretch, where):
    """(diameter, length) in mm of the balloon that opens the lesion before a Stent.

    stretch: length (mm) to dilate. The diameter is at most 5 % above the distal reference. The balloon is no longer
    than the stent.
    """
    family = families[PREDILATATION]
    diameter = _largest_up_to(
        family["diameters_mm"], LARGEST_BALLOON_RATIO * stent.distal_reference, "predilatation diameter", where
    )
    longest = _largest_up_to(family["lengths_mm"], stent.span.length, "predilatation length", where)
    return diameter, min([x for x in family["lengths_mm"] if stretch <= x <= longest], default=longest)


def postdilatation(families, stent, where):
    """(diameter, length, centre, (wanted, greatest) inflated diameter) in mm of the balloon after a Stent.

    It covers the stent's proximal part alone if the distal end would not bear its diameter.
    """
    family = families[POSTDILATATION]
    in_part = stent.proximal_part_mm < stent.span.length and not stent.is_too_short
    most = stent.limit if in_part else stent.widest_balloon
    wanted = min(stent.target_diameter, most)
    sizes = [size for size in family["diameters_mm"] if size <= most + 1e-9] or family["diameters_mm"][:1]
    diameter = min(sizes, key=lambda size: abs(size - wanted))
    covered = stent.proximal_part_mm if in_part else stent.span.length
    length = _largest_up_to(family["lengths_mm"], covered, "post-dilatation length", where)
    centre = round(stent.span.start + length / 2, 3) if in_part else stent.span.centre
    return diameter, length, centre, (wanted, most)


def balloon_alone(families, target, where):
    """A plan's step: the widest balloon that opens a targets.Target without a stent; None if none fits.

    The balloon is semi-compliant if there is one of that width, else non-compliant. It reaches BALLOON_MARGIN_MM past
    both ends of the stretch if the branch has room. It is inflated to the diameter of the lumen distal to the stretch,
    or to its nominal diameter if that is larger, as far as its pressures allow.
    """
    lowest, highest = target.profile.limits_mm
    wanted = target.end - target.start + 2 * BALLOON_MARGIN_MM
    for name in (PREDILATATION, POSTDILATATION):
        family = families[name]
        long = [length for length in family["lengths_mm"] if length <= highest - lowest]
        if not long:
            continue
        length = next((length for length in long if length >= wanted), long[-1])
        middle = min(max(0.5 * (target.start + target.end), lowest + length / 2), highest - length / 2)
        distal = target.profile.reference_lumen_mm(middle + length / 2, 1)
        wide = [
            size
            for size in family["diameters_mm"]
            if LEAST_BALLOON_RATIO * distal <= size <= LARGEST_BALLOON_RATIO * distal
        ]
        if wide:
            size = (name, wide[-1], length, target.profile.branch, round(middle, 3))
            return plan_step(families, "predilatation", *size, (max(distal, wide[-1]), math.inf), where)
    return None


def plan_step(families, action, family, diameter, length, branch, centre, wanted, where):
    """A plan's step with one device of a diameter and length (mm), its centre at an arc length (mm) of a branch.

    wanted: (wanted, greatest) inflated diameter in mm. The pressure is chosen to come as near to the wanted one as
    possible.
    """
    inflated = config.balloon_family(families, family)
    balloon = catalogue.device_entries(families, inflated, diameter, length, where).popitem()[1]
    size = {"device": family, "diameter_mm": diameter, "length_mm": length}
    place = {"branch": branch, "centre_s_mm": centre, "pressure_bar": catalogue.pressure_for(balloon, *wanted)}
    return {"action": action, "devices": [size | place]}


def _largest_up_to(sizes, wanted, what, where):
    """The largest of rising sizes (mm) not above the wanted one. Raises InputError if all are larger."""
    for size in reversed(sizes):
        if size <= wanted + 1e-9:
            return size
    remedy = f"the smallest is {sizes[0]} mm: add a smaller one in config/devices, or write the plan's steps"
    raise InputError(f"no {what} small enough in the catalogue", where, f"{wanted:.2f} mm wanted at most", remedy)
