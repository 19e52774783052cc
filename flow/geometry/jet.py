"""Jets behind narrowings: their radius along a branch.

    R_j(s) = min over t <= s of R(t) + spread (s - t)

R_j follows the throat's scale and widens slowly.
"""

import numpy as np


def jet_radius(branch, spread):
    """R_j in mm at the branch's centreline points (n,)."""
    # min_t<=s of R(t) + spread (s - t) is a running minimum of R - spread t
    jet = np.minimum.accumulate(branch.radius_mm - spread * branch.s_mm) + spread * branch.s_mm
    return np.minimum(branch.radius_mm, jet)
