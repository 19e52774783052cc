"""The radius of a lumen found in an image, varied by the segmentation's error.

The study measures the error of its own segmentation, which is found minus true radius. It does so in sections of CT
images of known lumens without a stent (data_synthetic/measured.md, "Lumens found in CT"). So the true radius is the
found one minus the error. All sections get the same error, since this changes the pressure loss more than any other
errors of this size.
"""

import numpy as np

from common.errors import InputError
from whatif.flow_inputs import Input

RADIUS_BIAS_MM, RADIUS_SD_MM = 0.005, 0.012  # found minus true radius in six images with voxels of 0.35 mm
RADIUS_INPUT = "lumen_radius"


def radius_input():
    """The Input "true minus found radius" in mm, from one standard deviation below the mean to one above it."""
    return Input(
        RADIUS_INPUT,
        "radius of the lumen found in CT, 1 SD",
        -RADIUS_BIAS_MM - RADIUS_SD_MM,
        0.0,
        -RADIUS_BIAS_MM + RADIUS_SD_MM,
        "mm",
    )


def stented_spans(scene):
    """[(branch, start, end)] of the stented stretches of a scene, as arc lengths in mm."""
    spans = []
    for step in scene["procedure"]:
        for use in step["devices"]:
            device = scene["devices"][use["device"]]
            if device["kind"] == "stent":
                half = device["length_mm"] / 2
                spans.append((use["branch"], use["centre_s_mm"] - half, use["centre_s_mm"] + half))
    return spans


def with_radius_change(lumen, change_mm, unchanged_spans=()):
    """(anatomy, sections) of a lumen whose radii are all `change_mm` larger, except in the stretches `unchanged_spans`.

    lumen: (anatomy.json, sections); unchanged_spans: result of `stented_spans`. Raises InputError if a radius would not
    stay positive.
    """
    anatomy, sections = lumen
    if not change_mm:
        return lumen
    radius = np.sqrt(sections["area_mm2"].to_numpy(float) / np.pi)
    changed = np.ones(len(sections), bool)
    for branch, start, end in unchanged_spans:
        changed &= ~((sections["branch"] == branch) & sections["s_mm"].between(start, end)).to_numpy()
    radius[changed] += change_mm
    if radius.min() <= 0:
        raise InputError("no lumen is left", "radius of the lumen", f"{radius.min():.3g} mm", "a smaller error")
    return anatomy, sections.assign(area_mm2=np.pi * radius**2)
