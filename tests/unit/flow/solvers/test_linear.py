"""Linear solves with a factorization: several right sides at once."""

import numpy as np
import pytest
import scipy.sparse
from petsc4py import PETSc

from common.errors import ComputationError
from flow.discretisation import tangent
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


@pytest.mark.parametrize("count", (1, COUNT))
def test_several_right_sides_have_the_solutions_of_each(count):
    random = np.random.default_rng(0)
    values, given = random.normal(size=(SIZE, SIZE)), random.normal(size=(SIZE, count))
    solver, _ = _solver(values)
    before = given.copy()
    assert solver.solve(given) == pytest.approx(np.linalg.solve(values, given), rel=1e-9)
    assert (given == before).all()
    solver.destroy()


def test_solutions_that_are_not_finite_are_refused():
    solver, _ = _solver(np.eye(SIZE))
    given = np.ones((SIZE, COUNT))
    given[0, 1] = np.nan
    with pytest.raises(ComputationError, match="not finite"):
        solver.solve(given)
    solver.destroy()


def test_new_values_are_factorized_anew():
    """This includes values written into the matrix's own array, as discretisation.tangent does."""
    random = np.random.default_rng(1)
    pattern, given = scipy.sparse.csr_matrix(random.normal(size=(SIZE, SIZE))), random.normal(size=(SIZE, 1))
    matrix, solver = tangent._matrix_on(pattern, pattern.data), linear.DirectSolver()
    for _ in range(3):
        matrix.assemble()
        solver.set_matrix(matrix)
        assert solver.solve(given) == pytest.approx(np.linalg.solve(pattern.toarray(), given), rel=1e-9)
        pattern.data[:] = random.normal(size=pattern.nnz)
    assert solver.factorizations == 3
    solver.destroy()


def test_the_border_is_solved_for_once():
    random = np.random.default_rng(2)
    whole, given = random.normal(size=(SIZE, SIZE)), random.normal(size=(SIZE, COUNT))
    inner = SIZE - 2
    solver, _ = _solver(whole[:inner, :inner])
    parts = whole[:inner, inner:], whole[inner:, :inner], whole[inner:, inner:]
    bordered, expected = linear.BorderedSystem(solver, *parts), np.linalg.solve(whole, given)
    for chosen in (slice(0, 1), slice(1, COUNT)):
        found = bordered.solve(given[:inner, chosen], given[inner:, chosen])
        assert np.concatenate(found) == pytest.approx(expected[:, chosen], rel=1e-9)
    solver.destroy()
