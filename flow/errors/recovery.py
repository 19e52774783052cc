"""Recovers a smoother field from nodal values, by cubic or quadratic polynomials fitted to the patch round each corner.

Superconvergent patch recovery of Zienkiewicz and Zhu 1992, Int J Numer Meth Engng 33. Here it is applied to the values
of a field, as for dual-weighted residuals (Becker and Rannacher 2001, Acta Numerica 10). The patch of a corner is the
set of cells that meet there. A polynomial is fitted by least squares to the values at the patch's nodes. The recovered
field is wanted at targets, the nodes of a higher-order element. At a target the polynomials of all patches in which it
lies are averaged. Patches with equal numbers of nodes and of targets are fitted together, in one array operation.
"""

import numpy as np
import scipy.sparse


# Exponents of the monomials in three coordinates, up to degree 3, and those up to degree 2 and 3.
EXPONENTS = np.array([[i, j, k] for i in range(4) for j in range(4 - i) for k in range(4 - i - j)])
TERMS = {degree: EXPONENTS[EXPONENTS.sum(axis=1) <= degree] for degree in (2, 3)}
PLENTY = 1.5  # a patch with fewer nodes than this times the polynomial's terms is enlarged by the neighbouring cells
# Singular values of a fit below this share of the largest are dropped. In a swept mesh a patch may have too few layers
# of nodes for a cubic. A singular value is then 0 but for rounding, 1e-7 to 1e-5. Its inverse would make spikes of 1e4.
NEGLIGIBLE = 1e-3
AT_ONCE = 1_000_000  # numbers in an array of patches that are fitted together; it limits the memory


class Patches:
    """The patches of a mesh of quadratic tetrahedra with nodes (n, 3) and cells (t, 10), as geometry.tet10."""

    def __init__(self, nodes, cells):
        self.nodes, self.corner = nodes, cells[:, :4]
        corners, number = np.unique(self.corner, return_inverse=True)
        self.cells_at = _incidence(number.reshape(-1, 4), len(corners)).T.tocsr()  # (corners, cells)

    def recover(self, fields, wanted=None):
        """[recovered values (m, k) at the targets] of the given fields.

        fields: [(degree, sources (t, a), values (n, k), targets (m, 3), of (t, b))]. degree: of the polynomials;
        sources: numbers of the nodes in each cell at which `values` are known; targets: points; of: numbers of the
        targets in each cell. wanted: numbers of cells. If given, only the values at their targets are right.
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
        """The transpose of `recover`, applied to loads at the targets, for each group of targets by itself.

        fields: [(degree, sources (t, a), loads (m, c), targets (m, 3), of (t, b), group (m,))], as in `recover`; group:
        number of each target's group, below `groups`. The result is for each field a list over c of sparse matrices
        (n, groups). A column times nodal values (n,) is the sum, over the targets of that group, of load times
        recovered value.
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
        """Sparse (patches, cells) matrix: which cells each patch has. wanted: only patches with a cell that touches
        one of these cells (numbers)."""
        patches = self.cells_at
        if wanted is not None:
            beside = np.isin(self.corner, self.corner[wanted]).any(axis=1)
            patches = patches[np.flatnonzero(patches @ beside.astype(np.int32))]
        return patches

    def _alike(self, patches, degree, sources, of, targets, components):
        """Yields (nodes (p, n), targets (p, m)) of patches with equal numbers of source nodes and of targets.

        patches: of `_own`; degree, sources, of: as in `recover`; targets: their number; components: numbers at each
        target. A patch with too few nodes for the degree is enlarged by the neighbouring cells. AT_ONCE limits how many
        patches are yielded at once.
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
        """Number of patches in which each target lies, (count,); of (t, b): targets of each cell; count: of targets."""
        return np.bincount((self.cells_at @ _incidence(of, count)).indices, minlength=count)

    def _matrices(self, entries, groups, components):
        """[sparse (n, groups) matrix] for each component, the sum of all entries.

        entries: [(node numbers (p, a), group numbers (p,), values (p, a, components))].
        """
        size = len(self.nodes), groups
        rows = np.concatenate([near.ravel() for near, *_ in entries])
        columns = np.concatenate([np.repeat(of_group, near.shape[1]) for near, of_group, _ in entries])
        values = np.concatenate([block.reshape(-1, components) for *_, block in entries])
        return [scipy.sparse.csr_matrix((one, (rows, columns)), size) for one in values.T]


def _add(sums, counts, entries):
    """Adds entries [(row numbers (n,), values (n, k))] to the rows of sums (m, k), in place.

    counts (m,) gets the number of values added to each row.
    """
    if not entries:
        return
    at, values = (np.concatenate(parts) for parts in zip(*entries))
    pairs = at, np.arange(len(at))
    sums += scipy.sparse.csr_matrix((np.ones(len(at)), pairs), (len(sums), len(at))) @ values
    counts += np.bincount(at, minlength=len(counts))


def _incidence(lists, count):
    """Sparse (t, count) matrix: row i has a one in each of the columns lists[i], for lists (t, a) of column numbers."""
    starts = np.arange(len(lists) + 1) * lists.shape[1]
    return scipy.sparse.csr_matrix((np.ones(lists.size, np.int32), lists.ravel(), starts), (len(lists), count))


def _ascending(matrix):
    """A sparse matrix with the columns of each row in ascending order."""
    matrix.sort_indices()
    return matrix


def _rows(matrix, chosen, size):
    """Column numbers (p, size) of the entries in the rows `chosen` (p,) of a sparse matrix; each has `size` entries."""
    return matrix.indices[matrix.indptr[chosen][:, None] + np.arange(size)]


def _fitted(points, targets, terms):
    """(A, B, C) of the least-squares fits in p patches: values v at the points give B C A^T v at the targets.

    A (p, n, t) are the monomials with the exponents `terms` (t, 3) at the points (p, n, 3), B (p, m, t) those at the
    targets (p, m, 3). C (p, t, t) is the pseudo-inverse of A^T A.
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
