"""A smoother field through nodal values: cubic or quadratic polynomials fitted to the patch round each corner.

Superconvergent patch recovery of Zienkiewicz and Zhu 1992, Int J Numer Meth Engng 33, applied to the values as in
dual-weighted residuals (Becker and Rannacher 2001, Acta Numerica 10). The patch of a corner is the cells that meet
there. A polynomial is fitted by least squares to the values at the patch's nodes. At a node of the richer element the
polynomials of its cells' corners are averaged. Patches with equal numbers of nodes and targets are fitted together.
"""

import numpy as np
import scipy.sparse


EXPONENTS = np.array([[i, j, k] for i in range(4) for j in range(4 - i) for k in range(4 - i - j)])
TERMS = {degree: EXPONENTS[EXPONENTS.sum(axis=1) <= degree] for degree in (2, 3)}
PLENTY = 1.5  # times the polynomial's terms: with fewer nodes the patch is enlarged by the cells beside it
# Singular values below this share of the largest are dropped. In a lattice a patch may have too few levels of nodes for
# a cubic. A singular value is then 0 but for rounding, 1e-7 to 1e-5, and its inverse would make spikes of 1e4.
NEGLIGIBLE = 1e-3
AT_ONCE = 1_000_000  # numbers in an array of the patches that are fitted together; bounds the memory


