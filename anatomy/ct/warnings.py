"""Warnings about parts of a segmentation that may be wrong."""

import numpy as np
from scipy.spatial import cKDTree

from .rays.edges import HEALTHY_WALL_HU

BLOOMING_MM = 1.0  # bright places within this distance beyond the lumen's edge move the edge by blooming
# Calcium nearer to the lumen than this gave areas of 0.94 to 1.20 of the true ones, farther calcium 0.85 to 1.02.
CLOSE_CALCIUM_MM = 0.3
CALCIUM_RAY_SHARE, STENT_RAY_SHARE = (
    0.05,  # share of a section's rays with calcium above which a warning is given
    0.8,  # share above which the warning says that it may be a stent
)
LARGEST_GAP_MM = 2.5  # bright stretches nearer to each other are one
# A warning is given below this contrast over noise. At 10 radii were off by up to 0.06 mm, at 6 by 0.15 mm.
DOUBTFUL_CONTRAST = 10.0
LOW_BLOOD_HU = 250.0  # in darker blood a wall 30 HU off the assumed 50 HU changes the contrast by 15 % or more
END_LENGTH_MM, WIDENING_RATIO = (
    3.0,  # length of the stretch at each end over which the radius is averaged
    1.1,  # ratio of the radii, far end over inlet, above which a warning is given
)


def find_warnings(lines, tubes, profiles, bright, ends, levels, settings, point_spread_assumed, stented):
    """[{code, branch, s_start_mm, s_end_mm, value, message}]: the warnings on a segmentation.

    lines, tubes, profiles, bright: lists with an entry for each branch. The entries are paths.Line, Tube, Profiles and
    the result of edges.find_calcium_and_stents(). ends: [(name, centre (3,) in mm)]. levels: (CT number of the blood,
    noise), in HU. settings: the section `segmentation`. point_spread_assumed: whether the image does not show its point
    spread. stented: whether the user says that there is a stent.
    """
    found, (blood_hu, noise_hu) = [], levels
    for line, tube, profile, places in zip(lines, tubes, profiles, bright):
        dark = profile.axis_hu / blood_hu
        for a, b in true_runs(dark < settings["occluded_below"]):
            least = float(dark[a:b].min())
            found.append(
                warning_entry(
                    "occluded_by_voxels",
                    tube,
                    profile.s_mm[[a, b - 1]],
                    least,
                    f"contrast on the axis falls to {least:.2f} of the blood's (limit"
                    f" {settings['occluded_below']}): the throat is too narrow for this image, its radius a guess;"
                    " smaller voxels and a sharper kernel show more of it",
                )
            )
        found += _bright_stretches(tube, profile, places, settings["method"], stented)
        miss = float(np.linalg.norm(tube.axis.points_mm[-1] - ends[line.end][1]))
        if miss > 0.5:
            message = (
                f"the axis ends {miss:.2f} mm from the end point {ends[line.end][0]}: move it to the vessel's middle"
            )
            found.append(warning_entry("end_off_axis", tube, [tube.axis.length_mm] * 2, miss, message))
    found += _low_contrast(tubes[0], blood_hu, noise_hu)
    if stented and not any(stent.any() for _, _, stent in bright):
        message = "called stented, but no section is bright all round: read as a vessel without a stent"
        found.append(warning_entry("no_stent_seen", tubes[0], [0.0, tubes[0].axis.length_mm], 0.0, message))
    found += _widening(tubes[0])
    found += _close_pairs(tubes)
    if point_spread_assumed and settings["psf_fwhm_mm"] == "auto" and settings["method"] == "psf_edge":
        message = "no section wide enough to measure the point spread; 0.7 mm is assumed (psf_fwhm_mm gives it)"
        found.append(warning_entry("point_spread_assumed", tubes[0], [0.0, tubes[0].axis.length_mm], 0.7, message))
    return found


