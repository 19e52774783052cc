"""The lumen's edge in a blooming stent: a blurred edge plus a blurred thin shell of metal, fitted on each ray."""

import numpy as np
from scipy.special import chndtr, i0e

INNER_MM, OUTER_MM = 0.8, 0.35  # fitted stretch inside and outside the edge; fat behind the wall hardly affects it
STEP_MM = 0.02
STRUT_CENTRE_MM = 0.04  # struts of usual thickness lie this far inside the wall


def disc(r_mm, radius_mm, sigma_mm):
    """Unit disc blurred by a Gaussian, at distances r_mm from its centre."""
    return chndtr((radius_mm / sigma_mm) ** 2, 2, (r_mm / sigma_mm) ** 2)


def shell(r_mm, radius_mm, sigma_mm):
    """Thin ring of radius_mm blurred by a Gaussian, scaled to a maximum of 1 for a wide ring."""
    blur = np.exp(-0.5 * ((r_mm - radius_mm) / sigma_mm) ** 2) * i0e(r_mm * radius_mm / sigma_mm**2)
    return blur * np.sqrt(2 * np.pi) * radius_mm / sigma_mm


def fit(hu, r_mm, blood, tissue, sigma_mm, largest_mm):
    """Radii (n, m) mm of rays hu (n, m, k) at r_mm (k,): least squares over (R, M >= 0) of

    I(r) = T + (B - T) disc(r; R) + M shell(r; R - 0.04), both blurred by sigma,

    B blood, T tissue (HU), M the metal's blurred peak. R is searched in steps of 0.02 mm up to largest_mm and refined
    by the parabola through the best three.
    """
    candidates = np.arange(0.6, largest_mm, STEP_MM)
    errors = np.empty((len(candidates),) + hu.shape[:2])
    for number, radius in enumerate(candidates):
        inside = (r_mm > radius - INNER_MM) & (r_mm < radius + OUTER_MM)
        r = r_mm[inside]
        rest = hu[..., inside] - tissue - (blood - tissue) * disc(r, radius, sigma_mm)
        ring = shell(r, radius - STRUT_CENTRE_MM, sigma_mm)
        metal = np.maximum(rest @ ring / (ring @ ring), 0)
        errors[number] = np.mean((rest - metal[..., None] * ring) ** 2, axis=-1)
    best = np.clip(np.argmin(errors, axis=0), 1, len(candidates) - 2)
    low, mid, high = (np.take_along_axis(errors, (best + step)[None], 0)[0] for step in (-1, 0, 1))
    bow = low - 2 * mid + high
    shift = np.where(bow > 0, 0.5 * (low - high) / np.where(bow > 0, bow, 1.0), 0.0)
    return candidates[best] + STEP_MM * np.clip(shift, -0.5, 0.5)
