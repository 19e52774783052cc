"""Finds the lumen's edge along rays perpendicular to an axis."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import RectBivariateSpline
from scipy.ndimage import minimum_filter, uniform_filter, uniform_filter1d
from scipy.optimize import curve_fit
from scipy.signal import savgol_filter
from scipy.special import chndtr, i0e

from . import calcified
from . import stented as stents

STEP_MM = 0.05  # distance between the samples of a ray
REACH_MM = 4.0  # length of a ray
# The tissue is measured between these distances beyond the edge: in the wall, past most of the blur of the blood.
WALL_SAMPLE_MM = (0.35, 0.55)
USUAL_SIGMA_MM = 0.315  # sigma of the point spread for which this window was chosen
MEASURED_WALL_WEIGHT, HEALTHY_WALL_HU = (
    0.75,  # weight of the measured tissue; the rest of the weight goes to a healthy wall
    50.0,  # CT number of a healthy wall
)
LARGEST_WALL_SHARE = (
    0.45  # tissue beside the lumen counts as at most this share of the blood's HU: calcium and metal are not tissue
)
# Calcium and metal are brighter than BRIGHT_RATIO times the blood. They also exceed the blood by BRIGHT_DEVIATIONS
# standard deviations of its noise.
BRIGHT_RATIO, BRIGHT_DEVIATIONS = 1.15, 4.0
# Calcium and metal are sought within BRIGHT_REACH_MM of the axis. A section is in a stent if more than STENT_SHARE of
# its rays are bright.
BRIGHT_REACH_MM, STENT_SHARE = 3.0, 0.5
MM_PER_DEGREE = 10.0  # the polynomial subtracted to find the noise gets one degree more for each such length of vessel
BLOOD_SHARE = 0.85  # a section's axis shows blood if its CT number is above this share of the blood's
CORE_MM = 0.4  # within this distance of the axis a section shows blood alone
BLOOMING_MM = 0.6  # calcium within this distance beyond an edge moves the edge by its blur
# Sections this near to a stent's end are measured as stented. Blurred metal is visible there, and the filter along the
# axis would spread the error.
STENT_BLUR_MM = 0.5
OUTLIER_RATIO = 1.35  # rays longer than this times the section's usual radius run into a side branch or a neighbour
FILTER_MM = 2.25  # window of the cubic filter along the axis: it does not bias lesions longer than about 4 mm
HARMONICS = 4  # smooth_radii() keeps this many harmonics of the radius round a section


@dataclass
class Profiles:
    """CT numbers of one branch in sections across its axis.

    hu (n, m, k): CT numbers at arc lengths s_mm (n,), angles theta (m,) in radians and distances r_mm (k,) from the
    axis. axis_hu (n,): CT numbers on the axis. gain (n,): factor by which blood.level_contrast() has multiplied the
    contrast, and with it the noise.
    """

    s_mm: np.ndarray
    theta: np.ndarray
    r_mm: np.ndarray
    hu: np.ndarray
    axis_hu: np.ndarray
    gain: np.ndarray = None

    def __post_init__(self):
        self.gain = np.ones(len(self.s_mm)) if self.gain is None else self.gain

    def sections_from(self, first):
        """The sections from number `first` on."""
        rest = {name: getattr(self, name)[first:] for name in ("s_mm", "hu", "axis_hu", "gain")}
        return replace(self, **rest)


def sample(hu_at, axis, spacing_mm, rays):
    """Profiles along `rays` rays round the axis, in sections about spacing_mm apart from end to end.

    hu_at: function of points (..., 3) in mm that gives the image's HU.
    """
    count = max(int(round(axis.length_mm / spacing_mm)), 12) + 1
    s = np.linspace(0, axis.length_mm, count)
    theta = np.linspace(0, 2 * np.pi, rays, endpoint=False)
    r = np.arange(0, REACH_MM, STEP_MM)
    _, normal, binormal = axis.frame(s)
    ray = np.cos(theta)[None, :, None] * normal[:, None] + np.sin(theta)[None, :, None] * binormal[:, None]
    points = axis.point(s)[:, None, None] + r[None, None, :, None] * ray[:, :, None]
    hu = hu_at(points)
    # A small disc is averaged and filtered along the axis. Otherwise noise would make dark spots like occlusions.
    centre = hu[:, :, : int(0.2 / STEP_MM) + 1].mean(axis=(1, 2))
    return Profiles(s, theta, r, hu, smooth_along(centre, s, 1.25))


def smooth_along(values, s_mm, window_mm=FILTER_MM, derivative=0):
    """values (n, ...) at s_mm (n,) after a cubic Savitzky-Golay filter along the axis, or their derivative by s."""
    step = s_mm[1] - s_mm[0]
    window = min(2 * int(round(0.5 * window_mm / step)) + 1, (len(s_mm) - 1) // 2 * 2 + 1)
    if window < 5:
        return values if derivative == 0 else np.zeros_like(values)
    return savgol_filter(values, window, 3, deriv=derivative, delta=step, axis=0, mode="interp")


def first_fall(hu, r_mm, level, start_mm=0.0):
    """Radius (n, m) in mm at which each ray hu (n, m, k) first falls below level (n, m) beyond start_mm (n, m).

    It is interpolated linearly; nan if the ray never falls below the level.
    """
    below = (hu[:, :, 1:] < level[:, :, None]) & (hu[:, :, :-1] >= level[:, :, None])
    below &= r_mm[None, None, 1:] > np.asarray(start_mm)[..., None]
    found = below.any(axis=2)
    k = np.argmax(below, axis=2)
    high = np.take_along_axis(hu, k[..., None], 2)[..., 0]
    low = np.take_along_axis(hu, k[..., None] + 1, 2)[..., 0]
    share = (high - level) / np.where(high > low, high - low, 1.0)
    radius = r_mm[k] + share * (r_mm[1] - r_mm[0])
    # If the axis itself is below the level, the radius is 0.
    return np.where(found, radius, np.where(hu[:, :, 0] < level, 0.0, np.nan))


def noise_hu(hu, profiles, blood):
    """Noise in HU: standard deviation of hu (n, m, k) near the axis of sections whose axis shows blood.

    Two other changes must not count as noise: a slow change along the vessel, and the fall away from the axis that blur
    causes in narrow lumens. So a polynomial of the arc length is subtracted at each distance from the axis. Its degree
    is 1, and 1 more for each 10 mm of vessel.
    """
    s, core = _core(hu, profiles, blood)
    if len(s) < 8:
        return 0.0
    degree = 1 + int((s[-1] - s[0]) / MM_PER_DEGREE)
    slow = np.stack([np.polynomial.Polynomial.fit(s, ring, degree)(s) for ring in core.mean(axis=1).T], axis=1)
    return _deviation(core - slow[:, None, :])


def unevenness_hu(hu, profiles, blood):
    """Standard deviation in HU of the CT numbers near the axis from a straight line along the vessel.

    It contains the noise, steps of the contrast along the vessel, and the blur.
    """
    s, core = _core(hu, profiles, blood)
    if len(s) < 8:
        return 0.0
    slow = np.polyval(np.polyfit(s, profiles.axis_hu[profiles.axis_hu > BLOOD_SHARE * blood], 1), s)
    return _deviation(core - slow[:, None, None])


def _core(hu, profiles, blood):
    """(arc lengths (n,), hu (n, m, k) within CORE_MM of the axis) of the sections whose axis shows blood."""
    wide = profiles.axis_hu > BLOOD_SHARE * blood
    return profiles.s_mm[wide], hu[wide][:, :, : int(CORE_MM / STEP_MM) + 1]


def _deviation(values):
    # 1.4826 median deviations are the standard deviation of a normal distribution; outliers hardly change them.
    return 1.4826 * float(np.median(np.abs(values)))


def find_calcium_and_stents(profiles, blood, stented=False):
    """(calcium (n, m), radius (n, m), stent (n,)): which rays meet calcium, where, and which sections are in a stent.

    radius: distance in mm from the axis at which the ray meets calcium, infinite if it meets none. A bright place has
    more than BRIGHT_RATIO times the blood's CT number. It also exceeds the blood by BRIGHT_DEVIATIONS standard
    deviations. Both are judged after averaging over some samples in each direction. Bright places are calcium or metal.
    They are taken for a stent where most rays of neighbouring sections are bright, but only if `stented`: calcium all
    round may look the same.
    """
    smooth = uniform_filter(profiles.hu, (3, 3, 5), mode=("nearest", "wrap", "nearest"))
    # Steps of the contrast along the vessel count as unevenness. So blood behind a step does not pass for calcium.
    uneven = unevenness_hu(smooth, profiles, blood)
    level = np.maximum(BRIGHT_RATIO * blood, blood + BRIGHT_DEVIATIONS * uneven * profiles.gain)
    above = (smooth > level[:, None, None]) & (profiles.r_mm < BRIGHT_REACH_MM)
    met = above.any(axis=2)
    stent = stented & (uniform_filter1d(met.mean(axis=1), 9, mode="nearest") > STENT_SHARE)
    calcium = met & ~stent[:, None]
    return calcium, np.where(calcium, profiles.r_mm[np.argmax(above, axis=2)], np.inf), stent


def near_stent(stent, s_mm):
    """(n,) of bool: sections in a stent or within STENT_BLUR_MM of its ends, where blurred metal is still visible."""
    reach = int(round(STENT_BLUR_MM / (s_mm[1] - s_mm[0])))
    return uniform_filter1d(stent.astype(float), 2 * reach + 1, mode="nearest") > 0.5 / (2 * reach + 1)


def replace_outliers(radius):
    """(radii (n, m), replaced (n, m) of bool): radii on rays into side branches, and missing radii (nan), are replaced.

    They are interpolated from the other rays of the section. If too few others are left, all rays of the section get
    its usual radius. This is the median over the section, but at most OUTLIER_RATIO times the median over neighbouring
    sections.
    """
    n, m = radius.shape
    filled = np.where(np.isnan(radius), np.inf, radius)
    own = np.median(filled, axis=1)
    usual = np.array([np.median(own[max(i - 6, 0) : i + 7]) for i in range(n)])
    usual = np.minimum(own, OUTLIER_RATIO * usual)
    bad = ~(filled < OUTLIER_RATIO * usual[:, None] + 0.1)
    result = radius.copy()
    for i in np.flatnonzero(bad.any(axis=1)):
        good = np.flatnonzero(~bad[i])
        if len(good) < m // 4:
            result[i] = usual[i]
        else:
            result[i] = np.interp(np.arange(m), good, radius[i, good], period=m)
    return result, bad


def smooth_radii(radius, s_mm):
    """Radii (n, m), smoothed by HARMONICS harmonics round the section and by the cubic filter along the axis."""
    waves = np.fft.rfft(radius, axis=1)
    waves[:, HARMONICS + 1 :] = 0
    return smooth_along(np.fft.irfft(waves, radius.shape[1], axis=1), s_mm)


def tissue_hu(profiles, radius, blood, sigma_mm=None, calcium=False):
    """CT number (n, m) in HU of the tissue just beyond the edge, smoothed over neighbours.

    It is the mean between 0.35 and 0.55 mm beyond the edge at radius (n, m). Blur adds some blood there. Behind a
    healthy wall it adds about as much fat, which is dark, so both cancel. Behind thick plaque there is no fat to cancel
    the blood. The result is at most LARGEST_WALL_SHARE of the blood's CT number. Rays that meet calcium (n, m) get the
    CT number of a healthy wall.

    With sigma_mm the window is scaled by the point spread. The result is then moved by a quarter towards the CT number
    of a healthy wall. This reduces the error by the missing fat to 4 HU. It was measured on noise-free tubes with a
    wall of 0.7 mm and plaque up to 1.1 mm.
    """
    scale = 1.0 if sigma_mm is None else sigma_mm / USUAL_SIGMA_MM
    distance = profiles.r_mm - radius[..., None]
    inside = (distance > scale * WALL_SAMPLE_MM[0]) & (distance < scale * WALL_SAMPLE_MM[1])
    level = (profiles.hu * inside).sum(axis=2) / np.maximum(inside.sum(axis=2), 1)
    level = np.where(calcium, HEALTHY_WALL_HU, np.clip(level, -0.3 * blood, LARGEST_WALL_SHARE * blood))
    waves = np.fft.rfft(level, axis=1)
    waves[:, 3:] = 0
    level = smooth_along(np.fft.irfft(waves, level.shape[1], axis=1), profiles.s_mm, 1.5)
    if sigma_mm is not None:
        level = MEASURED_WALL_WEIGHT * level + (1 - MEASURED_WALL_WEIGHT) * HEALTHY_WALL_HU
    return np.clip(level, -0.3 * blood, LARGEST_WALL_SHARE * blood)


def edge_share(radius_mm, sigma_mm):
    """Share of the contrast that is left at the edge of a disc of radius_mm (R) blurred by a Gaussian of sigma_mm.

    It is 1/2 (1 - exp(-x) I0(x)) with x = (R / sigma)^2: 1/2 for a straight edge, less in a narrow vessel.
    """
    return 0.5 * (1 - i0e((np.asarray(radius_mm) / sigma_mm) ** 2))


def edges_before_calcium(profiles, blood, calcium, sigma_mm):
    """Radii (n, m) in mm of the lumen's edge on rays that meet calcium (n, m), by calcified.fit(); nan on others."""
    hu = uniform_filter(profiles.hu, (3, 3, 1), mode=("nearest", "wrap", "nearest"))[calcium]
    radius = np.full(calcium.shape, np.nan)
    radius[calcium] = calcified.fit(hu, profiles.r_mm, blood, HEALTHY_WALL_HU, sigma_mm)
    return radius


