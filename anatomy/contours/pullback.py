"""A pull-back: its frames from distal to proximal, the traced outlines in each, and warnings."""

from dataclasses import dataclass, field

import numpy as np

from common.errors import InputError

from . import rings
from .reading import REGION_TABLES, tables

SAME_Z_MM = 0.01  # z of one frame may differ this much between two tables, which may be rounded to two decimals
# Frames nearer than this (mm) count as two at one place. In a pull-back of 0.5 mm/s with 60 frames a second they are
# 0.008 mm apart.
SAME_PLACE_MM = 0.005
FEWEST_FRAMES = 3  # two ends and a frame between them
USUAL_GAP_MM = 2.0  # a longer gap between frames gives a warning, since the lumen there is interpolated only


@dataclass
class Frame:
    """One frame of a pull-back, in mm. name: its name in the tables. z_mm rises from distal to proximal.

    Outlines are (n, 2), in the image's plane.
    """

    name: object
    z_mm: float
    lumen: np.ndarray
    outer_wall: np.ndarray = None
    regions: dict = field(default_factory=dict)  # {calcium, lipid: [traced outline]}


@dataclass
class Pullback:
    """Frames from distal to proximal, landmarks and warnings [str].

    landmarks: [(z_mm, point (2,) in mm in the image's plane)] in the order of their table. sign: factor from z in the
    tables to z_mm. It is 1, or -1 if z in the tables rises from the proximal end.
    """

    frames: list
    landmarks: list
    warnings: list
    sign: float = 1.0

    @property
    def z_mm(self):
        """z of the frames, rising from distal to proximal."""
        return np.array([frame.z_mm for frame in self.frames])


def read(files, units="mm", z_from="distal", z_range_mm=None, drop_frames=()):
    """The Pullback of contour tables. Raises InputError.

    files: {lumen, outer_wall, calcium, lipid, branches, landmarks: path}; the lumen is required. units: unit of x, y,
    z. z_from: the end at which z in the tables is smallest, `distal` or `proximal`. z_range_mm: (lowest, highest) z of
    the used frames as in the tables, to leave out frames in a guide catheter. drop_frames: names of frames to leave
    out.
    """
    first, last = z_range_mm or (-np.inf, np.inf)
    if not first < last:
        raise InputError("empty range of z", "z_range_mm", [first, last], "the lower z first")
    dropped, seen = set(drop_frames), set()

    def is_used(frame, z):
        seen.add(frame)
        return first <= z <= last and frame not in dropped

    warnings = [warning for path in files.values() if path and (warning := tables.unknown_names_warning(path))]
    lumen = tables.read_outlines(files["lumen"], units, "lumen", is_used)
    _check_frames(lumen, files["lumen"], warnings)
    frames = {name: Frame(name, z, outline) for name, (z, outline) in lumen.items()}
    if files.get("outer_wall"):
        walls = tables.read_outlines(files["outer_wall"], units, "outer_wall", is_used)
        for name, outline in _match_frames(walls, files, "outer_wall", frames, warnings):
            frames[name].outer_wall = outline
    for kind in REGION_TABLES:
        if files.get(kind):
            regions = tables.read_regions(files[kind], units, kind, is_used)
            for name, several in _match_frames(regions, files, kind, frames, warnings):
                frames[name].regions[kind] = several
    if files.get("branches"):
        _warn_of_branches(tables.read_regions(files["branches"], units, "branches", is_used), warnings)
    _check_dropped(dropped - seen, seen, files["lumen"])
    landmarks = tables.read_points(files["landmarks"], units) if files.get("landmarks") else []
    sign = 1.0 if z_from == "distal" else -1.0
    for frame in frames.values():
        frame.z_mm *= sign
    ordered = sorted(frames.values(), key=lambda frame: frame.z_mm)
    return Pullback(ordered, [(sign * z, point) for _, z, point in landmarks], warnings, sign)


def _check_dropped(missing, seen, path):
    """Raises InputError if a frame to leave out is in no table.

    It is then named wrongly, and the frame that the user means would be used without notice.
    """
    if missing:
        names = sorted(seen)
        value = f"{', '.join(f'{name:g}' for name in sorted(missing))}; the tables have {len(names)} frames from"
        value += f" {names[0]:g} to {names[-1]:g}"
        raise InputError("no such frame to leave out", f"drop_frames, {path}", value, "name frames as the tables do")


def _check_frames(lumen, path, warnings):
    if len(lumen) < FEWEST_FRAMES:
        remedy = f"at least {FEWEST_FRAMES} frames of the lumen within z_range_mm and not in drop_frames"
        raise InputError("too few frames", path, f"{len(lumen)} are left to use", remedy)
    order = sorted(lumen, key=lambda name: lumen[name][0])
    for one, other in zip(order, order[1:]):
        gap = lumen[other][0] - lumen[one][0]
        if gap < SAME_PLACE_MM:
            value = f"frames {one} and {other} at z {lumen[one][0]:g} mm"
            remedy = "one phase of the heart, each frame once; leave one out by drop_frames"
            raise InputError("two frames at one place", path, value, remedy)
        if gap > USUAL_GAP_MM:
            warnings.append(
                f"no frame between z {lumen[one][0]:.2f} and {lumen[other][0]:.2f} mm ({gap:.1f} mm): "
                "a narrowing between them would not be seen"
            )


def _match_frames(table, files, what, frames, warnings):
    """Yields (frame's name, outline or outlines) of the table `what`, for frames with a lumen.

    table: {frame's name: (z, outline or outlines)}. Warns of frames without a lumen. Raises InputError if the z of a
    frame differs from its z in the lumen's table.
    """
    path = files[what]
    unmatched = []
    for name, (z, traced) in table.items():
        if name not in frames:
            unmatched.append(name)
        elif abs(z - frames[name].z_mm) > SAME_Z_MM:
            value = f"z {z:g} mm, in the lumen's table {frames[name].z_mm:g} mm"
            remedy = "both tables from one pull-back, a frame's z the same in them"
            raise InputError("one frame at two places", f"{path}: {what}, frame {name}", value, remedy)
        else:
            yield name, traced
    if unmatched:
        warnings.append(f"{what}: frames without a lumen are not used: {', '.join(map(str, unmatched))}")


def _warn_of_branches(branches, warnings):
    widths = {z: 2 * np.sqrt(max(map(rings.area_mm2, several)) / np.pi) for z, several in branches.values()}
    if widths:
        warnings.append(
            f"a side branch runs beside the vessel from z {min(widths):.1f} to {max(widths):.1f} mm, up to "
            f"{max(widths.values()):.2f} mm wide: it is not part of the lumen, what it carries stays in the vessel"
        )
