"""Warnings about parts of a segmentation that may be wrong."""

import numpy as np
from scipy.spatial import cKDTree

BRIGHT = 1.25  # multiple of the blood's CT number: brighter is calcium or metal
NEAR_MM = 1.0  # beyond the edge; bright places this near affect it by blooming
SHARE_OF_RAYS = 0.1
END_MM, WIDER = 3.0, 1.1


def find(lines, tubes, profiles, ends, blood_hu, settings, point_spread_assumed):
    """List of {code, branch, s_start_mm, s_end_mm, value, message}, in order of branch and place."""
    found = []
    for line, tube, profile in zip(lines, tubes, profiles):
        dark = profile.axis_hu / blood_hu
        for a, b in runs(dark < settings["occluded_below"]):
            least = float(dark[a:b].min())
            found.append(
                _entry(
                    "occluded_by_voxels",
                    tube,
                    profile.s_mm[[a, b - 1]],
                    least,
                    f"contrast on the axis falls to {least:.2f} of the blood's (limit"
                    f" {settings['occluded_below']}): the throat is too narrow for this image, its radius a guess;"
                    " smaller voxels and a sharper kernel show more of it",
                )
            )
        reach = tube.radii_mm[..., None] + NEAR_MM
        peak = np.where(profile.r_mm < reach, profile.hu, -np.inf).max(axis=2)
        share = (peak > BRIGHT * blood_hu).mean(axis=1)
        for a, b in runs(share > SHARE_OF_RAYS):
            most = float(share[a:b].max())
            found.append(
                _entry(
                    "calcium_or_metal",
                    tube,
                    profile.s_mm[[a, b - 1]],
                    most,
                    f"brighter than blood beside the lumen on up to {100 * most:.0f} % of the rays: by blooming the"
                    " area is doubtful; a sharper kernel blooms less",
                )
            )
        miss = float(np.linalg.norm(tube.axis.points_mm[-1] - ends[line.end][1]))
        if miss > 0.5:
            message = (
                f"the axis ends {miss:.2f} mm from the end point {ends[line.end][0]}: move it to the vessel's middle"
            )
            found.append(_entry("end_off_axis", tube, [tube.axis.length_mm] * 2, miss, message))
    found += _widening(tubes[0])
    found += _close_pairs(lines, tubes)
    if point_spread_assumed and settings["psf_fwhm_mm"] == "auto" and settings["method"] == "psf_edge":
        message = "no section wide enough to measure the point spread; 0.7 mm is assumed (psf_fwhm_mm gives it)"
        found.append(_entry("point_spread_assumed", tubes[0], [0.0, tubes[0].axis.length_mm], 0.7, message))
    return found


def _widening(main):
    """Warns of a main vessel that is wider at its far end, since the end points may be in the wrong order."""
    areas = np.mean(main.radii_mm**2, axis=1)
    first, last = (np.sqrt(areas[at].mean()) for at in (main.s_mm < END_MM, main.s_mm > main.s_mm[-1] - END_MM))
    if last <= WIDER * first:
        return []
    message = f"the far end is {last / first:.2f} times as wide as the inlet: are the end points in order, inlet first?"
    return [_entry("widens_from_the_inlet", main, main.s_mm[[0, -1]], float(last / first), message)]


def runs(flags):
    """[(start, stop)] of the stretches of True in flags (n,)."""
    edge = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return list(zip(edge[::2], edge[1::2]))


def _entry(code, tube, s_mm, value, message):
    start, end = float(s_mm[0]), float(s_mm[1])
    return {
        "code": code,
        "branch": tube.name,
        "s_start_mm": start,
        "s_end_mm": end,
        "value": value,
        "message": f"{tube.name} {start:.1f}-{end:.1f} mm: {message}",
    }


def _close_pairs(lines, tubes):
    """Warns of vessels within 0.3 mm of each other away from their branching, which may have merged in the image."""
    found = []
    for i, first in enumerate(tubes):
        for j in range(i, len(tubes)):
            second = tubes[j]
            tree = cKDTree(second.axis.point(second.s_mm))
            near = []
            for k, point in enumerate(first.axis.point(first.s_mm)):
                radius = first.radius(first.s_mm[k])
                for other in tree.query_ball_point(point, radius + second.radius(second.s_mm).max() + 0.3):
                    gap = np.linalg.norm(point - tree.data[other]) - radius - second.radius(second.s_mm[other])
                    if gap < 0.3 and _apart(first, second, k, other, radius):
                        near.append((k, gap))
                        break
            if near:
                at = first.s_mm[[near[0][0], near[-1][0]]]
                least = float(min(gap for _, gap in near))
                message = f"within {max(least, 0):.2f} mm of {second.name}: the image may have merged them; look there,"
                message += " and give a centreline if the axis changes the vessel"
                found.append(_entry("close_vessels", first, at, least, message))
    return found


def _apart(first, second, k, other, radius):
    """Whether two places are far from each other along the vessels."""
    if first is second:
        return second.s_mm[other] - first.s_mm[k] > 4 * radius + 4
    if second.parent == first.name:
        return second.s_mm[other] > 4 * radius + 2
    # Branches of one parent may start close to each other.
    return min(first.s_mm[k], second.s_mm[other]) > 4 * radius + 2
