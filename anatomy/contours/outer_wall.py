"""The outer wall in every frame: as traced, interpolated between traced frames, and unknown beyond them."""

import numpy as np

from . import rings
from .reading.outlines import centroid

MOST_NAMED_FRAMES = 5  # a warning names at most this many frames: the first ones and the last


def is_traced(frames):
    """(frames,) of bool: whether the outer wall was traced in each frame."""
    return np.array([frame.outer_wall is not None for frame in frames])


def interpolated_outlines(frames, z_mm, count):
    """Outlines (frames, count, 2) in mm of the outer wall in all frames, interpolated from the traced frames.

    z_mm (frames,): z of the frames, rising. The outer wall is interpolated, not the thickness between lumen and wall: a
    narrowing changes the lumen from frame to frame, but hardly the outer wall. Its shape is taken relative to the
    lumen's centre, since the catheter moves within the vessel. The area is interpolated by itself, and the shapes are
    scaled to it. Beyond the first and the last traced frame shape and area are constant.
    """
    traced = np.flatnonzero(is_traced(frames))
    centre = np.array([centroid(rings.smooth(frame.lumen)) for frame in frames])
    walls = np.array([rings.ring_from_outline(frames[k].outer_wall, count) - centre[k] for k in traced])
    areas = np.array([rings.area_mm2(frames[k].outer_wall) for k in traced])
    shapes, sizes = (rings.interpolator(z_mm[traced], values)(z_mm) for values in (walls, areas))
    return rings.scale_to_areas(shapes, sizes) + centre[:, None]


def known_range_mm(frames, z_mm):
    """(lowest, highest) z in mm at which the outer wall counts as known.

    The range ends half-way from the first, and from the last, traced frame to the next frame beyond.
    """
    traced = np.flatnonzero(is_traced(frames))
    first, last = traced[0], traced[-1]
    low = 0.5 * (z_mm[first] + z_mm[max(first - 1, 0)])
    return low, 0.5 * (z_mm[last] + z_mm[min(last + 1, len(z_mm) - 1)])


def warnings(pull):
    """Warnings [str] on frames of a Pullback without an outer wall: interpolated between traced ones, else unknown."""
    traced = np.flatnonzero(is_traced(pull.frames))
    missing = [k for k in range(len(pull.frames)) if k not in traced]
    inner = [k for k in missing if traced[0] < k < traced[-1]]
    sentences = []
    if inner:
        gap = np.diff(pull.z_mm[traced]).max()
        sentences.append(
            f"no outer wall in frames {_frame_names(pull, inner)}: it is interpolated between the frames beside them,"
            f" which are up to {gap:.1f} mm apart"
        )
    for outer in ([k for k in missing if k < traced[0]], [k for k in missing if k > traced[-1]]):
        if outer:
            sentences.append(_unknown_wall_sentence(pull, outer))
    return sentences


def _unknown_wall_sentence(pull, outer):
    low, high = sorted(pull.sign * pull.z_mm[[outer[0], outer[-1]]])
    where = f"z {low:.1f} to {high:.1f} mm" if len(outer) > 1 else f"z {low:.1f} mm"
    sentence = (
        f"no outer wall in frames {_frame_names(pull, outer)}, beyond those where it was traced: plaque is not known at"
        f" {where}. It is estimated from the narrowing alone, and so are the sizes of devices; trace the wall there"
    )
    unused_frames = [pull.frames[k].name for k in outer if pull.frames[k].regions]
    return sentence + f". Calcium and lipid of frames {', '.join(map(str, unused_frames))} are not used" * bool(
        unused_frames
    )


def _frame_names(pull, numbers):
    """The names of some frames, by their numbers in the Pullback, for a sentence."""
    names = [str(pull.frames[k].name) for k in numbers]
    return ", ".join(names if len(names) <= MOST_NAMED_FRAMES else [*names[: MOST_NAMED_FRAMES - 1], "...", names[-1]])
