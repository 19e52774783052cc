"""Calcium behind the lumen's wall in a CT angiogram, as thickness and type of plaque at the surface's points."""

import numpy as np

from common.patient.plaque_types import CALCIFIED, NONE

REACH_MM, STEP_MM = 2.5, 0.05  # length and step of the ray behind the wall on which calcium is measured


def plaque_behind(points, segmentation):
    """(thickness (n,) in mm, type (n,)) of the plaque behind points (n, 3) of the wall, in the image's coordinates.

    segmentation: the dict that segment.segment() returns. The thickness is nan where there is no calcium: `lumen
    process` then estimates it from the narrowing.

    Each point lies on a ray from the axis. There is calcium behind the point if the nearest ray of the nearest section
    meets calcium (edges.find_calcium_and_stents). The point spread blurs the outer edge of calcium. So calcium ends
    where the CT number on the ray has fallen half-way from its peak to the tissue's.
    """
    thickness, kind = np.full(len(points), np.nan), np.full(len(points), NONE)
    away, out, calcium = np.full(len(points), np.inf), np.zeros_like(points), np.zeros(len(points), bool)
    for tube, profile, (rays_with_calcium, _, _) in zip(
        segmentation["tubes"], segmentation["profiles"], segmentation["bright"]
    ):
        s = np.clip(tube.axis.nearest(points), 0, tube.axis.length_mm)
        offset = points - tube.axis.point(s)
        gap = np.abs(np.linalg.norm(offset, axis=1) - tube.radius(s))
        _, normal, binormal = tube.axis.frame(s)
        turns = np.arctan2(np.sum(offset * binormal, axis=1), np.sum(offset * normal, axis=1)) / (2 * np.pi)
        rays = len(profile.theta)
        section = np.clip(np.rint(s / profile.s_mm[1]).astype(int), 0, len(profile.s_mm) - 1)
        here = rays_with_calcium[section, np.rint(turns * rays).astype(int) % rays]
        closer = gap < away
        away[closer], out[closer], calcium[closer] = gap[closer], offset[closer], here[closer]
    out /= np.maximum(np.linalg.norm(out, axis=1), 1e-9)[:, None]
    steps = np.arange(0, REACH_MM, STEP_MM)
    hu = segmentation["at"](points[:, None] + steps[None, :, None] * out[:, None])
    peak, place = hu.max(axis=1), hu.argmax(axis=1)
    edge = 0.5 * (peak + segmentation["tissue_hu"])
    beyond = (hu < edge[:, None]) & (np.arange(len(steps)) > place[:, None])
    end = np.where(beyond.any(axis=1), beyond.argmax(axis=1), len(steps) - 1)
    thickness[calcium], kind[calcium] = steps[end[calcium]], CALCIFIED
    return thickness, kind
