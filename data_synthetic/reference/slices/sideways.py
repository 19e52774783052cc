"""A treated section that is pressed sideways by its stent: the law of its resistance, and its shape."""

import numpy as np

from common.errors import ComputationError

from ..straightening import beams
from ..straightening.stent_in_vessel import SidewaysLaw
from .model import SUPPORT_SHIFT

# Shifts of the tissue around by which the law is measured. The largest force is then 0.3 to 0.5 N/mm in a coronary
# artery; in the sharp bends of the cases a stent presses with at most 0.2 N/mm.
SUPPORT_SHIFTS_MM = (0.5, 1.0, 2.0, 4.0)


def bend_direction(axis, s_mm):
    """Unit vector (2,) towards the centre of the bend at arc length s_mm, in the section's frame."""
    (curvature,) = beams.curvature_vectors(axis, np.array([s_mm]))
    _, normal, binormal = (v[0] for v in axis.frame(np.array([s_mm])))
    along = np.array([curvature @ normal, curvature @ binormal])
    size = np.linalg.norm(along)
    return along / size if size > 1e-9 else np.array([1.0, 0.0])


def sideways_law(model, direction, where):
    """SidewaysLaw of the slice that `model` has solved, the mean of both senses of `direction` (2,).

    The stent stays and the tissue around is shifted. This is the same as a shift of the stent, seen from the vessel.
    The bending of the wall along the vessel is that of the shape at the first shift. where: for messages. The slice is
    left as it was. Raises ComputationError.
    """
    rest, outside, lumen, support = (
        model.state(),
        model.outside_shift(),
        model.lumen_centre(),
        model.support_n_per_mm2(),
    )
    at_rest = model.displacement()
    measured, bending = [], []
    for sense in (direction, -direction):
        model.restore(rest)
        points = []
        for shift in SUPPORT_SHIFTS_MM:
            try:
                _advance(model, shift * sense, where)
            except ComputationError:
                break  # the wall folds; the law goes on as a line
            if not points:
                first = model.displacement() - at_rest, model.outside_shift() - outside
            moved = (model.outside_shift() - outside) @ sense
            points.append((moved, support * (shift - moved), moved - (model.lumen_centre() - lumen) @ sense))
        if not points:
            raise ComputationError(
                "the section cannot be pressed sideways", where, f"{SUPPORT_SHIFTS_MM[0]} mm", model.remedy
            )
        model.restore(rest)
        measured.append(points)
        bending.append(model.wall_bending(*first))
    count = min(map(len, measured))
    mean = np.mean([points[:count] for points in measured], axis=0)
    return SidewaysLaw(*np.concatenate([np.zeros((1, 3)), mean]).T, *np.mean(bending, axis=0))


def press(model, offset_mm, force_n_per_mm, where):
    """Presses the slice that `model` has solved sideways by its stent. Returns its lumen's displacement (2 around, 2).

    offset_mm, force_n_per_mm (2,): as a SidewaysLaw relates them. The displacement, in mm, is that in the frame in
    which the outside has not moved since the procedure. Raises ComputationError.
    """
    before = model.outside_shift()
    _advance(model, -offset_mm - force_n_per_mm / model.support_n_per_mm2(), where)
    return model.lumen_displacement() - (model.outside_shift() - before)


def _advance(model, shift_mm, where):
    model.advance(dict(zip(SUPPORT_SHIFT, shift_mm)), f"{where}, pressed sideways")
