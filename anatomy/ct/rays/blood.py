"""The blood's CT number along each branch. It falls if the contrast has not filled the vessel evenly."""

import dataclasses

import numpy as np

from .edges import HEALTHY_WALL_HU, USUAL_SIGMA_MM

KNOTS_MM = 40.0  # between the corners of the trend: contrast changes over centimetres, lesions and calcium over less
WIDE_SIGMAS = (
    3.2  # radius over sigma of the point spread: in wider sections blur takes at most 1 % of the blood on the axis
)
LEAST_SLOPE_MM = 15.0  # length of wide sections that a slope needs; over less, contrast changes by less than its noise
LEAST_CONSTANT_MM = 2.0  # length of wide sections that even a constant needs
ROUNDS, SOFT_HU = 30, 3.0  # rounds of the fit; deviations below SOFT_HU are squared instead of taken absolute
TREND_RANGE = 0.5, 1.5  # of the median: a trend beyond this range has another cause than contrast


class Trend:
    """CT number of the blood along a branch: linear between knots at s_mm (k,), constant beyond them. hu: (k,)."""

    def __init__(self, s_mm, hu):
        self.s_mm, self.hu = np.atleast_1d(s_mm).astype(float), np.atleast_1d(hu).astype(float)

    def __call__(self, s_mm):
        """CT number (n,) at arc lengths (n,) in mm."""
        return np.interp(s_mm, self.s_mm, self.hu)


def fit_trend(s_mm, hu, use, fallback):
    """Trend fitted to the CT numbers hu (n,) at s_mm (n,) of the sections chosen by use (n,) of bool.

    The sum of the absolute deviations is least, as for a median. So lesions and calcium on less than about a quarter of
    the length hardly change it. If less than 15 mm are chosen, the Trend is their median. fallback: the Trend to
    return if less than 2 mm are chosen.
    """
    long_mm = use.sum() * (s_mm[1] - s_mm[0])
    if long_mm < LEAST_CONSTANT_MM:
        return fallback
    middle = float(np.median(hu[use]))
    if long_mm < LEAST_SLOPE_MM:
        return Trend(0.0, middle)
    knots = np.linspace(0, s_mm[-1], max(int(round(s_mm[-1] / KNOTS_MM)), 1) + 1)
    hats = np.stack([np.interp(s_mm, knots, row) for row in np.eye(len(knots))], axis=1)
    # A weak penalty on changes of slope determines the trend at knots without sections.
    stiff = np.diff(np.eye(len(knots)), 2, axis=0)
    left, values, weights = hats[use], hu[use] - middle, np.ones(int(use.sum()))
    for _ in range(ROUNDS):
        rows = np.concatenate([weights[:, None] * left, stiff])
        found = np.linalg.lstsq(rows, np.concatenate([weights * values, np.zeros(len(stiff))]), rcond=None)[0]
        weights = 1 / np.sqrt(np.maximum(np.abs(left @ found - values), SOFT_HU))
    return Trend(knots, np.clip(middle + found, TREND_RANGE[0] * middle, TREND_RANGE[1] * middle))


def first_trend(profiles):
    """Trend of the CT numbers on the axis before any radius is known. It relies on most of the vessel being wide."""
    constant = Trend(0.0, np.median(profiles.axis_hu))
    return fit_trend(profiles.s_mm, profiles.axis_hu, np.ones(len(profiles.s_mm), bool), constant)


def refined_trend(profiles, tube, fallback, sigma_mm=USUAL_SIGMA_MM):
    """Trend of the CT numbers on the axis where the vessel is wide, corrected for the blur by the point spread.

    profiles: as sampled. tube: the lumen found. fallback: the Trend to return if the branch is narrow or short.
    sigma_mm: standard deviation of the point spread.
    """
    radius_mm = tube.radius(profiles.s_mm)
    share = 1 - np.exp(-0.5 * (radius_mm / sigma_mm) ** 2)
    wide = radius_mm > WIDE_SIGMAS * sigma_mm
    hu = HEALTHY_WALL_HU + (profiles.axis_hu - HEALTHY_WALL_HU) / np.where(wide, share, 1.0)
    return fit_trend(profiles.s_mm, hu, wide, fallback)


def level_contrast(profiles, level, blood):
    """Profiles scaled as if the blood had the CT number `blood` all along; that of a healthy wall does not change.

    level: the branch's Trend.
    """
    scale = (blood - HEALTHY_WALL_HU) / np.maximum(level(profiles.s_mm) - HEALTHY_WALL_HU, 1.0)
    hu = HEALTHY_WALL_HU + (profiles.hu - HEALTHY_WALL_HU) * scale[:, None, None]
    axis = HEALTHY_WALL_HU + (profiles.axis_hu - HEALTHY_WALL_HU) * scale
    return dataclasses.replace(profiles, hu=hu, axis_hu=axis, gain=scale)
