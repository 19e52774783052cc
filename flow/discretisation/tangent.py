"""Newton's and Picard's matrices between the free dofs, filled by the 3 x 3 blocks of the velocity nodes.

    [A  B']      A: velocity block, assembled at each linearisation; B: -(q, div u), which no state changes
    [B  0 ]

Entry by entry PETSc would look up each of a cell's 34 x 34 values in its row, which takes twice as long as computing
them. By blocks it looks up 100 places a cell. The place of each value of A among the free dofs is computed once.
"""

import numpy as np
import scipy.sparse
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from flow.discretisation import compat


class FreeMatrix:
    """The matrix of discretisation.forms.NavierStokes over a LumenSpace.

    matrix: PETSc AIJ between the free dofs, of the same pattern each time.
    """

    def __init__(self, space, forms):
        self.space = space
        self.velocity = compat.block_matrix(forms.mass)
        fem_petsc.assemble_matrix(self.velocity, forms.mass)
        self.velocity.assemble()
        self.entries = self.velocity.convert("aij", PETSc.Mat())
        self.given, self.found = self.velocity.createVecs()
        self.divergence = compat.csr(fem_petsc.assemble_matrix(forms.divergence))  # B (dofs of Q, dofs of V)
        pattern = self._pattern()
        self.places = pattern.data.astype(np.int64) - 1
        self.fixed = np.flatnonzero(self.places < 0)  # where B and 0 are
        values = np.append(self.divergence.data, 0.0)[-self.places[self.fixed] - 2]
        self.fixed_values, self.places[self.fixed] = values, 0
        self.pattern = tuple(part.astype(PETSc.IntType) for part in (pattern.indptr, pattern.indices))
        given = *self.pattern, np.zeros(pattern.nnz)
        self.matrix = PETSc.Mat().createAIJ(pattern.shape, csr=given, comm=PETSc.COMM_SELF)

    def _pattern(self):
        """CSR pattern of `matrix`. Its data say where each value comes from.

        1, 2, ... count the entries of A; -1, -2, ... count the entries of B; the number after the last is a zero.
        """
        space, row = self.space, self.divergence.copy()
        row.data = -1 - np.arange(row.nnz, dtype=np.int32)
        corners = compat.cell_dofs(space.Q)
        pairs = np.repeat(corners, 4, axis=1).ravel(), np.tile(corners, 4).ravel()
        # in the pattern, too, for MUMPS' ordering: pressures of one cell
        zero = scipy.sparse.csr_matrix((np.ones(len(pairs[0]), np.int32), pairs), 2 * (row.shape[0],))
        zero.data[:] = -1 - row.nnz
        velocity, border = _numbered(self.entries), scipy.sparse.bmat([[None, row.T], [row, zero]], "csr")
        velocity.resize(border.shape)
        number = np.empty(space.dofs, np.int32)
        number[np.concatenate([space.v_map, space.q_map])] = np.arange(space.dofs)
        free = number[space.free]
        velocity, border = (part[free][:, free] for part in (velocity, border))
        for part in (velocity, border):
            part.sort_indices()
        return velocity + border

    def assemble(self, form, inertia=None):
        """Fills the matrix by the velocity block `form` at the present state; inertia: solvers.marching.Inertia."""
        self.velocity.zeroEntries()
        fem_petsc.assemble_matrix(self.velocity, form)
        self.velocity.assemble()
        if inertia:
            inertia.add_tangent(self.velocity)
        self.velocity.convert("aij", self.entries)
        values = self.entries.getValuesCSR()[2][self.places]
        values[self.fixed] = self.fixed_values
        self.matrix.setValuesCSR(*self.pattern, values)
        self.matrix.assemble()

    def times(self, values, transposed=False):
        """The last matrix, or its transposed, between all dofs times values (n,) over W that have no pressure."""
        space, found = self.space, np.zeros(len(values))
        self.given.array[:] = values[space.v_map]
        (self.velocity.multTranspose if transposed else self.velocity.mult)(self.given, self.found)
        found[space.v_map] = self.found.array_r
        found[space.q_map] = self.divergence @ values[space.v_map]
        return found

    def destroy(self):
        """Frees PETSc's memory."""
        for petsc_object in (self.velocity, self.entries, self.matrix, self.given, self.found):
            petsc_object.destroy()


def _numbered(matrix):
    """CSR of a PETSc AIJ matrix whose data are the places, from 1 on, of its entries."""
    starts, columns, values = matrix.getValuesCSR()
    return scipy.sparse.csr_matrix((np.arange(1, len(values) + 1, dtype=np.int32), columns, starts), matrix.size)
