"""Calcium behind the lumen's wall in a contrast-filled CT, as the plaque of the lumen surface's points."""

import numpy as np

from . import edges

CALCIFIED = 3  # plaque_type (docs/design.md)
NONE = 0
# The fixed 130 HU of non-contrast scores are below the blood here. Calcium must be brighter than this patient's blood:
# by a quarter, which partial volumes of blood never reach, and by three standard deviations of its noise.
BRIGHTER, DEVIATIONS = 1.25, 3.0
REACH_MM, STEP_MM = 2.5, 0.05


def level_hu(blood_hu, noise_hu):
    """The least CT number that counts as calcium."""
    return max(BRIGHTER * blood_hu, blood_hu + DEVIATIONS * noise_hu)


def noise_hu(at, tube):
    """Standard deviation of the CT number on the axis of a tube, where it is so wide that the axis shows only blood."""
    wide = tube.s_mm[tube.radius(tube.s_mm) > 1.0]
    return float(np.std(at(tube.axis.point(wide)))) if len(wide) > 5 else 0.0


def behind(points, at, found, profiles):
    """(thickness (n,) in mm, type (n,)) of the plaque behind points (n, 3) of the wall.

    It is nan without calcium; `lumen process` then estimates it from the narrowing. at: function that gives CT numbers
    at points; found: as segment.segment returns it; profiles: of its tubes.

    Each point is on a ray from the axis. Calcium reaches from the wall to the place where the CT number has fallen
    half-way from its peak to the tissue's, since the point spread blurs its edge. A stent's metal, which is bright all
    round, does not count.
    """
    tubes, blood = found["tubes"], found["blood_hu"]
    threshold = level_hu(blood, noise_hu(at, tubes[0]))
    thickness, kind = np.full(len(points), np.nan), np.full(len(points), NONE)
    away, s, out = np.full(len(points), np.inf), np.zeros(len(points)), np.zeros_like(points)
    owner = np.zeros(len(points), int)
    for number, tube in enumerate(tubes):
        nearest = np.clip(tube.axis.nearest(points), 0, tube.axis.length_mm)
        offset = points - tube.axis.point(nearest)
        gap = np.abs(np.linalg.norm(offset, axis=1) - tube.radius(nearest))
        closer = gap < away
        away[closer], s[closer], out[closer], owner[closer] = gap[closer], nearest[closer], offset[closer], number
    out /= np.maximum(np.linalg.norm(out, axis=1), 1e-9)[:, None]
    steps = np.arange(0, REACH_MM, STEP_MM)
    hu = at(points[:, None] + steps[None, :, None] * out[:, None])
    peak, place = hu.max(axis=1), hu.argmax(axis=1)
    edge = np.maximum(threshold, 0.5 * (peak + found["tissue_hu"]))
    beyond = (hu < edge[:, None]) & (np.arange(len(steps)) > place[:, None])
    end = np.where(beyond.any(axis=1), beyond.argmax(axis=1), len(steps) - 1)
    bright = peak > threshold
    for number, profile in enumerate(profiles):
        stent = edges.beside(edges.bright(profile, blood)[1], profile.s_mm)
        section = np.abs(s[:, None] - profile.s_mm[None]).argmin(axis=1)
        bright &= ~((owner == number) & stent[section])
    thickness[bright], kind[bright] = steps[end[bright]], CALCIFIED
    return thickness, kind
