"""Linear solves with the tangent, bordered by the few unknowns of the boundaries.

    [A  B] [x]   [f]          x = A^-1 f - (A^-1 B) y,   (D - C A^-1 B) y = g - C A^-1 f
    [C  D] [y] = [g]

A is sparse; its unknowns are the velocity and pressure dofs that no boundary fixes. The border has a row and a column
for the inflow and for each outlet with a resistance. `DirectSolver` factorizes A by MUMPS.
"""

import numpy as np
from petsc4py import PETSc

from common.errors import ComputationError


class DirectSolver:
    """MUMPS factorization of A.

    One PETSc KSP serves all steps: it reuses the symbolic factorization, and a new KSP each time would leak memory.
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

    def solve(self, right_side, solution):
        """solution <- A^-1 right_side (PETSc vectors). Raises ComputationError when MUMPS cannot."""
        self.ksp.solve(right_side, solution)
        if self.ksp.getConvergedReason() < 0:
            reason = self.ksp.getConvergedReason()
            raise ComputationError("linear solve failed", "MUMPS", f"reason {reason}", "check the mesh and resistances")

    def solve_all(self, right_sides, solutions):
        """`solve` for lists of vectors at once. Raises ComputationError.

        Most of a solve's cost is to read the factors from memory. Here they are read once for all vectors.
        """
        if len(right_sides) == 1:
            self.solve(right_sides[0], solutions[0])
            return
        shape = (right_sides[0].size, len(right_sides))
        given, found = (PETSc.Mat().createDense(shape, comm=PETSc.COMM_SELF) for _ in range(2))
        for dense in (given, found):
            dense.setUp()
        given.getDenseArray()[:] = np.stack([right_side.array_r for right_side in right_sides], axis=1)
        for dense in (given, found):
            dense.assemble()
        self.ksp.getPC().getFactorMatrix().matSolve(given, found)
        for solution, values in zip(solutions, found.getDenseArray().T):
            solution.array[:] = values
        for dense in (given, found):
            dense.destroy()
        if not all(np.isfinite(solution.norm()) for solution in solutions):
            raise ComputationError("linear solve failed", "MUMPS", "not finite", "check the mesh and resistances")

    def release(self):
        """Frees the factors. The next factorization repeats the symbolic factorization."""
        self.ksp.reset()

    def destroy(self):
        """Frees PETSc's memory."""
        self.release()
        self.ksp.destroy()


class BorderedSystem:
    """The bordered system with the matrix A that `solver` (DirectSolver) has factorized.

    columns: list of vectors, those of B; rows: list of vectors, the rows of C; corner: D. A^-1 B is computed once, so
    that each right side costs one solve with A.
    """

    def __init__(self, solver, columns, rows, corner):
        self.solver, self.columns, self.rows, self.corner = solver, columns, rows, corner
        self.border_solutions = [column.duplicate() for column in columns]
        solver.solve_all(columns, self.border_solutions)
        self.schur = np.array(corner, float)
        for i, row in enumerate(rows):
            for j, vector in enumerate(self.border_solutions):
                self.schur[i, j] -= row.dot(vector)

    def solve(self, f, g):
        """(x, y), a new PETSc vector and an array, for the right side f (PETSc vector) and g (array)."""
        return self.solve_all([f], [g])[0]

    def solve_all(self, right_sides, border_sides):
        """[(x, y)] as `solve` gives them, for lists of f (`right_sides`) and g (`border_sides`)."""
        found = [f.duplicate() for f in right_sides]
        self.solver.solve_all(right_sides, found)
        result = []
        for x, g in zip(found, border_sides):
            y = np.linalg.solve(self.schur, np.array(g, float) - [row.dot(x) for row in self.rows])
            x.maxpy(-y, self.border_solutions)
            result.append((x, y))
        return result

    def destroy(self):
        """Frees the vectors A^-1 B."""
        for vector in self.border_solutions:
            vector.destroy()