class Patches:
    """The patches of a mesh of quadratic tetrahedra: nodes (n, 3), cells (t, 10)."""

    def __init__(self, nodes, cells):
        self.nodes, self.corner = nodes, cells[:, :4]
        corners, number = np.unique(self.corner, return_inverse=True)
        self.cells_at = _incidence(number.reshape(-1, 4), len(corners)).T.tocsr()  # (corners, cells)

    def recover(self, fields, wanted=None):
        """[values (m, k) at targets] of fields [(degree, sources (t, a), values (n, k), targets (m, 3), of (t, b))].

        sources: the cells' nodes at which `values` are known; of: numbers of the targets in each cell. wanted: the only
        cells whose targets' values the caller uses; the values at other targets may be wrong.
        """
        patches, found = self._own(wanted), []
        for degree, sources, values, targets, of in fields:
            width, entries, held = values.shape[1], [], 0
            sums, counts = np.zeros((len(targets), width)), np.zeros(len(targets))
            for near, at in self._alike(patches, degree, sources, of, len(targets), width):
                known, at_targets, inverse = _fitted(self.nodes[near], targets[at], TERMS[degree])
                fitted = at_targets @ (inverse @ (known.transpose(0, 2, 1) @ values[near]))
                entries.append((at.ravel(), fitted.reshape(-1, width)))
                held += fitted.size
                if held > AT_ONCE:
                    _add(sums, counts, entries)
                    entries, held = [], 0
            _add(sums, counts, entries)
            found.append(sums / np.maximum(counts, 1)[:, None])
        return found

    def transposed(self, fields, groups):
        """The transposed of `recover`, applied to loads at the targets and summed by groups of targets.

        fields: [(degree, sources (t, a), loads (m, c), targets (m, 3), of (t, b), group (m,))]. For each field it gives
        a list over c of sparse matrices (n, groups). A column times nodal values (n,) is the sum, over the targets of
        that group, of load times recovered value.
        """
        patches, found = self._own(), []
        for degree, sources, loads, targets, of, group in fields:
            components, entries = loads.shape[1], []
            shared = loads / self._counts(of, len(loads))[:, None]
            for near, at in self._alike(patches, degree, sources, of, len(targets), components):
                known, at_targets, inverse = _fitted(self.nodes[near], targets[at], TERMS[degree])
                # one column for each pair of a patch and a group that has targets in it
                number = (np.arange(len(at))[:, None] * groups + group[at]).ravel()
                order = np.argsort(number, kind="stable")
                pairs, first = np.unique(number[order], return_index=True)
                patch, of_group = pairs // groups, pairs % groups
                weighted = (at_targets[..., None] * shared[at][:, :, None]).reshape(at.size, -1)
                moments = np.add.reduceat(weighted[order], first).reshape(len(pairs), -1, components)
                entries.append((near[patch], of_group, known[patch] @ (inverse[patch] @ moments)))
            found.append(self._matrices(entries, groups, components))
        return found

    def _own(self, wanted=None):
        """Sparse (patches, cells) matrix of all patches, or of those that reach the cells `wanted`."""
        patches = self.cells_at
        if wanted is not None:
            beside = np.isin(self.corner, self.corner[wanted]).any(axis=1)
            patches = patches[np.flatnonzero(patches @ beside.astype(np.int32))]
        return patches

    def _alike(self, patches, degree, sources, of, targets, components):
        """Yields (nodes (p, n), targets (p, m)) of patches with equal numbers of source nodes and of targets.

        A patch with too few nodes for the degree is enlarged by the cells beside it. components: numbers at each
        target, which bound how many patches are yielded at once.
        """
        terms = len(TERMS[degree])
        sources, at = _incidence(sources, len(self.nodes)), _ascending(patches @ _incidence(of, targets))
        near = _ascending(patches @ sources)
        few = np.diff(near.indptr) < PLENTY * terms
        if few.any():
            beside = patches[few] @ self.cells_at.T @ self.cells_at
            near = scipy.sparse.vstack([near[~few], _ascending(beside @ sources)])
            at = scipy.sparse.vstack([at[~few], at[few]])
        sizes, kind = np.unique(np.stack([np.diff(near.indptr), np.diff(at.indptr)]), axis=1, return_inverse=True)
        order, ends = np.argsort(kind, kind="stable"), np.cumsum(np.bincount(kind))
        for (nodes, count), same in zip(sizes.T, np.split(order, ends[:-1])):
            step = max(1, AT_ONCE // (terms * max(nodes, count * components)))
            for first in range(0, len(same), step):
                chosen = same[first : first + step]
                yield _rows(near, chosen, nodes), _rows(at, chosen, count)

    def _counts(self, of, count):
        """Number (count,) of the patches that each target lies in."""
        return np.bincount((self.cells_at @ _incidence(of, count)).indices, minlength=count)

    def _matrices(self, entries, groups, components):
        """List over components of sparse (n, groups) matrices, the sums of entries [(nodes (p, n), groups (p,), values
        (p, n, components))]."""
        size = len(self.nodes), groups
        rows = np.concatenate([near.ravel() for near, *_ in entries])
        columns = np.concatenate([np.repeat(of_group, near.shape[1]) for near, of_group, _ in entries])
        values = np.concatenate([block.reshape(-1, components) for *_, block in entries])
        return [scipy.sparse.csr_matrix((one, (rows, columns)), size) for one in values.T]


def _add(sums, counts, entries):
    """Adds entries [(numbers (n,), values (n, k))] to sums (m, k), and their occurrences to counts (m,), in place."""
    if not entries:
        return
    at, values = (np.concatenate(parts) for parts in zip(*entries))
    pairs = at, np.arange(len(at))
    sums += scipy.sparse.csr_matrix((np.ones(len(at)), pairs), (len(sums), len(at))) @ values
    counts += np.bincount(at, minlength=len(counts))


def _incidence(lists, count):
    """Sparse (t, count) with a one for each of lists (t, a) of numbers below `count`."""
    starts = np.arange(len(lists) + 1) * lists.shape[1]
    return scipy.sparse.csr_matrix((np.ones(lists.size, np.int32), lists.ravel(), starts), (len(lists), count))


def _ascending(matrix):
    """A sparse matrix with the columns of each row in ascending order."""
    matrix.sort_indices()
    return matrix


def _rows(matrix, chosen, size):
    """Column numbers (p, size) of the entries in the rows `chosen` (p,), each of which has `size` entries."""
    return matrix.indices[matrix.indptr[chosen][:, None] + np.arange(size)]


def _fitted(points, targets, terms):
    """(A, B, C) of p patches: monomials A (p, n, t) at the points (p, n, 3) and B (p, m, t) at the targets (p, m, 3).

    C (p, t, t) is the pseudo-inverse of A^T A. Values v at the points give B C A^T v at the targets.
    """
    middle = points.mean(axis=1, keepdims=True)
    off = points - middle
    # scaled along the patch's principal axes, since cells are several times longer than wide
    square, axes = np.linalg.eigh(off.transpose(0, 2, 1) @ off)
    turn = axes / np.sqrt(np.maximum(square / points.shape[1], 1e-300))[:, None]
    known, wanted = _monomials(off @ turn, terms), _monomials((targets - middle) @ turn, terms)
    square, vectors = np.linalg.eigh(known.transpose(0, 2, 1) @ known)  # squares of the singular values, ascending
    telling = square > NEGLIGIBLE**2 * square[:, -1:]
    inverse = np.where(telling, 1.0 / np.where(telling, square, 1.0), 0.0)
    return known, wanted, (vectors * inverse[:, None]) @ vectors.transpose(0, 2, 1)


def _monomials(x, terms):
    """Monomials (p, n, t) with exponents `terms` (t, 3) of coordinates x (p, n, 3)."""
    powers = np.ones((4,) + x.shape)
    for degree in range(1, 4):
        powers[degree] = powers[degree - 1] * x
    found = np.empty(x.shape[:2] + (len(terms),))
    for k, (i, j, m) in enumerate(terms):
        found[..., k] = powers[i, ..., 0] * powers[j, ..., 1] * powers[m, ..., 2]
    return found
