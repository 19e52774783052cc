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


def test_no_right_sides_have_no_solutions():
    assert _solver(np.eye(SIZE)).solve(np.empty((SIZE, 0))).shape == (SIZE, 0)


@pytest.mark.parametrize("other", [np.ones((SIZE, SIZE)), np.eye(SIZE)[::-1]], ids=["more entries", "other places"])
def test_another_pattern_needs_a_new_start(other):
    solver, other = _solver(np.eye(SIZE)), scipy.sparse.csr_matrix(other + SIZE * (other == 1) * np.eye(SIZE))
    with pytest.raises(ComputationError, match="another pattern"):
        solver.set_matrix(other)
    solver.release()
    solver.set_matrix(other)


def test_a_singular_matrix_is_refused():
    values = np.eye(SIZE)
    values[3, 3] = 0
    with pytest.raises(ComputationError, match="factorization failed"):
        _solver(values)


@pytest.fixture
def empty_build(monkeypatch, tmp_path):
    """The folder python/ of a build folder without anything, in which the flow looks for its compiled part."""
    monkeypatch.setenv("VCI_BUILD_DIR", str(tmp_path))
    linear.load_factors.cache_clear()
    (tmp_path / "python").mkdir()
    yield tmp_path / "python"
    linear.load_factors.cache_clear()


def test_a_flow_without_its_compiled_part_is_refused(empty_build):
    with pytest.raises(InputError, match="missing(.|\n)*make build"):
        linear.DirectSolver()


def test_a_compiled_part_that_does_not_load_is_refused(empty_build):
    (empty_build / "flow_factors.so").write_text("of another system\n")
    with pytest.raises(InputError, match="cannot be loaded(.|\n)*make build"):
        linear.DirectSolver()


def _bordered(whole):
    """The BorderedSystem of a dense matrix (SIZE, SIZE) whose last two rows and columns are its border."""
    inner = SIZE - 2
    parts = whole[:inner, inner:], whole[inner:, :inner], whole[inner:, inner:]
    return linear.BorderedSystem(_solver(whole[:inner, :inner]), *parts)


def _split(given):
    return given[: SIZE - 2], given[SIZE - 2 :]


def _error(found, expected):
    return np.abs(np.concatenate(found) - expected).max() / np.abs(expected).max()


def test_the_border_is_solved_for_once(monkeypatch):
    random = np.random.default_rng(2)
    whole, given = random.normal(size=(SIZE, SIZE)), random.normal(size=(SIZE, COUNT))
    bordered, expected, widths = _bordered(whole), np.linalg.solve(whole, given), []
    solve = bordered.solver.solve
    monkeypatch.setattr(bordered.solver, "solve", lambda sides: widths.append(sides.shape[1]) or solve(sides))
    for chosen in (slice(0, 1), slice(1, COUNT)):
        assert _error(bordered.solve(*_split(given[:, chosen])), expected[:, chosen]) < 1e-8
    refinements = len(widths) - 2
    assert widths[0] == 3 and set(widths[1:]) <= {1, COUNT - 1} and 2 <= refinements <= 6


def _badly_conditioned(random, condition):
    """A matrix (SIZE, SIZE) with singular values from 1 to 1 / condition."""
    left, right = (np.linalg.qr(random.normal(size=(SIZE, SIZE)))[0] for _ in range(2))
    return left @ np.diag(np.geomspace(1, 1 / condition, SIZE)) @ right


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("condition, tolerance", [(1e2, 1e-9), (1e4, 1e-7), (1e6, 1e-5)])
def test_refinement_gives_the_digits_that_the_factors_lack(condition, tolerance, seed):
    random = np.random.default_rng(seed)
    whole, given = _badly_conditioned(random, condition), random.normal(size=(SIZE, COUNT))
    bordered, expected = _bordered(whole), np.linalg.solve(whole, given)
    rough = _error(bordered._solve_roughly(*_split(given)), expected)
    assert _error(bordered.solve(*_split(given)), expected) < min(tolerance, 0.01 * rough)


@pytest.mark.parametrize("seed", range(8))
def test_rows_whose_terms_cancel_are_judged_by_these_terms(seed):
    """As where the inflow is given: its change is 0, a sum of terms that are not. Judged by it, none would be small."""
    random = np.random.default_rng(seed)
    whole, f = random.normal(size=(SIZE, SIZE)), random.normal(size=(SIZE - 2, COUNT))
    whole[SIZE - 2 :, SIZE - 2 :] = 0
    bordered, g = _bordered(whole), np.zeros((2, COUNT))
    x, y = bordered.solve(f, g)
    terms = np.abs(bordered.rows) @ np.abs(x)
    assert np.all(np.abs(bordered.rows @ x) <= linear.REFINED_RESIDUAL * terms.max(axis=0))
    assert _error((x, y), np.linalg.solve(whole, np.concatenate([f, g]))) < 1e-8


@pytest.mark.parametrize("seed", range(4))
def test_a_matrix_that_single_precision_cannot_tell_from_a_singular_one_is_refused(seed):
    random = np.random.default_rng(seed)
    whole, given = _badly_conditioned(random, 1e12), random.normal(size=(SIZE, 1))
    bordered = _bordered(whole)
    with pytest.raises(ComputationError, match="linear solve failed"):
        bordered.solve(*_split(given))
    x, y = bordered.solve_for_correction(*_split(given))  # which Newton's method may try
    assert np.isfinite(x).all() and np.isfinite(y).all()
