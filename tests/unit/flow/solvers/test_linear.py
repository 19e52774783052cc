"""Linear solves with a factorization: several right sides at once."""

import numpy as np
import pytest
import scipy.sparse

from common.errors import ComputationError, InputError
from flow.solvers import linear

SIZE, COUNT = 40, 3


def _solver(values):
    """A solver that holds the dense matrix `values`."""
    solver = linear.DirectSolver()
    solver.set_matrix(scipy.sparse.csr_matrix(values))
    return solver


@pytest.mark.parametrize("count", (1, COUNT))
def test_several_right_sides_have_the_solutions_of_each(count):
    random = np.random.default_rng(0)
    values, given = random.normal(size=(SIZE, SIZE)), random.normal(size=(SIZE, count))
    solver, before, expected = _solver(values), given.copy(), np.linalg.solve(values, given)
    assert np.abs(solver.solve(given) - expected).max() < 1e-4 * np.abs(expected).max()
    assert (given == before).all()


@pytest.mark.parametrize("size", (1e-60, 1e60))
def test_columns_that_single_precision_cannot_hold_are_scaled(size):
    solver, given = _solver(np.diag(np.arange(1.0, SIZE + 1))), np.ones((SIZE, 2))
    given[:, 1] *= size
    found = solver.solve(given)
    assert found[:, 1] / size == pytest.approx(found[:, 0], rel=1e-6)
    assert found[:, 0] == pytest.approx(1 / np.arange(1.0, SIZE + 1), rel=1e-6)


def test_solutions_that_are_not_finite_are_refused():
    solver = _solver(np.eye(SIZE))
    given = np.ones((SIZE, COUNT))
    given[0, 1] = np.nan
    with pytest.raises(ComputationError, match="not finite"):
        solver.solve(given)


def test_new_values_are_factorized_anew():
    """This includes values written into the matrix's own array, as discretisation.tangent does."""
    random = np.random.default_rng(1)
    pattern, given = scipy.sparse.csr_matrix(random.normal(size=(SIZE, SIZE))), random.normal(size=(SIZE, 1))
    solver = linear.DirectSolver()
    for _ in range(3):
        solver.set_matrix(pattern)
        expected = np.linalg.solve(pattern.toarray(), given)
        assert np.abs(solver.solve(given) - expected).max() < 1e-4 * np.abs(expected).max()
        pattern.data[:] = random.normal(size=pattern.nnz)
    assert solver.factorizations == 3


def test_another_pattern_needs_a_new_start():
    solver = _solver(np.eye(SIZE))
    with pytest.raises(ComputationError, match="another pattern"):
        solver.set_matrix(scipy.sparse.csr_matrix(np.ones((SIZE, SIZE))))
    solver.release()
    solver.set_matrix(scipy.sparse.csr_matrix(np.ones((SIZE, SIZE)) + SIZE * np.eye(SIZE)))


def test_a_flow_without_its_compiled_part_is_refused(monkeypatch, tmp_path):
    monkeypatch.setenv("VCI_BUILD_DIR", str(tmp_path))
    with pytest.raises(InputError, match="make build"):
        linear.DirectSolver()


def test_the_border_is_solved_for_once():
    random = np.random.default_rng(2)
    whole, given = random.normal(size=(SIZE, SIZE)), random.normal(size=(SIZE, COUNT))
    inner = SIZE - 2
    solver = _solver(whole[:inner, :inner])
    parts = whole[:inner, inner:], whole[inner:, :inner], whole[inner:, inner:]
    bordered, expected = linear.BorderedSystem(solver, *parts), np.linalg.solve(whole, given)
    for chosen in (slice(0, 1), slice(1, COUNT)):
        found = bordered.solve(given[:inner, chosen], given[inner:, chosen])
        assert np.concatenate(found) == pytest.approx(expected[:, chosen], rel=1e-6)
    assert bordered.border_solution.shape == (inner, 2)


def _badly_conditioned(random, condition):
    """A matrix (SIZE, SIZE) with singular values from 1 to 1 / condition."""
    left, right = (np.linalg.qr(random.normal(size=(SIZE, SIZE)))[0] for _ in range(2))
    return left @ np.diag(np.geomspace(1, 1 / condition, SIZE)) @ right


@pytest.mark.parametrize("condition, tolerance", [(1e2, 1e-5), (1e5, 1e-3)])
def test_refinement_gives_the_digits_that_the_factors_lack(condition, tolerance):
    """The error is that of the residual times the condition, as with factors in double precision."""
    random = np.random.default_rng(3)
    whole, given = _badly_conditioned(random, condition), random.normal(size=(SIZE, COUNT))
    inner = SIZE - 2
    bordered = linear.BorderedSystem(
        _solver(whole[:inner, :inner]), whole[:inner, inner:], whole[inner:, :inner], whole[inner:, inner:]
    )
    expected, rough = np.linalg.solve(whole, given), None
    rough = np.concatenate(bordered._solve_roughly(given[:inner], given[inner:]))
    found = np.concatenate(bordered.solve(given[:inner], given[inner:]))
    error, rough_error = (np.abs(one - expected).max() / np.abs(expected).max() for one in (found, rough))
    assert error < tolerance and error < 0.1 * rough_error


def test_a_matrix_that_single_precision_cannot_tell_from_a_singular_one_is_refused():
    random = np.random.default_rng(4)
    whole, given = _badly_conditioned(random, 1e12), random.normal(size=(SIZE, 1))
    inner = SIZE - 2
    parts = whole[:inner, inner:], whole[inner:, :inner], whole[inner:, inner:]
    with pytest.raises(ComputationError, match="linear solve failed"):
        linear.BorderedSystem(_solver(whole[:inner, :inner]), *parts).solve(given[:inner], given[inner:])