def find_edges(profiles, method, blood, sigma_mm=None, stented=False, rounds=4):
    """(radii (n, m) in mm, replaced (n, m) of bool) of the lumen's edge in one branch.

    replaced: result of replace_outliers(). method: how the edge is found. blood: the blood's CT number. sigma_mm:
    standard deviation of the point spread. rounds: number of iterations between edges and tissue. On rays that meet
    calcium near the edge, blood and calcium are fitted together, with a usual point spread if sigma_mm is not given.

    - half_maximum: the edge has the mean of two CT numbers, on the axis and of the tissue beyond the edge. In a stent
    the metal counts as lumen, as in a clinical reading, so the area is too large.
    - psf_edge: the edge is at the level between tissue and blood that a blurred tube as wide as the section has at its
    true edge. Then the blur along the axis is corrected to first order, r - sigma^2 / 2 r''(s). In a stent the bloom is
    removed (stented.fit).
    """
    n, m, _ = profiles.hu.shape
    hu, (_, place, stent) = np.minimum(profiles.hu, BRIGHT_RATIO * blood), find_calcium_and_stents(
        profiles, blood, stented
    )
    metal = near_stent(stent, profiles.s_mm)
    place = minimum_filter(place, 3, mode=("nearest", "wrap"))  # the blur reaches the rays beside calcium
    place[stent] = np.inf
    inner = edges_before_calcium(profiles, blood, np.isfinite(place) & ~metal[:, None], sigma_mm or USUAL_SIGMA_MM)
    tissue = np.full((n, m), 0.15 * blood)
    share, top = 0.5, np.minimum(profiles.axis_hu, 1.1 * blood)[:, None]
    if method == "psf_edge":
        top = blood
    radius = None
    for _ in range(rounds):
        level = tissue + share * (top - tissue)
        fall = first_fall(hu, profiles.r_mm, np.broadcast_to(level, (n, m)))
        calcium = np.isfinite(place) & ~(place > fall + BLOOMING_MM)
        radius, bad = replace_outliers(np.where(calcium, inner, fall))
        radius = smooth_radii(radius, profiles.s_mm)
        tissue = tissue_hu(profiles, radius, blood, sigma_mm if method == "psf_edge" else None, calcium)
        if method == "psf_edge":
            mean = np.maximum(np.sqrt(np.mean(np.maximum(radius, 0) ** 2, axis=1)), 0.3 * sigma_mm)
            share = edge_share(mean, sigma_mm)[:, None]
    if method == "psf_edge":
        if stent.any():
            reach = radius[metal].max() + 0.3
            struts = stents.fit(profiles.hu[metal], profiles.r_mm, blood, HEALTHY_WALL_HU, sigma_mm, reach)
            radius[metal] = replace_outliers(struts)[0]
            radius = smooth_radii(radius, profiles.s_mm)
        bend = smooth_along(radius.mean(axis=1), profiles.s_mm, 1.5 * FILTER_MM, derivative=2)
        radius = radius - 0.5 * sigma_mm**2 * np.clip(bend, -0.6, 0.6)[:, None]
    return np.maximum(radius, 0.1), bad


