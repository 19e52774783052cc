"""The matrix of Newton's or Picard's method, between the free dofs.

    [A  B']      A: velocity block, assembled at each linearisation; B: -(q, div u), which no state changes
    [B  0 ]

A is assembled in 3 x 3 blocks, one for each pair of velocity nodes. For each of them PETSc must find the place in its
row. A cell has 100 blocks, but 34 x 34 single values: finding their places would take twice as long as computing them.
The place of each value of A in the matrix of the free dofs is computed once.
"""

import numpy as np
import scipy.sparse
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from flow.discretisation import compat


class FreeMatrix:
    """The matrix of forms.NavierStokes on a LumenSpace.

    matrix: scipy CSR matrix between the free dofs, with the same sparsity pattern for every state.
    """

    def __init__(self, space, forms):
        self.space = space
        self.velocity = compat.block_matrix(forms.mass)
        fem_petsc.assemble_matrix(self.velocity, forms.mass)
        self.velocity.assemble()
        self.entries, self.entry_values, numbers = _share_values(self.velocity)
        self.input_vector, self.output_vector = self.velocity.createVecs()
        self.divergence = compat.to_csr(fem_petsc.assemble_matrix(forms.divergence))  # B (dofs of Q, dofs of V)
        pattern = self._pattern(numbers)
        self.sources, self.values = pattern.data.astype(np.int64) - 1, np.zeros(pattern.nnz)
        self.constant_places = np.flatnonzero(self.sources < 0)  # entries that no state changes: B, and explicit zeros
        values = np.append(self.divergence.data, 0.0)[-self.sources[self.constant_places] - 2]
        self.constant_values, self.sources[self.constant_places] = values, 0
        self.matrix = scipy.sparse.csr_matrix((self.values, pattern.indices, pattern.indptr), pattern.shape)

    def _pattern(self, velocity):
        """CSR matrix with the pattern of `matrix`, whose values say where each entry of `matrix` comes from.

        Values 1, 2, ... stand for the entries of A, in their order in the CSR matrix `velocity`, which has A's pattern.
        Values -1, -2, ... stand for the entries of B. The value after that of B's last entry stands for a zero.
        """
        space, row = self.space, self.divergence.copy()
        row.data = -1 - np.arange(row.nnz, dtype=np.int32)
        corners = compat.cell_dofs(space.Q)
        pairs = np.repeat(corners, 4, axis=1).ravel(), np.tile(corners, 4).ravel()
        # the pattern also has zeros between the pressures of one cell, which MUMPS uses when it orders the unknowns
        zero = scipy.sparse.csr_matrix((np.ones(len(pairs[0]), np.int32), pairs), 2 * (row.shape[0],))
        zero.data[:] = -1 - row.nnz
        border = scipy.sparse.bmat([[None, row.T], [row, zero]], "csr")
        velocity.resize(border.shape)
        number = np.empty(space.dofs, np.int32)
        number[np.concatenate([space.v_map, space.q_map])] = np.arange(space.dofs)
        free = number[space.free_dofs]
        velocity, border = (part[free][:, free] for part in (velocity, border))
        for part in (velocity, border):
            part.sort_indices()
        return velocity + border

    def assemble(self, form, inertia=None):
        """Fills the matrix at the present state.

        form: form of the velocity block, `tangent` or `picard` of forms.NavierStokes; inertia:
        solvers.marching.Inertia, whose part is added, or None.
        """
        self.velocity.zeroEntries()
        fem_petsc.assemble_matrix(self.velocity, form)
        self.velocity.assemble()
        if inertia:
            inertia.add_tangent(self.velocity)
        self.velocity.convert("aij", self.entries)
        np.take(self.entry_values, self.sources, out=self.values)
        self.values[self.constant_places] = self.constant_values

    def multiply(self, values, transposed=False):
        """Product (n,) over W of the last matrix, or its transpose, with values (n,) whose pressures are 0.

        The matrix is taken between all dofs, not only the free ones.
        """
        space, found = self.space, np.zeros(len(values))
        self.input_vector.array[:] = values[space.v_map]
        (self.velocity.multTranspose if transposed else self.velocity.mult)(self.input_vector, self.output_vector)
        found[space.v_map] = self.output_vector.array_r
        found[space.q_map] = self.divergence @ values[space.v_map]
        return found

    def destroy(self):
        """Frees PETSc's memory."""
        for petsc_object in (self.velocity, self.entries, self.input_vector, self.output_vector):
            petsc_object.destroy()


def _share_values(blocks):
    """Converts a PETSc matrix of 3 x 3 blocks to (AIJ matrix, its values (nnz,), CSR matrix of their numbers).

    The array is the memory of the AIJ matrix itself, so the next conversion into this matrix fills it without a copy.
    The CSR matrix has the same pattern. Its values number the entries from 1, by which `_pattern` traces each of them.
    """
    converted = blocks.convert("aij", PETSc.Mat())
    starts, columns, values = converted.getValuesCSR()
    numbers = np.arange(1, len(values) + 1, dtype=np.int32)
    found = scipy.sparse.csr_matrix((numbers, columns, starts), converted.size)
    converted.destroy()
    return _matrix_on(found, values), values, found


def _matrix_on(pattern, values):
    """PETSc AIJ matrix with the pattern of a CSR matrix, whose values are the array `values` (nnz,) itself."""
    starts = pattern.indptr.astype(PETSc.IntType), pattern.indices.astype(PETSc.IntType)
    return PETSc.Mat().createAIJWithArrays(pattern.shape, (*starts, values), comm=PETSc.COMM_SELF)
