"""The radius of a lumen found in an image, varied by the segmentation's error.

The study measures the error of its own segmentation, found minus true radius, in sections of CT images of known lumens
without a stent. data_synthetic/measured.md has it under "Lumens found in CT". So the true radius is the found one minus
the error. All sections get the same error, since this changes the pressure loss more than any other errors of this
size.
"""

import numpy as np

from common.errors import InputError
from whatif.flow_inputs import Input

BIAS_MM, SD_MM = 0.005, 0.012  # found minus true radius in six images with voxels of 0.35 mm
NAME = "lumen_radius"


def radius_input():
    """The Input "true minus found radius" in mm, from one standard deviation below its mean to one above."""
    return Input(NAME, "radius of the lumen found in CT, 1 SD", -BIAS_MM - SD_MM, 0.0, -BIAS_MM + SD_MM, "mm")


def stented(scene):
    """[(branch, start, end)] of the stented stretches of a scene, as arc lengths in mm."""
    found = []
    for step in scene["procedure"]:
        for use in step["devices"]:
            device = scene["devices"][use["device"]]
            if device["kind"] == "stent":
                half = device["length_mm"] / 2
                found.append((use["branch"], use["centre_s_mm"] - half, use["centre_s_mm"] + half))
    return found


def at_radius(lumen, off_mm, held=()):
    """(anatomy, sections) of a lumen whose radii are all `off_mm` larger, except in the stretches `held`.

    lumen: (anatomy.json, sections); held: as from `stented`. Raises InputError if a radius would not stay positive.
    """
    anatomy, sections = lumen
    if not off_mm:
        return lumen
    radius = np.sqrt(sections["area_mm2"].to_numpy(float) / np.pi)
    moved = np.ones(len(sections), bool)
    for branch, start, end in held:
        moved &= ~((sections["branch"] == branch) & sections["s_mm"].between(start, end)).to_numpy()
    radius[moved] += off_mm
    if radius.min() <= 0:
        raise InputError("no lumen is left", "radius of the lumen", f"{radius.min():.3g} mm", "a smaller error")
    return anatomy, sections.assign(area_mm2=np.pi * radius**2)
