"""The outer wall in every frame: as traced, interpolated between traced frames, and unknown beyond them."""

import numpy as np

from . import rings
from .reading.outlines import centroid

NAMED = 5  # frames that a warning names; of more it names the first ones and the last


def traced(frames):
    """(frames,) of bool: whether the outer wall was traced in each frame."""
    return np.array([frame.outer_wall is not None for frame in frames])


def outlines_of(frames, z_mm, count):
    """Outlines (frames, count, 2) in mm of the outer wall in all frames, interpolated from the traced frames.

    z_mm: (frames,) of the frames, rising. The wall is interpolated, not its thickness: in a narrowing the lumen differs
    from that of neighbouring frames, but the outer wall hardly does. Its shape is taken relative to the lumen's centre,
    since the catheter moves within the vessel. Its area is interpolated too. Beyond the first and the last traced
    frame both are constant.
    """
    have = np.flatnonzero(traced(frames))
    centre = np.array([centroid(rings.smooth(frame.lumen)) for frame in frames])
    walls = np.array([rings.ring(frames[k].outer_wall, count) - centre[k] for k in have])
    areas = np.array([rings.area_mm2(frames[k].outer_wall) for k in have])
    shapes, sizes = (rings.between(z_mm[have], values)(z_mm) for values in (walls, areas))
    return rings.scaled(shapes, sizes) + centre[:, None]


def reach_mm(frames, z_mm):
    """(lowest, highest) z in mm at which the outer wall counts as known.

    It is known half-way from the first and the last traced frame to the next frame beyond.
    """
    have = np.flatnonzero(traced(frames))
    first, last = have[0], have[-1]
    low = 0.5 * (z_mm[first] + z_mm[max(first - 1, 0)])
    return low, 0.5 * (z_mm[last] + z_mm[min(last + 1, len(z_mm) - 1)])


def warnings(pull):
    """List of warnings on the frames of a Pullback without an outer wall, between traced frames and beyond them."""
    have = np.flatnonzero(traced(pull.frames))
    missing = [k for k in range(len(pull.frames)) if k not in have]
    inner = [k for k in missing if have[0] < k < have[-1]]
    said = []
    if inner:
        gap = np.diff(pull.z_mm[have]).max()
        said.append(
            f"no outer wall in frames {_named(pull, inner)}: it is interpolated between the frames beside them,"
            f" which are up to {gap:.1f} mm apart"
        )
    for outer in ([k for k in missing if k < have[0]], [k for k in missing if k > have[-1]]):
        if outer:
            said.append(_unknown(pull, outer))
    return said


def _unknown(pull, outer):
    low, high = sorted(pull.sign * pull.z_mm[[outer[0], outer[-1]]])
    where = f"z {low:.1f} to {high:.1f} mm" if len(outer) > 1 else f"z {low:.1f} mm"
    sentence = (
        f"no outer wall in frames {_named(pull, outer)}, beyond those where it was traced: plaque is not known at"
        f" {where}. It is estimated from the narrowing alone, and so are the sizes of devices; trace the wall there"
    )
    lost = [pull.frames[k].name for k in outer if pull.frames[k].regions]
    return sentence + f". Calcium and lipid of frames {', '.join(map(str, lost))} are not used" * bool(lost)


def _named(pull, numbers):
    """The names of some frames, by their numbers in the Pullback, for a sentence."""
    names = [str(pull.frames[k].name) for k in numbers]
    return ", ".join(names if len(names) <= NAMED else [*names[: NAMED - 1], "...", names[-1]])
