"""Newton's method on small systems of equations: damping, accelerated steps, and its limits."""

import numpy as np
import pytest

from flow.solvers import newton
from flow_equations import Equations


def test_steps_are_damped_where_whole_ones_diverge():
    problem = Equations(np.arctan, lambda x: np.diag(1 / (1 + x**2)), [3.0])  # undamped steps diverge beyond 1.39
    found = newton.newton(problem, 1e-12, 12)
    assert found.converged and found.iterations <= 7
    assert problem.state.x.array[0] == pytest.approx(0.0, abs=1e-12)


def test_residual_may_rise_where_the_correction_falls():
    problem = Equations(
        lambda x: [1e4 * (x[1] - x[0] ** 2), 1 - x[0]], lambda x: [[-2e4 * x[0], 1e4], [-1, 0]], [-0.2, 1.0]
    )
    at_start = problem.residual()[2]
    found = newton.newton(problem, 1e-9, 12)
    assert problem.norms[0] > at_start
    assert found.converged and found.iterations <= 6


def test_near_the_solution_one_factorization_serves_several_steps(monkeypatch):
    rng = np.random.default_rng(2)
    mixing = np.eye(6) + 0.1 * rng.normal(size=(6, 6))

    def solve():
        problem = Equations(lambda x: mixing @ x + 0.3 * x**2 - 1, lambda x: mixing + np.diag(0.6 * x), np.ones(6))
        return problem, newton.newton(problem, 1e-12, 12)

    problem, found = solve()
    monkeypatch.setattr(newton, "REUSE_FOR_STEPS", 0.0)
    other, reached = solve()
    assert found.converged and problem.said.count("accelerated") >= 2
    assert "accelerated" not in other.said and found.iterations < reached.iterations
    assert problem.state.x.array == pytest.approx(other.state.x.array, abs=1e-11)


def test_an_accelerated_step_that_makes_it_worse_is_taken_back():
    problem = Equations(lambda x: np.where(x > 0.5, x, 1e3), lambda x: np.eye(1), [0.4])
    problem.linearise(None)
    problem.state.x.array = np.array([1.0])
    step = newton.DampedStep(4.0, 1.0, np.array([-0.9]), 0.0, 1.0)
    *_, norm = newton._accelerate(problem, problem.residual(), (np.ones(2) * 5, np.ones(2)), step, 1e-9)
    assert norm == 1.0 and problem.state.x.array == pytest.approx([1.0])


def test_no_root_is_given_up():
    problem = Equations(lambda x: x**2 + 1, lambda x: np.diag(2 * x), [2.0])
    found = newton.newton(problem, 1e-9, 40)
    assert not found.converged and found.iterations < 40
    assert np.isfinite(problem.state.x.array).all()


def test_no_more_factorizations_than_allowed():
    problem = Equations(np.arctan, lambda x: np.diag(1 / (1 + x**2)), [3.0])
    problem.allowed_factorizations = 2
    found = newton.newton(problem, 1e-12, 12)
    assert not found.converged and problem.solver.factorizations == 2


def test_whole_steps_that_serve_may_take_twice_as_many_factorizations(monkeypatch):
    """x^2 = 0 has a double root, so each undamped step only halves the error."""
    monkeypatch.setattr(newton, "REUSE_FOR_STEPS", 0.0)  # no accelerated steps

    def found(limit):
        problem = Equations(lambda x: x**2, lambda x: np.diag(2 * x), [1.0])
        return newton.newton(problem, 1e-6, limit)

    assert found(10).iterations == 10 and found(5).iterations == 10 and found(5).converged
    assert not found(4).converged and found(4).iterations == 8


@pytest.mark.parametrize(
    ("factors", "made"), [((0.1, 0.14, 1, 1), 2), ((0.1, 0.3, 0.1, 0.3), 4), ((0.14, 0.16, 0.1, 0.1, 1), 4)]
)
def test_two_tiny_steps_in_a_row_are_the_last(monkeypatch, factors, made):
    problem, left = Equations(lambda x: x, lambda x: np.eye(1), [1.0]), list(factors)

    def search(problem, residual_at, update, factor, norm):
        factor = left.pop(0)
        return newton.DampedStep(1.0, 1.0, update, 0.0, factor), residual_at(0.1 * factor)

    monkeypatch.setattr(newton, "_search_factor", search)
    assert newton.newton(problem, 1e-9, 4).iterations == made