def _bright_stretches(tube, profile, places, method, stented):
    """[warning_entry] for stents and for calcium near the edge. Each says if the area is too large or too small."""
    calcium, radius, stent = places
    share = (calcium & (radius < tube.radii_mm + BLOOMING_MM)).mean(axis=1)
    found = []
    for a, b in true_runs(_fill_short_gaps(share > CALCIUM_RAY_SHARE, profile.s_mm)):
        most = float(share[a:b].max())
        message = f"calcium beside the lumen on up to {100 * most:.0f} % of the rays: "
        if method == "threshold":
            message += "it counts as lumen, so the area is too large; psf_edge fits the edge inside it"
        else:
            message += "the edge is fitted inside it; the area may be 15 % too small, or 20 % too large where the"
            message += f" calcium is less than {CLOSE_CALCIUM_MM:g} mm from the lumen"
        if most > STENT_RAY_SHARE and not stented:
            message += "; if it is a stent, the area is far too small: say so (--stented, ct: stented: true in a case)"
        found.append(warning_entry("calcium_or_metal", tube, profile.s_mm[[a, b - 1]], most, message))
    for a, b in true_runs(stent):
        message = "a stent's metal: " + (
            "its bloom is taken off; calcium behind it may still count as lumen, so the area may be too large"
            if method == "psf_edge"
            else "its bloom counts as lumen, so the area is too large; psf_edge takes it off"
        )
        found.append(warning_entry("calcium_or_metal", tube, profile.s_mm[[a, b - 1]], 1.0, message))
    return found


def _fill_short_gaps(flags, s_mm):
    """flags (n,) with gaps shorter than LARGEST_GAP_MM filled."""
    flags = flags.copy()
    for a, b in true_runs(~flags):
        if a > 0 and b < len(flags) and s_mm[b] - s_mm[a - 1] < LARGEST_GAP_MM:
            flags[a:b] = True
    return flags


def _low_contrast(main, blood_hu, noise_hu):
    """Warns of noise and of faint blood, which make every edge uncertain."""
    contrast, reach, found = blood_hu - HEALTHY_WALL_HU, [0.0, main.axis.length_mm], []
    if contrast < DOUBTFUL_CONTRAST * noise_hu:
        message = (
            f"contrast over noise is {contrast / noise_hu:.1f} (blood {blood_hu:.0f} HU, noise {noise_hu:.0f}): below"
        )
        message += f" {DOUBTFUL_CONTRAST:g} radii are off by more than 0.06 mm; a softer kernel, or smoothing_fwhm_mm"
        found.append(warning_entry("noise", main, reach, float(contrast / noise_hu), message))
    if blood_hu < LOW_BLOOD_HU:
        message = f"blood has {blood_hu:.0f} HU only: what the wall differs from the {HEALTHY_WALL_HU:.0f} HU assumed"
        message += " moves the edge; at 180 HU a wall of 80 made radii 0.3 mm too large"
        found.append(warning_entry("faint_blood", main, reach, float(blood_hu), message))
    return found


def _widening(main):
    """Warns of a main vessel that is wider at its far end, since the end points may be in the wrong order."""
    areas = np.mean(main.radii_mm**2, axis=1)
    first, last = (
        np.sqrt(areas[at].mean()) for at in (main.s_mm < END_LENGTH_MM, main.s_mm > main.s_mm[-1] - END_LENGTH_MM)
    )
    if last <= WIDENING_RATIO * first:
        return []
    message = f"the far end is {last / first:.2f} times as wide as the inlet: are the end points in order, inlet first?"
    return [warning_entry("widens_from_the_inlet", main, main.s_mm[[0, -1]], float(last / first), message)]


def true_runs(flags):
    """[(start, stop)] of the stretches of True in flags (n,)."""
    edge = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return list(zip(edge[::2], edge[1::2]))


def warning_entry(code, tube, s_mm, value, message):
    """Entry of segmentation.json for a warning at s_mm (start, end). value: the figure that the warning is about."""
    start, end = float(s_mm[0]), float(s_mm[1])
    return {
        "code": code,
        "branch": tube.name,
        "s_start_mm": start,
        "s_end_mm": end,
        "value": value,
        "message": f"{tube.name} {start:.1f}-{end:.1f} mm: {message}",
    }


def _close_pairs(tubes):
    """Warns of vessels within 0.3 mm of each other, away from their branching: the image may have merged them."""
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
                    if gap < 0.3 and _are_far_along(first, second, k, other, radius):
                        near.append((k, gap))
                        break
            if near:
                at = first.s_mm[[near[0][0], near[-1][0]]]
                least = float(min(gap for _, gap in near))
                message = f"within {max(least, 0):.2f} mm of {second.name}: the image may have merged them; look there,"
                message += " and give a centreline if the axis changes the vessel"
                found.append(warning_entry("close_vessels", first, at, least, message))
    return found


def _are_far_along(first, second, k, other, radius):
    """Whether section k of the Tube `first` and section `other` of `second` are far from each other along the vessels.

    radius: radius of section k in mm.
    """
    if first is second:
        return second.s_mm[other] - first.s_mm[k] > 4 * radius + 4
    if second.parent == first.name:
        return second.s_mm[other] > 4 * radius + 2
    # Branches of one parent may start close to each other.
    return min(first.s_mm[k], second.s_mm[other]) > 4 * radius + 2
