"""Jets behind narrowings: their radius along a branch, and the mixing length of their shear layers.

    R_j(s) = min over t <= s of R(t) + spread (s - t),    l_jet = R_j (1 - R_j / R)

R_j follows the throat's scale and widens slowly; l_jet is zero where no narrowing lies upstream and within the
throat itself, so that the eddy viscosity (c l_jet)^2 |D| acts on the free shear layer only.
"""

import numpy as np
from dolfinx import fem

from flow import compat

M_PER_MM = 1e-3


def jet_radius(branch, spread):
    """R_j in mm at the branch's centreline points (n,)."""
    # min_t<=s of R(t) + spread (s - t) is a running minimum of R - spread t
    jet = np.minimum.accumulate(branch.radius_mm - spread * branch.s_mm) + spread * branch.s_mm
    return np.minimum(branch.radius_mm, jet)


def mixing_length(space, tree, spread):
    """l_jet in m, constant in each cell of a LumenSpace: a Function."""
    length = []
    for branch in tree:
        jet = jet_radius(branch, spread)
        length.append(jet * (1.0 - jet / branch.radius_mm))
    points, cells = space.nodes()
    nearest, _ = tree.nearest(points[cells[:, :4]].mean(axis=1) / M_PER_MM)
    result = fem.Function(compat.function_space(space.mesh, compat.cellwise_element(space.mesh)))
    result.x.array[:] = M_PER_MM * np.concatenate(length)[nearest]
    return result
