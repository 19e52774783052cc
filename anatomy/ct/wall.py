"""Checks whether the tissue round the lumen has the CT number that `psf_edge` assumes of a healthy wall."""

import numpy as np
from scipy.interpolate import RectBivariateSpline
from scipy.optimize import curve_fit

from . import warnings
from .rays.edges import HEALTHY_WALL_HU, USUAL_SIGMA_MM
from .rays.stented import blurred_disc

OFFSETS_MM = np.arange(-0.8, 1.61, 0.05)  # from the edge outwards: through the wall and into the tissue behind it
WIDE_RADIUS_MM, FEWEST_SECTIONS = 1.1, 8  # least radius of the sections that are used, and their least number
# HU by which the fit finds walls too dark. On phantoms: 0 if voxels are small beside the blur, 16 if they add to it.
FIT_BIAS_HU = 8.0
# Start and bounds of the fit: sigma (mm), shift of the edge (mm), the wall's HU, its thickness (mm), HU behind it.
FIT_START, FIT_LOWER, FIT_UPPER = (
    (USUAL_SIGMA_MM, 0, 50, 0.7, -80),
    (0.1, -0.3, -150, 0.25, -250),
    (1.0, 0.3, 250, 2.0, 250),
)
DOUBTFUL_MM = 0.04  # expected error of the radius from which a warning is given; noise alone gives 0.02


def measured_wall_hu(profiles, radius, blood, clear):
    """CT number (HU) of the wall beside the lumen; None if it cannot be told.

    radius: (n, m) in mm. blood: its CT number. clear: (n,) of bool, the sections without calcium and metal. The model
    is a blurred lumen, a wall of unknown thickness and CT number, and one tissue of unknown CT number behind it. It is
    fitted to the median over all rays of the profiles across the edge. A chamber or a vein beside the vessel lies on
    fewer than half of the rays. In a mean over the rays it would look like a brighter or darker wall.
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
    """By how much (mm) radii are too large if the wall has wall_hu. On most phantoms this holds within 40 %."""
    return 0.5 * (wall_hu - HEALTHY_WALL_HU) / max(blood - wall_hu, 1.0)


def find_warnings(tube, profiles, bright, blood):
    """[warnings.warning_entry] if the tissue round the main vessel makes its radii wrong, else [].

    tube, profiles, bright: the vessel's Tube, its Profiles and the result of edges.find_calcium_and_stents().
    blood: CT number.
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
