"""How wide a plan's balloons are, compared with the healthy artery round them."""

import numpy as np

# After angioplasty, emergency bypass surgery was needed in 1.7 % of the patients if the balloon's diameter was below
# 0.9 times the artery's, in 3.1 % from 0.9 to 1.1, and in 7.8 % above (Roubin et al., Circulation 1988; 78: 557-565;
# only the abstract was read). Those balloons were inflated without stents.
LARGEST_RATIO = 1.1


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
