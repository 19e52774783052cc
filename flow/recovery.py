"""A smoother field through nodal values: cubic or quadratic polynomials fitted to the patch round each corner.

Round every corner of the mesh a polynomial is fitted by least squares to the values at the nodes of the cells that meet
there; at a node of the richer element the polynomials of its cells' corners are averaged. (Superconvergent patch
recovery of Zienkiewicz and Zhu 1992, Int J Numer Meth Engng 33, applied to the values as in dual-weighted residuals:
Becker and Rannacher 2001, Acta Numerica 10.)
"""

import numpy as np

from flow import parallel

EXPONENTS = np.array([[i, j, k] for i in range(4) for j in range(4 - i) for k in range(4 - i - j)])
TERMS = {degree: EXPONENTS[EXPONENTS.sum(axis=1) <= degree] for degree in (2, 3)}
PLENTY = 1.5  # times the polynomial's terms: with fewer nodes the patch is enlarged by the cells beside it
# Singular values below this share say nothing about the polynomial. In a lattice a patch may have too few levels of
# nodes for a cubic: exactly so it is 0, with rounded coordinates 1e-7 to 1e-5, which would make spikes of 1e4.
NEGLIGIBLE = 1e-3


class Patches:
    """The cells (t, 10) of quadratic tetrahedra with nodes (n, 3), by the corners that they share."""

    def __init__(self, nodes, cells):
        self.nodes, self.corner = nodes, cells[:, :4]
        order = np.argsort(self.corner, axis=None, kind="stable")
        self.corners, first = np.unique(self.corner.ravel()[order], return_index=True)
        self.cells_at = dict(zip(self.corners, np.split(order // 4, first[1:])))

    def recover(self, fields):
        """[(m, k) values at `targets`] of fields [(degree, sources (t, a), values (n, k), targets (m, 3), of (t, b))].

        sources: the cells' nodes at which `values` are known; of: the numbers of the targets that lie in each cell.
        """
        sums = [np.zeros((len(targets), values.shape[1])) for _, _, values, targets, _ in fields]
        counts = [np.zeros(len(targets)) for *_, targets, _ in fields]
        patches = list(self.cells_at.values())
        for cells in patches[slice(*parallel.share(len(patches)))]:
            beside = None
            for k, (degree, sources, values, targets, of) in enumerate(fields):
                terms = TERMS[degree]
                near = _members(sources[cells])
                if len(near) < PLENTY * len(terms):
                    if beside is None:
                        beside = np.concatenate([self.cells_at[corner] for corner in _members(self.corner[cells])])
                    near = _members(sources[beside])
                at = _members(of[cells])
                sums[k][at] += _fitted(self.nodes[near], values[near], targets[at], terms)
                counts[k][at] += 1
        return [parallel.total(values) / parallel.total(count)[:, None] for values, count in zip(sums, counts)]


def _members(lists):
    """Ascending, each once: np.unique without its overhead."""
    found = np.sort(lists, axis=None)
    return found[np.concatenate([[True], found[1:] != found[:-1]])]


def _fitted(points, values, targets, terms):
    """Values (m, k) at targets (m, 3) of the polynomial fitted to values (n, k) at points (n, 3)."""
    middle = points.mean(axis=0)
    # in the patch's own directions and lengths: cells are several times longer than wide
    _, size, axes = np.linalg.svd(points - middle, full_matrices=False)
    turn = axes.T / np.maximum(size / np.sqrt(len(points)), 1e-300)
    coefficients = np.linalg.lstsq(_monomials((points - middle) @ turn, terms), values, rcond=NEGLIGIBLE)[0]
    return _monomials((targets - middle) @ turn, terms) @ coefficients


def _monomials(x, terms):
    """(n, terms) of coordinates x (n, 3)."""
    powers = np.ones((4,) + x.T.shape)
    for degree in range(1, 4):
        powers[degree] = powers[degree - 1] * x.T
    return (powers[terms[:, 0], 0] * powers[terms[:, 1], 1] * powers[terms[:, 2], 2]).T
