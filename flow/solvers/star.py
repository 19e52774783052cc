"""Smoother of a velocity block: the dofs round each corner of the mesh solved for together.

A star is the P2 nodes inside the cells round a corner, on the corner and on the edges that meet there: up to some 15
nodes. Their part of the matrix is inverted, all stars are solved at once and averaged where they overlap (additive
Schwarz). Solved together, they can move without changing the volume of their cells, as grad-div asks for (Farrell,
Mitchell and Wechsung 2019, SIAM J Sci Comput 41:A3073); point smoothers and ILU cannot.
"""

import numpy as np

from flow.geometry import tet10

AT_ONCE = 2000  # stars whose matrices are extracted together


def stars(cells, free):
    """[(s, m) node numbers of the stars of m nodes] of cells (t, 10); free (n,): nodes that no boundary fixes."""
    corner = cells[:, :4].ravel()
    pairs = [np.stack([corner, corner], axis=1)]
    for k, ends in enumerate(tet10.EDGES):
        pairs += [np.stack([cells[:, end], cells[:, 4 + k]], axis=1) for end in ends]
    pairs = np.unique(np.concatenate(pairs), axis=0)
    pairs = pairs[free[pairs[:, 1]]]
    _, first, count = np.unique(pairs[:, 0], return_index=True, return_counts=True)
    return [pairs[first[count == m][:, None] + np.arange(m), 1] for m in np.unique(count)]


class Stars:
    """The smoother of a matrix with rows of three a node, in single precision; groups: of `stars`.

    block(nodes (k,)) -> scipy CSR (3 k, 3 k) of the matrix between these nodes; nodes: how many there are.
    """

    def __init__(self, groups, block, nodes):
        self.inverses, count = [], np.zeros(nodes)
        for group in groups:
            size = 3 * group.shape[1]
            inverse = np.empty((len(group), size, size), np.float32)
            for start in range(0, len(group), AT_ONCE):
                part = group[start : start + AT_ONCE]
                inverse[start : start + AT_ONCE] = np.linalg.inv(_dense(part, block))
            dofs = (3 * group[:, :, None] + np.arange(3)).reshape(len(group), size)
            self.inverses.append((dofs, inverse))
            np.add.at(count, group.ravel(), 1)
        self.share = np.repeat(1.0 / np.maximum(count, 1), 3)
        self.dofs = np.concatenate([dofs.ravel() for dofs, _ in self.inverses])

    def solve(self, right, transposed=False):
        """(n,) -> (n,); 0 at nodes of no star."""
        single = right.astype(np.float32)
        if transposed:
            parts = [np.matmul(single[dofs][:, None], inverse).ravel() for dofs, inverse in self.inverses]
        else:
            parts = [np.matmul(inverse, single[dofs][..., None]).ravel() for dofs, inverse in self.inverses]
        return self.share * np.bincount(self.dofs, np.concatenate(parts), minlength=len(right))


def _dense(group, block):
    """(s, 3 m, 3 m) matrices of stars (s, m)."""
    nodes, local = np.unique(group, return_inverse=True)
    local = local.reshape(group.shape)
    matrix = block(nodes)
    matrix.sort_indices()
    rows = np.repeat(np.arange(matrix.shape[0], dtype=np.int64), np.diff(matrix.indptr))
    keys = rows * matrix.shape[0] + matrix.indices
    dofs = (3 * local[:, :, None] + np.arange(3)).reshape(len(group), -1).astype(np.int64)
    wanted = dofs[:, :, None] * matrix.shape[0] + dofs[:, None, :]
    at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    return np.where(keys[at] == wanted, matrix.data[at], 0.0)
