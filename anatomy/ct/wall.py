"""Checks whether the tissue round the lumen has the CT number that `psf_edge` assumes for a healthy wall."""

import numpy as np
from scipy.interpolate import RectBivariateSpline
from scipy.optimize import curve_fit

from . import warnings
from .rays.edges import HEALTHY_WALL_HU, USUAL_SIGMA_MM
from .rays.stented import blurred_disc

OFFSETS_MM = np.arange(-0.8, 1.61, 0.05)  # from the edge outwards, through the wall into the tissue behind it
WIDE_RADIUS_MM, FEWEST_SECTIONS = 1.1, 8  # least radius of the sections used, and their least number
# The fit finds walls too dark by about this. On phantoms the error was 0 HU with voxels small beside the blur, and
# 16 HU with voxels that add to the blur.
FIT_BIAS_HU = 8.0
# Start and bounds of the fit: sigma (mm), shift of the edge (mm), the wall's HU, its thickness (mm), HU behind it.
FIT_START, FIT_LOWER, FIT_UPPER = (
    (USUAL_SIGMA_MM, 0, 50, 0.7, -80),
    (0.1, -0.3, -150, 0.25, -250),
    (1.0, 0.3, 250, 2.0, 250),
)
DOUBTFUL_MM = 0.04  # a warning is given from this expected error of the radius on; noise alone gives 0.02 mm


def measured_wall_hu(profiles, radius, blood, clear):
    """CT number (HU) of the wall beside the lumen; None if it cannot be told.

    radius (n, m): radii of the lumen in mm. blood: CT number of the blood. clear (n,): whether a section is free of
    calcium and metal. A model is fitted: a blurred lumen, a wall of unknown thickness and CT number, and one tissue of
    unknown CT number behind it. It is fitted to the median over all rays of the profiles across the edge. A chamber or
    a vein beside the vessel lies on fewer than half of the rays, so the median ignores it. In a mean it would look like
    a brighter or darker wall.
    """
    wide = np.flatnonzero((radius.mean(axis=1) > WIDE_RADIUS_MM) & clear)
    if len(wide) < FEWEST_SECTIONS:
        return None
    rays, seen, centre = np.arange(len(profiles.theta)), [], radius[wide].mean()
    for i in wide:
        section = RectBivariateSpline(rays, profiles.r_mm, profiles.hu[i], kx=1, ky=3)
        seen.append(section.ev(rays[:, None], radius[i][:, None] + OFFSETS_MM[None]))
    usual = np.median(seen, axis=(0, 1))

    def wall_profile(at, sigma, shift, wall, thickness, behind):
        lumen = blurred_disc(centre + at, centre + shift, sigma)
        return (
            behind
            + (wall - behind) * blurred_disc(centre + at, centre + shift + thickness, sigma)
            + (blood - wall) * lumen
        )

    try:
        found, _ = curve_fit(wall_profile, OFFSETS_MM, usual, FIT_START, bounds=(FIT_LOWER, FIT_UPPER))
    except RuntimeError:
        return None
    return float(found[2]) + FIT_BIAS_HU


def expected_error_mm(wall_hu, blood):
    """Expected error (mm) of the radii if the wall has the CT number wall_hu; positive if they are too large.

    blood: CT number of the blood. On most phantoms the result is right to 40 %.
    """
    return 0.5 * (wall_hu - HEALTHY_WALL_HU) / max(blood - wall_hu, 1.0)


def find_warnings(tube, profiles, bright, blood):
    """[warnings.warning_entry] if the tissue round the main vessel makes its radii wrong, else [].

    tube, profiles, bright: the vessel's Tube, its Profiles and its result of edges.find_calcium_and_stents(). blood: CT
    number of the blood.
    """
    clear = ~(bright[0].any(axis=1) | bright[2])
    wall = measured_wall_hu(profiles, tube.radii_mm, blood, clear)
    error = 0.0 if wall is None else expected_error_mm(wall, blood)
    if abs(error) < DOUBTFUL_MM:
        return []
    area = 200 * abs(error) / float(tube.radii_mm.mean())
    message = (
        f"beside the lumen there are about {wall:.0f} HU, and psf_edge assumes {HEALTHY_WALL_HU:.0f}: radii are too"
        f" {'large' if error > 0 else 'small'} by about {abs(error):.2f} mm, the area by {area:.0f} %, since blood"
        f" has {blood:.0f} HU; a scan with brighter blood depends on it less; half_maximum does not assume it, but"
        " makes throats too narrow: one of 0.83 mm by 0.1 mm"
    )
    return [warnings.warning_entry("wall_brightness", tube, [0.0, tube.axis.length_mm], wall, message)]
