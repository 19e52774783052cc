"""Recovers a smoother field from nodal values, by cubic or quadratic polynomials fitted to the patch round each corner.

Superconvergent patch recovery of Zienkiewicz and Zhu 1992, Int J Numer Meth Engng 33. Here it is applied to the values
of a field, as for dual-weighted residuals (Becker and Rannacher 2001, Acta Numerica 10). The patch of a corner is the
set of cells that meet there. A polynomial is fitted by least squares to the values at the patch's nodes. The recovered
field is wanted at targets, the nodes of a higher-order element. Its value there is the mean over the polynomials of all
patches that contain the target. Patches with equal numbers of nodes and of targets are fitted in one array operation.
"""

import numpy as np
import scipy.sparse


# Exponents of the monomials in three coordinates: up to degree 3, and in TERMS up to degree 2 and up to degree 3.
EXPONENTS = np.array([[i, j, k] for i in range(4) for j in range(4 - i) for k in range(4 - i - j)])
TERMS = {degree: EXPONENTS[EXPONENTS.sum(axis=1) <= degree] for degree in (2, 3)}
LEAST_NODES_PER_TERM = (
    1.5  # a patch with fewer nodes than this times the polynomial's terms is enlarged by the neighbouring cells
)
# Singular values of a fit below this share of the largest are dropped. In a swept mesh a patch may have too few layers
# of nodes for a cubic. Then a singular value would be 0, but rounding makes it 1e-7 to 1e-5. Its inverse would make
# spikes of 1e4.
SINGULAR_VALUE_CUTOFF = 1e-3
LARGEST_BATCH = 1_000_000  # most numbers in one array of patches that are fitted together, to limit the memory


