"""The treated segment: given on the pre-PCI axis, mapped to every other state, sampled at equal relative positions."""

import dataclasses

import numpy as np

from common.errors import ComputationError, InputError
from reports.inputs.polyline import Polyline, read_centreline
from reports.inputs.reading import entry, number, read_json, read_table

SECTION_NUMBERS = ("s_mm", "area_mm2", "equivalent_diameter_mm")
# Sections flagged `ostium` are used: the part of their area in the side branch is left out. Those flagged `end` are not
# used: they cut a cap, or lie near one.
USED_FLAGS = ("ok", "ostium")
FLAGS = (*USED_FLAGS, "end")


@dataclasses.dataclass(frozen=True)
class TreatedSegment:
    """The treated segment on the pre-PCI centreline `line`: branch, arc lengths and points (3,) of its ends, in mm.

    The margins are included.
    """

    line: Polyline
    branch: str
    s_start_mm: float
    s_end_mm: float
    proximal_mm: np.ndarray
    distal_mm: np.ndarray


@dataclasses.dataclass(frozen=True)
class StateSegment:
    """The segment on one state's centreline: arc lengths of its ends, and their distances from the pre-PCI ends.

    A lumen from another image may cover only a part of the segment. Then an arc length is below 0 or beyond the line.
    """

    line: Polyline
    s_start_mm: float
    s_end_mm: float
    proximal_shift_mm: float
    distal_shift_mm: float

    @property
    def length_mm(self):
        return self.s_end_mm - self.s_start_mm

    @property
    def line_ends_within(self):
        """Whether the state's line ends before the segment does, at either end."""
        return self.s_start_mm < self.line.s_mm[0] or self.s_end_mm > self.line.s_mm[-1]

    def stations(self, relative):
        """Arc lengths (mm) at relative positions 0 (proximal end) to 1 (distal end)."""
        return self.s_start_mm + np.asarray(relative) * self.length_mm


def treated_segment(scene_path, pre_line_path, margin_mm):
    """The TreatedSegment of a scene.json, `margin_mm` longer at both ends and kept on the branch.

    Raises InputError for a segment that is empty or lies outside its branch.
    """
    scene = read_json(scene_path, "workflow scene")
    branch = entry(scene, "segment.branch", scene_path)
    start, end = (number(scene, f"segment.{key}", scene_path) for key in ("s_start_mm", "s_end_mm"))
    line = read_centreline(pre_line_path, branch)
    low, high = line.s_mm[0], line.s_mm[-1]
    if not low <= start < end <= high:
        remedy = f"give a segment within {low:.2f} to {high:.2f} mm of branch {branch}"
        raise InputError("the treated segment is not on its branch", scene_path, f"{start} to {end} mm", remedy)
    start, end = max(low, start - margin_mm), min(high, end + margin_mm)
    return TreatedSegment(line, branch, float(start), float(end), line.point_at(start), line.point_at(end))


def map_segment(segment, line, diameter_mm, may_end_within=False):
    """The StateSegment of `segment` on a state's centreline `line`: each end moves to the nearest point of the line.

    diameter_mm: the vessel's diameters (2,) at the two ends before the procedure.
    may_end_within: whether the line may end within the segment, since it comes from another image. If it does, the
    missing length is measured on the pre-PCI axis, from the line's end to the segment's end.

    Raises ComputationError if an end is further from the line than the vessel's diameter: then it is off the vessel.
    Also raises it if the length changes by half or more: then it is another piece of the vessel.
    """
    start, start_shift = line.project(segment.proximal_mm)
    end, end_shift = line.project(segment.distal_mm)
    if may_end_within and start <= line.s_mm[0]:
        projected_s, start_shift = segment.line.project(line.points[0])
        start -= max(projected_s - segment.s_start_mm, 0.0)
    if may_end_within and end >= line.s_mm[-1]:
        projected_s, end_shift = segment.line.project(line.points[-1])
        end += max(segment.s_end_mm - projected_s, 0.0)
    for name, shift, limit in zip(("proximal", "distal"), (start_shift, end_shift), diameter_mm):
        if shift > limit:
            remedy = (
                f"expected within the vessel's diameter, {limit:.2f} mm: check this state's centreline and branches"
            )
            raise ComputationError(f"the segment's {name} end is off the axis", line.source, f"{shift:.2f} mm", remedy)
    before = segment.s_end_mm - segment.s_start_mm
    if not 0.5 * before < end - start < 1.5 * before:
        remedy = f"expected about {before:.2f} mm: check this state's centreline and branches"
        raise ComputationError("the segment changed its length", line.source, f"{end - start:.2f} mm", remedy)
    return StateSegment(line, start, end, start_shift, end_shift)


def read_sections(path, branch):
    """The sections of a branch, in order of s_mm, without sections flagged `end`; InputError if none is left."""
    table = read_table(path, SECTION_NUMBERS, ("branch", "flag"), "anatomy")
    unknown = sorted(set(table["flag"]) - set(FLAGS))
    if unknown:
        raise InputError("a section's flag is not known", path, unknown[0], f"one of {', '.join(FLAGS)}")
    used = table[(table["branch"] == branch) & table["flag"].isin(USED_FLAGS)]
    used = used.sort_values("s_mm", kind="stable").reset_index(drop=True)
    if len(used) < 2:
        raise InputError("a branch has too few sections", path, f"{branch}: {len(used)}", "repeat the anatomy step")
    if used["area_mm2"].min() <= 0.0:
        raise InputError("an area is not positive", path, used["area_mm2"].min(), "repeat the anatomy step")
    return used


def diameters_at(sections, s_mm):
    """Equivalent diameter (mm) of the sections at the arc lengths s_mm, by linear interpolation."""
    return np.interp(s_mm, sections["s_mm"], sections["equivalent_diameter_mm"])
