"""Places of a span's cross-sections: close at a throat, wider along its jet, far apart where the vessel is healthy."""

import numpy as np

# The largest radius within this distance is found upstream and downstream of a place. The smaller of the two is the
# healthy radius there.
NEIGHBOURHOOD_MM = 20.0
# Shares of the healthy radius: a vessel is a throat up to THROAT_SHARE, and plain, without a narrowing, from
# HEALTHY_SHARE on.
THROAT_SHARE, HEALTHY_SHARE = 0.75, 0.95
# Growth of the distance of sections before a throat and behind it, in mm per mm, for setting stations_plain = 1.
GROWTH_BEFORE, GROWTH_BEHIND = 0.3, 0.06
LARGEST_TURN_RAD = 0.35  # rad: largest turn of the axis from one section to the next
STEP_MM = 0.05  # step of the numerical integration along the axis by which the sections are placed


def station_spacing(branch, settings, s_mm):
    """Wanted distance in mm between sections at arc lengths s_mm (n,) of a branch.

    Let R be the radius at a point and q its fraction of the healthy radius. The distance is R times `stations_throat`
    for q <= 0.75 and R times `stations_plain` for q >= 0.95, but less in a bend. Behind a throat it grows slowly along
    the jet.
    """
    radius = branch.radius_mm
    share = np.clip((healthy_share(branch) - THROAT_SHARE) / (HEALTHY_SHARE - THROAT_SHARE), 0, 1)
    own = radius * (settings.stations_throat + share * (settings.stations_plain - settings.stations_throat))
    own = np.minimum(own, LARGEST_TURN_RAD / np.maximum(_curvature(branch), 1e-9))
    gap = s_mm[:, None] - branch.s_mm
    slope = settings.stations_plain * np.where(gap > 0, GROWTH_BEHIND, GROWTH_BEFORE)
    return np.min(own + slope * np.abs(gap), axis=1)


def healthy_share(branch):
    """Radius over the healthy radius, (n,), at the branch's points."""
    upstream = _running_maximum(branch.s_mm, branch.radius_mm, -1)
    return branch.radius_mm / np.minimum(upstream, _running_maximum(branch.s_mm, branch.radius_mm, 1))


def _running_maximum(s, radius, direction):
    """Largest radius (n,) within NEIGHBOURHOOD_MM of each s, downstream (direction 1) or upstream (-1)."""
    inside = (direction * (s - s[:, None]) >= 0) & (np.abs(s - s[:, None]) <= NEIGHBOURHOOD_MM)
    return np.max(np.where(inside, radius, 0.0), axis=1)


def _curvature(branch):
    """Curvature (n,) in 1/mm of the branch's axis."""
    slope = np.gradient(branch.points, branch.s_mm, axis=0)
    slope /= np.linalg.norm(slope, axis=1)[:, None]
    return np.linalg.norm(np.gradient(slope, branch.s_mm, axis=0), axis=1)


def place_stations(branch, settings, start_mm, end_mm, coarsening=1.0):
    """Arc lengths (k,) in mm of the sections from start_mm to end_mm inclusive, at least three.

    Their distance is `coarsening` times `station_spacing`.
    """
    return spread_by_gap(start_mm, end_mm, lambda s: coarsening * station_spacing(branch, settings, s), 2)


def spread_by_gap(start_mm, end_mm, gap_mm, least):
    """Arc lengths (k,) in mm from start_mm to end_mm inclusive, with at least `least` gaps between them.

    gap_mm: function of arc lengths (n,) in mm that gives the wanted gap (n,) in mm at each.
    """
    s = np.linspace(start_mm, end_mm, max(2, int(np.ceil((end_mm - start_mm) / STEP_MM)) + 1))
    density = 1.0 / gap_mm(s)
    count = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(s))])
    gaps = max(least, int(np.ceil(count[-1])))
    found = np.interp(np.linspace(0, count[-1], gaps + 1), count, s)
    found[0], found[-1] = start_mm, end_mm
    return found