class Patches:
    """The patches of a mesh of quadratic tetrahedra with nodes (n, 3) and cells (t, 10), ordered as geometry.tet10."""

    def __init__(self, nodes, cells):
        self.nodes, self.corner = nodes, cells[:, :4]
        corners, number = np.unique(self.corner, return_inverse=True)
        self.cells_at = _incidence(number.reshape(-1, 4), len(corners)).T.tocsr()  # (corners, cells)

    def recover(self, degree, sources, values, targets, cell_targets, wanted):
        """Recovered values (m,) at the targets (m, 3). They are right only in the cells with the numbers `wanted`.

        degree: polynomial degree; sources (t, a): numbers of the nodes in each cell at which `values` (n,) are known;
        cell_targets (t, b): numbers of the targets in each cell.
        """
        one, own = np.ones((len(targets), 1)), np.arange(len(targets))  # each target: a load of 1, its own group
        field = degree, sources, one, targets, cell_targets, own
        ((recovery,),) = self.recover_transposed([field], len(targets), wanted)
        return recovery.T @ values

    def recover_transposed(self, fields, groups, wanted=None):
        """The transpose of `recover`, applied to loads at the targets, for each group of targets by itself.

        fields: [(degree, sources (t, a), loads (m, c), targets (m, 3), cell_targets (t, b), group (m,))], as in
        `recover`. group: number of each target's group, below `groups`. The result has for each field a list of c
        sparse matrices (n, groups), one for each column of loads. A matrix's column times nodal values (n,) is the sum
        of load times recovered value over the targets of one group. wanted: numbers of cells; if given, only their
        targets count.
        """
        patches, found = self._patches_touching(wanted), []
        for degree, sources, loads, targets, cell_targets, group in fields:
            components, entries = loads.shape[1], []
            shared = loads / self._patches_per_target(cell_targets, len(loads))[:, None]
            for patch_nodes, patch_targets in self._equal_patches(
                patches, degree, sources, cell_targets, len(targets), components
            ):
                known, at_targets, inverse = _fit_patches(
                    self.nodes[patch_nodes], targets[patch_targets], TERMS[degree]
                )
                # one column for each pair of a patch and a group that has targets in it
                number = (np.arange(len(patch_targets))[:, None] * groups + group[patch_targets]).ravel()
                order = np.argsort(number, kind="stable")
                pairs, first = np.unique(number[order], return_index=True)
                patch, of_group = pairs // groups, pairs % groups
                weighted = (at_targets[..., None] * shared[patch_targets][:, :, None]).reshape(patch_targets.size, -1)
                moments = np.add.reduceat(weighted[order], first).reshape(len(pairs), -1, components)
                entries.append((patch_nodes[patch], of_group, known[patch] @ (inverse[patch] @ moments)))
            found.append(self._matrices(entries, groups, components))
        return found

    def _patches_touching(self, wanted):
        """Sparse (patches, cells) matrix: which cells each patch has.

        wanted: numbers of cells. Patches without a cell that touches one of these are left out; None keeps all patches.
        """
        patches = self.cells_at
        if wanted is not None:
            neighbours = np.isin(self.corner, self.corner[wanted]).any(axis=1)
            patches = patches[np.flatnonzero(patches @ neighbours.astype(np.int32))]
        return patches

    def _equal_patches(self, patches, degree, sources, cell_targets, targets, components):
        """Yields node numbers (p, n) and target numbers (p, m) of p patches that have equal numbers of both.

        patches: result of `_patches_touching`; degree, sources, cell_targets: as in `recover`; targets: number of
        targets; components: number of loads at each target. A patch with too few nodes for the degree is enlarged by
        the neighbouring cells. LARGEST_BATCH limits how many patches are yielded at once.
        """
        terms = len(TERMS[degree])
        sources, patch_targets = _incidence(sources, len(self.nodes)), _sort_columns(
            patches @ _incidence(cell_targets, targets)
        )
        patch_nodes = _sort_columns(patches @ sources)
        few = np.diff(patch_nodes.indptr) < LEAST_NODES_PER_TERM * terms
        if few.any():
            neighbours = patches[few] @ self.cells_at.T @ self.cells_at
            patch_nodes = scipy.sparse.vstack([patch_nodes[~few], _sort_columns(neighbours @ sources)])
            patch_targets = scipy.sparse.vstack([patch_targets[~few], patch_targets[few]])
        sizes, kind = np.unique(
            np.stack([np.diff(patch_nodes.indptr), np.diff(patch_targets.indptr)]), axis=1, return_inverse=True
        )
        order, ends = np.argsort(kind, kind="stable"), np.cumsum(np.bincount(kind))
        for (nodes, count), same in zip(sizes.T, np.split(order, ends[:-1])):
            step = max(1, LARGEST_BATCH // (terms * max(nodes, count * components)))
            for first in range(0, len(same), step):
                chosen = same[first : first + step]
                yield _entry_columns(patch_nodes, chosen, nodes), _entry_columns(patch_targets, chosen, count)

    def _patches_per_target(self, cell_targets, count):
        """Number of patches in which each target lies, (count,).

        cell_targets (t, b): numbers of the targets in each cell; count: number of targets.
        """
        return np.bincount((self.cells_at @ _incidence(cell_targets, count)).indices, minlength=count)

    def _matrices(self, entries, groups, components):
        """[sparse (n, groups) matrix] for each component, the sum of all entries.

        entries: [(node numbers (p, a), group numbers (p,), values (p, a, components))].
        """
        size = len(self.nodes), groups
        rows = np.concatenate([near.ravel() for near, *_ in entries])
        columns = np.concatenate([np.repeat(of_group, near.shape[1]) for near, of_group, _ in entries])
        values = np.concatenate([block.reshape(-1, components) for *_, block in entries])
        return [scipy.sparse.csr_matrix((one, (rows, columns)), size) for one in values.T]


def _incidence(lists, count):
    """Sparse (t, count) matrix: row i has a one in each of the columns lists[i], for lists (t, a) of column numbers."""
    starts = np.arange(len(lists) + 1) * lists.shape[1]
    return scipy.sparse.csr_matrix((np.ones(lists.size, np.int32), lists.ravel(), starts), (len(lists), count))


def _sort_columns(matrix):
    """A sparse matrix with the columns of each row in ascending order."""
    matrix.sort_indices()
    return matrix


def _entry_columns(matrix, chosen, size):
    """Column numbers (p, size) of the entries in rows `chosen` (p,) of a sparse matrix, each with `size` entries."""
    return matrix.indices[matrix.indptr[chosen][:, None] + np.arange(size)]


def _fit_patches(points, targets, terms):
    """(A, B, C) of the least-squares fits in p patches: values v at the points give B C A^T v at the targets.

    A (p, n, t) are the monomials with the exponents `terms` (t, 3) at the points (p, n, 3), B (p, m, t) those at the
    targets (p, m, 3). C (p, t, t) is the pseudo-inverse of A^T A.
    """
    middle = points.mean(axis=1, keepdims=True)
    off = points - middle
    # coordinates are scaled along the patch's principal axes, since cells are several times longer than wide
    square, axes = np.linalg.eigh(off.transpose(0, 2, 1) @ off)
    turn = axes / np.sqrt(np.maximum(square / points.shape[1], 1e-300))[:, None]
    known, wanted = _monomials(off @ turn, terms), _monomials((targets - middle) @ turn, terms)
    square, vectors = np.linalg.eigh(known.transpose(0, 2, 1) @ known)  # squares of the singular values, ascending
    significant = square > SINGULAR_VALUE_CUTOFF**2 * square[:, -1:]
    inverse = np.where(significant, 1.0 / np.where(significant, square, 1.0), 0.0)
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
