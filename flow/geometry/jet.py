"""Radius of the jet behind a narrowing, along a branch with the radius R(s):

    R_j(s) = min over t <= s of R(t) + spread (s - t)

At a throat the jet has the vessel's radius. Behind it the jet widens by `spread` mm per mm until it fills the vessel.
"""

import numpy as np


def jet_radius(branch, spread):
    """R_j (n,) in mm at the points of a geometry.centreline.Branch."""
    # R_j(s) - spread s is the running minimum of R(t) - spread t
    jet = np.minimum.accumulate(branch.radius_mm - spread * branch.s_mm) + spread * branch.s_mm
    return np.minimum(branch.radius_mm, jet)
