"""The blood's CT number along each branch. It falls if the contrast has not filled the vessel evenly."""

import dataclasses

import numpy as np

from .edges import HEALTHY_WALL_HU, USUAL_SIGMA_MM

KNOTS_MM = 40.0  # distance of the trend's knots: contrast changes over centimetres, lesions and calcium are shorter
WIDE_SIGMAS = (
    3.2  # least radius of a wide section, in sigmas of the point spread: blur lowers the HU on its axis by 1 % at most
)
# A slope is fitted only if this length of the sections is wide. Over less, contrast changes by less than its noise.
LEAST_SLOPE_MM = 15.0
LEAST_CONSTANT_MM = 2.0  # with less length of wide sections not even a constant is fitted
ROUNDS, SOFT_HU = 30, 3.0  # rounds of reweighting; smaller deviations than SOFT_HU count by their square
TREND_RANGE = 0.5, 1.5  # limits of the trend over its median; what lies beyond them is not caused by contrast


class Trend:
    """CT number of the blood along a branch: hu (k,) at knots s_mm (k,), linear between and constant beyond them."""

    def __init__(self, s_mm, hu):
        self.s_mm, self.hu = np.atleast_1d(s_mm).astype(float), np.atleast_1d(hu).astype(float)

    def __call__(self, s_mm):
        """CT number (n,) at arc lengths (n,) in mm."""
        return np.interp(s_mm, self.s_mm, self.hu)


def fit_trend(s_mm, hu, use, fallback):
    """Trend fitted to the CT numbers hu (n,) at s_mm (n,) of the sections chosen by use (n,) of bool.

    The sum of the absolute deviations is minimised, as by a median. So lesions and calcium on less than about a quarter
    of the length hardly change the Trend. If less than 15 mm are chosen, the Trend is constant, at their median. If
    less than 2 mm are chosen, the Trend `fallback` is returned.
    """
    long_mm = use.sum() * (s_mm[1] - s_mm[0])
    if long_mm < LEAST_CONSTANT_MM:
        return fallback
    middle = float(np.median(hu[use]))
    if long_mm < LEAST_SLOPE_MM:
        return Trend(0.0, middle)
    knots = np.linspace(0, s_mm[-1], max(int(round(s_mm[-1] / KNOTS_MM)), 1) + 1)
    hats = np.stack([np.interp(s_mm, knots, row) for row in np.eye(len(knots))], axis=1)
    # Without chosen sections near a knot the fit leaves its value open. A weak penalty on changes of slope fixes it.
    stiff = np.diff(np.eye(len(knots)), 2, axis=0)
    left, values, weights = hats[use], hu[use] - middle, np.ones(int(use.sum()))
    for _ in range(ROUNDS):
        rows = np.concatenate([weights[:, None] * left, stiff])
        found = np.linalg.lstsq(rows, np.concatenate([weights * values, np.zeros(len(stiff))]), rcond=None)[0]
        weights = 1 / np.sqrt(np.maximum(np.abs(left @ found - values), SOFT_HU))
    return Trend(knots, np.clip(middle + found, TREND_RANGE[0] * middle, TREND_RANGE[1] * middle))


def first_trend(profiles):
    """Trend of the CT numbers on the axis, fitted before any radius is known.

    All sections are used. This relies on most of the vessel being wide.
    """
    constant = Trend(0.0, np.median(profiles.axis_hu))
    return fit_trend(profiles.s_mm, profiles.axis_hu, np.ones(len(profiles.s_mm), bool), constant)


def refined_trend(profiles, tube, fallback, sigma_mm=USUAL_SIGMA_MM):
    """Trend of the CT numbers on the axis where the vessel is wide, corrected for the blur by the point spread.

    profiles: Profiles as sampled. tube: the Tube found so far. fallback: the Trend to return if the branch is narrow or
    short. sigma_mm: standard deviation of the point spread.
    """
    radius_mm = tube.radius(profiles.s_mm)
    share = 1 - np.exp(-0.5 * (radius_mm / sigma_mm) ** 2)
    wide = radius_mm > WIDE_SIGMAS * sigma_mm
    hu = HEALTHY_WALL_HU + (profiles.axis_hu - HEALTHY_WALL_HU) / np.where(wide, share, 1.0)
    return fit_trend(profiles.s_mm, hu, wide, fallback)


def level_contrast(profiles, level, blood):
    """Profiles with the contrast scaled as if the blood had the CT number `blood` all along the branch.

    level: the branch's Trend. The CT number of a healthy wall is kept.
    """
    scale = (blood - HEALTHY_WALL_HU) / np.maximum(level(profiles.s_mm) - HEALTHY_WALL_HU, 1.0)
    hu = HEALTHY_WALL_HU + (profiles.hu - HEALTHY_WALL_HU) * scale[:, None, None]
    axis = HEALTHY_WALL_HU + (profiles.axis_hu - HEALTHY_WALL_HU) * scale
    return dataclasses.replace(profiles, hu=hu, axis_hu=axis, gain=scale)
