"""The mixing length of the shear layers of jets behind narrowings (geometry.jet):

    l_jet = R_j (1 - R_j / R)

is zero where no narrowing lies upstream and within the throat itself, so that the eddy viscosity (c l_jet)^2 |D| acts
on the free shear layer only.
"""

import numpy as np
from dolfinx import fem

from flow.discretisation import compat
from flow.geometry.jet import jet_radius

M_PER_MM = 1e-3


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
