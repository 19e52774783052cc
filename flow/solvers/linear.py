"""Linear solves with the tangent, bordered by the few unknowns of the boundaries.

    [A  B] [x]   [f]          x = A^-1 f - (A^-1 B) y,   (D - C A^-1 B) y = g - C A^-1 f
    [C  D] [y] = [g]

A is sparse; its unknowns x are the velocity and pressure dofs that no boundary fixes. The border has a row and a column
for the inflow and for each outlet, with the unknowns y. `DirectSolver` factorizes A by MUMPS in single precision, which
takes half the time of double precision, and half the memory for the factors. Iterative refinement (Higham, Accuracy
and Stability of Numerical Algorithms, 2002, chapter 12) makes up for the lost digits: the residual of the whole system,
computed in double precision, is solved for again. Each repetition lowers it by a factor of 1e4 or so. Near a singular
matrix it falls more slowly. Where a repetition does not even halve it, the digits are as good as they get.
"""

import functools
import importlib.machinery
import importlib.util
import os
import pathlib

import numpy as np
from mpi4py import MPI

from common.errors import ComputationError, InputError

MODULE = "flow_factors"  # compiled from factors_module.cpp
# Residual after refinement, over the largest of the terms that it is the difference of. At 1e-6, where Newton's method
# converges as well, the flow would lose 3e-8 of its mass.
REFINED_RESIDUAL = 1e-10


@functools.cache
def load_factors():
    """The compiled module flow_factors from the build folder: VCI_BUILD_DIR, or build/ of the repository.

    Raises InputError if it is not built, or built for other libraries than the present ones.
    """
    folder = pathlib.Path(__file__).resolve().parents[2] / os.environ.get("VCI_BUILD_DIR", "build") / "python"
    where, remedy = folder / f"{MODULE}.so", "run `make build`"
    spec = importlib.machinery.PathFinder.find_spec(MODULE, [str(folder)])
    if spec is None:
        raise InputError("the compiled part of the flow is missing", where, "no file", remedy)
    try:
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except ImportError as error:
        raise InputError("the compiled part of the flow cannot be loaded", where, error, remedy) from error
    return module


class DirectSolver:
    """MUMPS factorization of A in single precision.

    One object serves all steps on a mesh, because it chooses the order of elimination only once. factorizations: their
    number; matrix: A, as it was factorized last. Raises InputError if flow_factors is not built.
    """

    def __init__(self):
        self.module = load_factors()
        self.factors, self.matrix, self.factorizations = None, None, 0

    def set_matrix(self, matrix):
        """Factorizes a scipy CSR matrix, whose pattern is the same at all calls. Raises ComputationError."""
        if self.factors is None:
            self.factors = self.module.Factors(MPI.COMM_SELF.py2f())
        self.matrix = matrix
        try:
            self.factors.set_matrix(_as_int32(matrix.indptr), _as_int32(matrix.indices), matrix.data)
        except RuntimeError as error:
            raise ComputationError("factorization failed", "MUMPS", error, "check memory and the mesh") from error
        self.factorizations += 1

    def solve(self, right_sides):
        """A^-1 times the columns of right_sides (n, k), with about 5 exact digits. Raises ComputationError.

        Most of a solve's cost is to read the factors from memory. So they are read once for all columns together.
        """
        try:
            found = self.factors.solve(right_sides)
        except RuntimeError as error:
            raise ComputationError("linear solve failed", "MUMPS", error, "check memory and the mesh") from error
        if not np.isfinite(found).all():
            raise ComputationError("linear solve failed", "MUMPS", "not finite", "check the mesh and resistances")
        return found

    def release(self):
        """Frees the factors. The next factorization chooses the order of elimination again."""
        self.factors = self.matrix = None


class BorderedSystem:
    """The bordered system with the matrix A that `solver` (DirectSolver) has factorized.

    columns (n, b): B; rows (b, n): C; corner (b, b): D. A^-1 B is found together with the first right sides, so that a
    right side costs one solve with A, and one for each refinement.
    """

    def __init__(self, solver, columns, rows, corner):
        self.solver, self.columns, self.rows, self.corner = solver, columns, rows, corner
        self.border_solution = None  # A^-1 B

    def solve(self, f, g):
        """(x (n, k), y (b, k)) for k right sides f (n, k) and g (b, k).

        The largest residual of the rows A x + B y = f is at most REFINED_RESIDUAL times the largest value of f and B y.
        The same holds for the other rows with g and |C| |x|. Raises ComputationError if that cannot be reached.
        """
        x, y, left = self._refine(f, g)
        if not left <= REFINED_RESIDUAL:
            raise ComputationError("linear solve failed", "refinement", f"residual {left:.1e}", "check the mesh")
        return x, y

    def solve_for_correction(self, f, g):
        """(x, y) as `solve`, but refined only as far as possible.

        Newton's method judges a correction by what it does. So near a singular tangent a rough one is tried, too.
        """
        return self._refine(f, g)[:2]

    def _refine(self, f, g):
        """(x, y, residual): the best repetition. They end where the residual is small enough or is not halved."""
        x, y = self._solve_roughly(f, g)
        best = x, y, np.inf
        while True:
            by, cx = self.columns @ y, self.rows @ x
            residual = f - self.solver.matrix @ x - by, g - cx - self.corner @ y
            # The terms of C x may cancel, as in the condition that no blood enters. So their absolute values count.
            sizes = _largest(f) + _largest(by), _largest(g) + _largest(np.abs(self.rows) @ np.abs(x))
            left = max((_largest(one) / np.where(size > 0, size, 1)).max() for one, size in zip(residual, sizes))
            before = best[2]
            if left < before:
                best = x, y, left
            if left <= REFINED_RESIDUAL or not left <= 0.5 * before:
                return best
            more_x, more_y = self._solve_roughly(*residual)
            x, y = x + more_x, y + more_y

    def _solve_roughly(self, f, g):
        """(x, y) as `solve`, with the few digits of the factors."""
        if self.border_solution is None:
            found = self.solver.solve(np.hstack([self.columns, f]))
            self.border_solution, x = np.split(found, [self.columns.shape[1]], axis=1)
            self.schur = self.corner - self.rows @ self.border_solution
        else:
            x = self.solver.solve(f)
        try:
            y = np.linalg.solve(self.schur, g - self.rows @ x)
        except np.linalg.LinAlgError as error:
            raise ComputationError("linear solve failed", "rows of the boundaries", error, "check the mesh") from error
        return x - self.border_solution @ y, y


def _as_int32(numbers):
    """Numbers as MUMPS takes them. The flow's meshes have far fewer than 2^31 entries."""
    return numbers.astype(np.int32, casting="same_kind", copy=False)


def _largest(columns):
    """Largest absolute value of each column."""
    return np.abs(columns).max(axis=0)
