"""Linear solves with the tangent, bordered by the few unknowns of the boundaries.

    [A  B] [x]   [f]          x = A^-1 f - (A^-1 B) y,   (D - C A^-1 B) y = g - C A^-1 f
    [C  D] [y] = [g]

A is sparse; its unknowns x are the velocity and pressure dofs that no boundary fixes. The border has a row and a column
for the inflow and for each outlet, with the unknowns y. `DirectSolver` factorizes A by MUMPS.
"""

import numpy as np
from petsc4py import PETSc

from common.errors import ComputationError


class DirectSolver:
    """MUMPS factorization of A.

    One PETSc KSP serves all steps. It reuses the symbolic factorization, and a new KSP for each step would leak memory.
    """

    def __init__(self):
        self.ksp = PETSc.KSP().create(PETSc.COMM_SELF)
        self.ksp.setType("preonly")
        pc = self.ksp.getPC()
        pc.setType("lu")
        pc.setFactorSolverType("mumps")
        options = PETSc.Options()
        prefix = "flow_direct_"
        for name, value in (("mat_mumps_icntl_14", 60), ("mat_mumps_icntl_24", 1)):
            options[prefix + name] = value
        self.ksp.setOptionsPrefix(prefix)
        self.ksp.setFromOptions()
        self.factorizations = 0

    def set_matrix(self, matrix):
        """Factorizes `matrix`. Raises ComputationError when MUMPS cannot."""
        self.ksp.setOperators(matrix)
        try:
            self.ksp.setUp()
        except PETSc.Error as error:
            raise ComputationError("factorization failed", "MUMPS", error, "check memory and the mesh") from error
        self.factorizations += 1

    def solve(self, right_sides):
        """A^-1 times the columns of right_sides (n, k). Raises ComputationError when MUMPS cannot.

        Most of a solve's cost is to read the factors from memory. So they are read once for all columns together.
        """
        # MUMPS reads and writes the columns one after the other, as in Fortran's order
        arrays = np.asfortranarray(right_sides), np.empty(right_sides.shape, order="F")
        given, found = (PETSc.Mat().createDense(one.shape, array=one, comm=PETSc.COMM_SELF) for one in arrays)
        try:
            self.ksp.getPC().getFactorMatrix().matSolve(given, found)
        except PETSc.Error as error:  # also where the factorization failed
            raise ComputationError("linear solve failed", "MUMPS", error, "check memory and the mesh") from error
        finally:
            given.destroy()
            found.destroy()
        if not np.isfinite(arrays[1]).all():
            raise ComputationError("linear solve failed", "MUMPS", "not finite", "check the mesh and resistances")
        return arrays[1]

    def release(self):
        """Frees the factors. The next factorization repeats the symbolic factorization."""
        self.ksp.reset()

    def destroy(self):
        """Frees PETSc's memory."""
        self.release()
        self.ksp.destroy()


class BorderedSystem:
    """The bordered system with the matrix A that `solver` (DirectSolver) has factorized.

    columns (n, b): B; rows (b, n): C; corner (b, b): D. A^-1 B is found together with the first right sides, so that a
    right side costs one solve with A.
    """

    def __init__(self, solver, columns, rows, corner):
        self.solver, self.columns, self.rows, self.corner = solver, columns, rows, corner
        self.border_solution = None  # A^-1 B

    def solve(self, f, g):
        """(x (n, k), y (b, k)) for k right sides f (n, k) and g (b, k). Raises ComputationError."""
        if self.border_solution is None:
            found = self.solver.solve(np.hstack([self.columns, f]))
            self.border_solution, x = np.split(found, [self.columns.shape[1]], axis=1)
            self.schur = self.corner - self.rows @ self.border_solution
        else:
            x = self.solver.solve(f)
        y = np.linalg.solve(self.schur, g - self.rows @ x)
        return x - self.border_solution @ y, y
