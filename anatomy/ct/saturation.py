"""Warns of blood at the image's highest CT number: then a display's window has cut off higher values."""

import numpy as np
from scipy.ndimage import uniform_filter1d

from . import warnings

# Blood counts as cut off if more than LEAST_SHARE of the axis points within STRETCH_MM have the image's highest CT
# number. Without such a cut, noise lets hardly a voxel reach the highest number.
STRETCH_MM, LEAST_SHARE = 5.0, 0.5
SAME_HU = 1.0  # voxels this little below the highest number count too: resampling after the cut lowers some


def find_warnings(image, tubes):
    """[warnings.warning_entry] for the stretches of the Tubes in which the blood has the Image's highest CT number."""
    top, found = float(image.values.max()), []
    for tube in tubes:
        places = np.rint((tube.axis.point(tube.s_mm) - image.origin_mm) / image.spacing_mm).astype(int)
        places = np.clip(places, 0, np.array(image.values.shape) - 1)
        flat = (image.values[tuple(places.T)] > top - SAME_HU).astype(float)
        width = max(int(round(STRETCH_MM / (tube.s_mm[1] - tube.s_mm[0]))), 1)
        for a, b in warnings.true_runs(uniform_filter1d(flat, width, mode="nearest") > LEAST_SHARE):
            message = (
                f"blood has the image's highest CT number, {top:.0f} HU, all over: a display's window seems to have cut"
                " it off. Radii are too large, by 0.1 mm to 0.2 mm for 400 HU cut to 300 or 240; export the image"
                " without a window (an image without any noise looks like this too)"
            )
            found.append(warnings.warning_entry("saturated", tube, tube.s_mm[[a, b - 1]], top, message))
    return found
