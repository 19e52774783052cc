"""The lumen's edge in a stent that blooms. A blurred lumen and a blurred thin ring of metal are fitted on each ray."""

import numpy as np
from scipy.special import chndtr, i0e

# A ray is fitted from INNER_MM inside the edge to OUTER_MM outside it. So fat behind the wall hardly affects the fit.
INNER_MM, OUTER_MM = 0.8, 0.35
STEP_MM = 0.02  # step of the radii that are tried
STRUT_CENTRE_MM = 0.04  # distance from the wall inwards to the middle of a strut of usual thickness


def blurred_disc(r_mm, radius_mm, sigma_mm):
    """Value at distances r_mm from the centre of a disc of value 1, of radius_mm, blurred by a Gaussian of sigma_mm."""
    return chndtr((radius_mm / sigma_mm) ** 2, 2, (r_mm / sigma_mm) ** 2)


def blurred_ring(r_mm, radius_mm, sigma_mm):
    """Value at distances r_mm from the centre of a thin ring of radius_mm, blurred by a Gaussian of sigma_mm.

    It is scaled so that the maximum of a wide ring is 1.
    """
    blur = np.exp(-0.5 * ((r_mm - radius_mm) / sigma_mm) ** 2) * i0e(r_mm * radius_mm / sigma_mm**2)
    return blur * np.sqrt(2 * np.pi) * radius_mm / sigma_mm


def fit(hu, r_mm, blood, tissue, sigma_mm, largest_mm):
    """Lumen radii (n, m) in mm on rays with CT numbers hu (n, m, k) at distances r_mm (k,) from the axis.

    This model is fitted to each ray by least squares over R and M >= 0, and its R is returned.

    I(r) = T + (B - T) blurred_disc(r; R) + M blurred_ring(r; R - 0.04).

    B and T are the CT numbers of blood and tissue, M is the height of the metal's blurred peak. R is searched in steps
    of 0.02 mm up to largest_mm and refined by the parabola through the best three errors.
    """
    candidates = np.arange(0.6, largest_mm, STEP_MM)
    errors = np.empty((len(candidates),) + hu.shape[:2])
    for number, radius in enumerate(candidates):
        inside = (r_mm > radius - INNER_MM) & (r_mm < radius + OUTER_MM)
        r = r_mm[inside]
        rest = hu[..., inside] - tissue - (blood - tissue) * blurred_disc(r, radius, sigma_mm)
        ring = blurred_ring(r, radius - STRUT_CENTRE_MM, sigma_mm)
        metal = np.maximum(rest @ ring / (ring @ ring), 0)
        errors[number] = np.mean((rest - metal[..., None] * ring) ** 2, axis=-1)
    best = np.clip(np.argmin(errors, axis=0), 1, len(candidates) - 2)
    low, mid, high = (np.take_along_axis(errors, (best + step)[None], 0)[0] for step in (-1, 0, 1))
    bow = low - 2 * mid + high
    shift = np.where(bow > 0, 0.5 * (low - high) / np.where(bow > 0, bow, 1.0), 0.0)
    return candidates[best] + STEP_MM * np.clip(shift, -0.5, 0.5)
