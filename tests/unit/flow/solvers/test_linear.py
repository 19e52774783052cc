"""Linear solves with a factorization: several right sides at once."""

import numpy as np
import pytest
from petsc4py import PETSc

from common.errors import ComputationError
from flow.solvers import linear

SIZE, COUNT = 40, 3


def _solver(values):
    """A solver that holds the dense matrix `values`."""
    matrix = PETSc.Mat().createAIJ(values.shape, nnz=len(values), comm=PETSc.COMM_SELF)
    everything = np.arange(len(values), dtype=np.int32)
    matrix.setValues(everything, everything, values)
    matrix.assemble()
    solver = linear.DirectSolver()
    solver.set_matrix(matrix)
    return solver, matrix


def _vectors(matrix, values):
    """Vectors of the columns of `values`."""
    vectors = [matrix.createVecRight() for _ in values.T]
    for vector, column in zip(vectors, values.T):
        vector.array[:] = column
    return vectors


@pytest.mark.parametrize("count", (1, COUNT))
def test_several_right_sides_have_the_solutions_of_each(count):
    random = np.random.default_rng(0)
    values, given = random.normal(size=(SIZE, SIZE)), random.normal(size=(SIZE, count))
    solver, matrix = _solver(values)
    rights, solutions = _vectors(matrix, given), _vectors(matrix, np.zeros((SIZE, count)))
    solver.solve_all(rights, solutions)
    expected = np.linalg.solve(values, given)
    assert np.stack([one.array for one in solutions], axis=1) == pytest.approx(expected, rel=1e-9)
    assert np.stack([one.array for one in rights], axis=1) == pytest.approx(given, rel=0)
    solver.destroy()


def test_solutions_that_are_not_finite_are_refused():
    solver, matrix = _solver(np.eye(SIZE))
    given = np.ones((SIZE, COUNT))
    given[0, 1] = np.nan
    with pytest.raises(ComputationError, match="not finite"):
        solver.solve_all(_vectors(matrix, given), _vectors(matrix, given))
    solver.destroy()
