"""Fields from a coarser mesh of the same lumen to this one, and residuals back (the transposed)."""

import numpy as np
import scipy.sparse

from flow.discretisation import compat
from flow.geometry import locate, tet10

AT_ONCE = 20000  # points located together


class Transfer:
    """velocity, pressure: CSR matrices that take nodal values of `coarse` to those of `fine`, both LumenSpaces."""

    def __init__(self, coarse, fine):
        points, cells = fine.nodes()
        coarse_points, coarse_cells = coarse.nodes()
        locator = locate.Locator(coarse_points, coarse_cells)
        found = [locator.find(points[k : k + AT_ONCE])[:2] for k in range(0, len(points), AT_ONCE)]
        cell, lam = (np.concatenate(part) for part in zip(*found))
        self.velocity = _matrix(tet10.basis(lam), coarse_cells[cell], len(coarse_points))
        node = np.empty(len(fine.q_map), int)
        node[compat.cell_dofs(fine.Q)] = cells[:, :4]
        order = np.empty(len(coarse_points), int)
        order[coarse_cells[:, :4]] = compat.cell_dofs(coarse.Q)
        corner = order[coarse_cells[cell[node]][:, :4]]
        self.pressure = _matrix(lam[node], corner, len(coarse.q_map))


def _matrix(values, columns, size):
    """CSR matrix with values (n, k) at columns (n, k) of `size`."""
    rows = np.arange(len(values) + 1) * values.shape[1]
    return scipy.sparse.csr_matrix((values.ravel(), columns.ravel().astype(np.int32), rows), (len(values), size))
