"""A smoother field through nodal values: cubic or quadratic polynomials fitted to the patch round each corner.

Round every corner of the mesh a polynomial is fitted by least squares to the values at the nodes of the cells that meet
there; at a node of the richer element the polynomials of its cells' corners are averaged. (Superconvergent patch
recovery of Zienkiewicz and Zhu 1992, Int J Numer Meth Engng 33, applied to the values as in dual-weighted residuals:
Becker and Rannacher 2001, Acta Numerica 10.)
"""

import numpy as np
import scipy.sparse

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

    def recover(self, fields, wanted=None):
        """[(m, k) values at `targets`] of fields [(degree, sources (t, a), values (n, k), targets (m, 3), of (t, b))].

        sources: the cells' nodes at which `values` are known; of: the numbers of the targets that lie in each cell.
        wanted: cells in which alone the targets' values count; the others' are left undone.
        """
        sums = [np.zeros((len(targets), values.shape[1])) for _, _, values, targets, _ in fields]
        counts = [np.zeros(len(targets)) for *_, targets, _ in fields]
        for cells in self._own(wanted):
            beside = None
            for k, (degree, sources, values, targets, of) in enumerate(fields):
                near, beside = self._near(cells, beside, sources, TERMS[degree])
                at = _members(of[cells])
                sums[k][at] += _fitted(self.nodes[near], values[near], targets[at], TERMS[degree])
                counts[k][at] += 1
        counts = [np.maximum(parallel.total(count), 1) for count in counts]
        return [parallel.total(values) / count[:, None] for values, count in zip(sums, counts)]

    def transposed(self, fields, groups):
        """What `recover` of unknown nodal values, weighted with loads at the targets and summed by groups, depends on:
        for each of fields [(degree, sources (t, a), loads (m, c), targets (m, 3), of (t, b), group (m,))] the list over
        c of sparse matrices (n, groups), whose product with values (n,) at the nodes is that sum."""
        entries, counts = [[] for _ in fields], [self._counts(of, len(loads)) for _, _, loads, _, of, _ in fields]
        for cells in self._own():
            beside = None
            for k, (degree, sources, loads, targets, of, group) in enumerate(fields):
                near, beside = self._near(cells, beside, sources, TERMS[degree])
                at = _members(of[cells])
                present = np.unique(group[at])
                within = group[at][:, None] == present
                shared = (loads[at] / counts[k][at][:, None])[:, None] * within[..., None]
                back = _fitted_transposed(self.nodes[near], targets[at], TERMS[degree], shared.reshape(len(at), -1))
                entries[k].append((near, present, back.reshape(len(near), len(present), -1)))
        return [self._summed(found, groups, field[2].shape[1]) for found, field in zip(entries, fields)]

    def _own(self, wanted=None):
        """The patches, by their cells, that are this rank's; only those that reach the cells `wanted`."""
        if wanted is None:
            patches = list(self.cells_at.values())
        else:
            beside = np.isin(self.corner, self.corner[wanted]).any(axis=1)
            patches = [self.cells_at[corner] for corner in np.unique(self.corner[beside])]
        return patches[slice(*parallel.share(len(patches)))]

    def _near(self, cells, beside, sources, terms):
        """(nodes of a patch's sources, enough for so many terms; the cells beside it where they were needed)."""
        near = _members(sources[cells])
        if len(near) < PLENTY * len(terms):
            if beside is None:
                beside = np.concatenate([self.cells_at[corner] for corner in _members(self.corner[cells])])
            near = _members(sources[beside])
        return near, beside

    def _counts(self, of, count):
        """Number (count,) of the patches that each target lies in."""
        pairs = np.repeat(of, 4, axis=1).ravel(), np.tile(self.corner, of.shape[1]).ravel()
        ones = scipy.sparse.csr_matrix((np.ones(len(pairs[0])), pairs), (count, len(self.nodes)))
        return np.diff(ones.indptr)

    def _summed(self, entries, groups, components):
        """List over components of sparse (n, groups) over all ranks; entries [(nodes, groups, values (n, g, c))]."""
        rows = np.concatenate([np.repeat(near, len(present)) for near, present, _ in entries])
        columns = np.concatenate([np.tile(present, len(near)) for near, present, _ in entries])
        values = np.concatenate([block.reshape(-1, components) for *_, block in entries])
        size = len(self.nodes), groups
        return [parallel.total(scipy.sparse.csr_matrix((one, (rows, columns)), size)) for one in values.T]


def _members(lists):
    """Ascending, each once: np.unique without its overhead."""
    found = np.sort(lists, axis=None)
    return found[np.concatenate([[True], found[1:] != found[:-1]])]


def _bases(points, targets, terms):
    """Monomials (n, terms) at points (n, 3) of a patch and (m, terms) at targets (m, 3)."""
    middle = points.mean(axis=0)
    # in the patch's own directions and lengths: cells are several times longer than wide
    _, size, axes = np.linalg.svd(points - middle, full_matrices=False)
    turn = axes.T / np.maximum(size / np.sqrt(len(points)), 1e-300)
    return _monomials((points - middle) @ turn, terms), _monomials((targets - middle) @ turn, terms)


def _fitted(points, values, targets, terms):
    """Values (m, k) at targets (m, 3) of the polynomial fitted to values (n, k) at points (n, 3)."""
    known, wanted = _bases(points, targets, terms)
    return wanted @ np.linalg.lstsq(known, values, rcond=NEGLIGIBLE)[0]


def _fitted_transposed(points, targets, terms, loads):
    """(n, k) whose product with values at points (n, 3) is that of loads (m, k) with what `_fitted` makes of them."""
    known, wanted = _bases(points, targets, terms)
    return np.linalg.lstsq(known.T, wanted.T @ loads, rcond=NEGLIGIBLE)[0]


def _monomials(x, terms):
    """(n, terms) of coordinates x (n, 3)."""
    powers = np.ones((4,) + x.T.shape)
    for degree in range(1, 4):
        powers[degree] = powers[degree - 1] * x.T
    return (powers[terms[:, 0], 0] * powers[terms[:, 1], 1] * powers[terms[:, 2], 2]).T
