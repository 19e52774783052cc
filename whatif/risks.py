"""What a plan asks of the vessel: width of balloons, stretch of the wall, what side branches lose of their mouths."""

import numpy as np
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp

# After angioplasty, emergency bypass surgery was needed in 1.7 % of the patients if the balloon's diameter was below
# 0.9 times the artery's, in 3.1 % from 0.9 to 1.1, and in 7.8 % above (Roubin et al., Circulation 1988; 78: 557-565;
# only the abstract was read). Those balloons were inflated without stents.
LARGEST_RATIO = 1.1
LEAST_EXPANSION, LARGEST_MALAPPOSITION_MM = 0.6, 0.4  # limits of the engine's warnings (vci/results/readouts.hpp)
STRETCH_PERCENTILE = 99  # percentile over the wall's points; the maximum may come from a single distorted triangle
MOUTH_MM = 5.0  # length of a side branch, from its first cross-section on, that plaque or carina may narrow


def named(ratio, expansion_index, malapposition_mm):
    """The risks (list of words) of a plan whose values are beyond a limit. A value that is None is beyond none.

    ratio: as balloon_to_artery returns it. expansion_index, malapposition_mm: of deployment.json.
    """
    beyond = {
        "oversized balloon": ratio is not None and ratio > LARGEST_RATIO,
        "stent not expanded": expansion_index is not None and expansion_index < LEAST_EXPANSION,
        "stent off the wall": malapposition_mm is not None and malapposition_mm > LARGEST_MALAPPOSITION_MM,
    }
    return [words for words, found in beyond.items() if found]


def balloon_to_artery(scene, sections):
    """The largest ratio of an inflated balloon's diameter to the healthy diameter of the artery, over all inflations.

    A balloon's diameter is that of its chart at the pressure of the step. A stent stands for the balloon that delivers
    it. The artery's diameter is the mean of `reference_diameter_mm` over the length of the device, or the value at the
    section next to its middle if no section is so near. With two balloons side by side each counts alone.

    scene: content of scene.json. sections: the table of sections.csv before the procedure. None if the procedure is
    empty.
    """
    devices = scene["devices"]
    ratios = [
        inflated_diameter(devices, use) / healthy_diameter(sections, use, devices[use["device"]]["length_mm"])
        for step in scene["procedure"]
        for use in step["devices"]
    ]
    return max(ratios, default=None)


def inflated_diameter(devices, use):
    """Diameter (mm) by the chart of a device, or of its delivery balloon, at the pressure of one use of it."""
    device = devices[use["device"]]
    chart = (device if device["kind"] == "balloon" else devices[device["balloon"]])["chart"]
    return float(np.interp(use["pressure_bar"], chart["pressure_bar"], chart["diameter_mm"]))


def healthy_diameter(sections, use, length_mm):
    """Mean healthy diameter (mm) of the artery along a device of length_mm at the place of one use of it."""
    own = sections[sections["branch"] == use["branch"]]
    away = (own["s_mm"] - use["centre_s_mm"]).abs()
    beside = own[away <= max(0.5 * length_mm, away.min())]
    return float(beside["reference_diameter_mm"].mean())


def wall_stretch(lumen_file):
    """The 99th percentile of the wall's largest principal stretch, over the points where the wall was moved."""
    poly = vtp.read(lumen_file, "made by `vci deploy`")
    stretch = vtk_to_numpy(poly.GetPointData().GetArray("wall_stretch"))
    moved = np.abs(vtk_to_numpy(poly.GetPointData().GetArray("displacement_mm"))).max(axis=-1) > 0
    return float(np.percentile(stretch[moved], STRETCH_PERCENTILE))


def side_branch_loss(branches, before, after):
    """How much narrower the mouth of a side branch is than before, in percent of its area; the largest over them.

    A stent shifts plaque or the carina into the mouth. A negative value: every mouth is wider than before. The mouth's
    area is the smallest over the first MOUTH_MM of the branch's cross-sections.

    branches: entry `branches` of anatomy.json. before, after: tables of sections.csv. None if no side branch has
    sections in both.
    """
    sides = [one["name"] for one in branches if one["parent"] is not None]
    mouths = [[mouth_area(table, name) for table in (before, after)] for name in sides]
    losses = [100 * (1 - new / old) for old, new in mouths if old and new]
    return max(losses, default=None)


def mouth_area(sections, branch):
    """Smallest area (mm2) over the first MOUTH_MM of a branch in the table of sections.csv; None without sections."""
    own = sections[(sections["branch"] == branch) & sections["area_mm2"].notna()]
    near = own[own["s_mm"] <= own["s_mm"].min() + MOUTH_MM]
    return float(near["area_mm2"].min()) if len(near) else None