def point_spread(profiles, radius, blood):
    """Sigma (mm) of the image's point spread, a Gaussian.

    The sections used are wide and free of calcium and metal; with fewer than eight of them the result is None. Their
    profiles across the edges are averaged. T + (B - T) x (blurred disc of their mean radius, moved by delta) is fitted
    over sigma and delta. B is the blood's CT number. T is fixed at that of a healthy wall: with T free, the fat behind
    the wall would increase sigma.
    """
    steep = find_calcium_and_stents(profiles, blood)[0].any(axis=1)  # calcium and metal steepen the edge
    steep = uniform_filter1d(steep.astype(float), 9, mode="nearest") > 0.05
    wide = np.flatnonzero((radius.mean(axis=1) > 1.1) & ~steep)
    if len(wide) < 8:
        return None
    offset = np.arange(-0.8, 0.151, 0.05)
    rays = np.arange(len(profiles.theta))
    mean = np.zeros(len(offset))
    for i in wide:
        section = RectBivariateSpline(rays, profiles.r_mm, profiles.hu[i], kx=1, ky=3)
        mean += section.ev(rays[:, None], radius[i][:, None] + offset[None]).mean(axis=0) / len(wide)
    centre = radius[wide].mean()

    def blurred_disc(at, sigma, delta):
        share = chndtr((centre / sigma) ** 2, 2, ((centre + at - delta) / sigma) ** 2)
        return HEALTHY_WALL_HU + (blood - HEALTHY_WALL_HU) * share

    found, _ = curve_fit(blurred_disc, offset, mean, [USUAL_SIGMA_MM, 0.0], bounds=([0.08, -0.3], [1.0, 0.3]))
    return float(found[0])
