"""Newton's damping on small systems of equations, and the fading of c on a problem that loses its flow below some c."""

import io
import types

import numpy as np
import pytest

from common.errors import ComputationError
from flow import settings
from flow.solvers import fading, newton, anderson


class _Vector:
    def __init__(self, values):
        self.values = values

    def destroy(self):
        """As PETSc's vectors."""


class _Equations:
    """F(x) = 0 with the methods of solvers.nonlinear.FlowProblem that Newton's method uses."""

    def __init__(self, function, jacobian, start):
        self.function, self.jacobian, self.norms = function, jacobian, []
        self.state = types.SimpleNamespace(x=types.SimpleNamespace(array=np.array(start, float)))
        self.inflow = 0.0
        self.solver = types.SimpleNamespace(factorizations=0)
        self.forms = types.SimpleNamespace(tangent=None)
        self.space = types.SimpleNamespace(free=slice(None))
        self.allowed, self.said = 100, []

    def acceleration(self):
        return anderson.Acceleration(np.append(np.ones(len(self.state.x.array)), 0.0))

    def outdate(self):
        self.said.append("outdated")

    @property
    def left(self):
        return self.allowed - self.solver.factorizations

    def residual(self):
        values = np.array(self.function(self.state.x.array), float)
        return _Vector(values), 0.0, float(np.linalg.norm(values))

    def linearise(self, form):
        self.solver.factorizations += 1
        self.matrix = np.array(self.jacobian(self.state.x.array), float)

    def correction(self, residual, inlet):
        return -np.linalg.solve(self.matrix, residual.values), 0.0

    def move(self, base, base_inflow, update, inflow_update, factor):
        self.state.x.array = base + factor * update

    def speed(self, update):
        return float(np.linalg.norm(update))

    def small(self, norm, absolute, relative):
        return norm <= absolute

    def outcome(self, norm, absolute, relative, iterations):
        return types.SimpleNamespace(converged=self.small(norm, absolute, relative), iterations=iterations)

    def report(self, norm, kind):
        self.norms.append(norm)
        self.said.append(kind)


def test_steps_are_damped_where_whole_ones_diverge():
    problem = _Equations(np.arctan, lambda x: np.diag(1 / (1 + x**2)), [3.0])  # diverges undamped from beyond 1.39
    found = newton.newton(problem, 1e-12, 1.0, 12)
    assert found.converged and found.iterations <= 7
    assert problem.state.x.array[0] == pytest.approx(0.0, abs=1e-12)


def test_residual_may_rise_where_the_correction_falls():
    problem = _Equations(
        lambda x: [1e4 * (x[1] - x[0] ** 2), 1 - x[0]], lambda x: [[-2e4 * x[0], 1e4], [-1, 0]], [-0.2, 1.0]
    )
    at_start = problem.residual()[2]
    found = newton.newton(problem, 1e-9, 1.0, 12)
    assert problem.norms[0] > at_start
    assert found.converged and found.iterations <= 6


def test_near_the_solution_one_factorization_serves_several_steps():
    rng = np.random.default_rng(2)
    mixing = np.eye(6) + 0.1 * rng.normal(size=(6, 6))

    def solve(exact):
        problem = _Equations(lambda x: mixing @ x + 0.3 * x**2 - 1, lambda x: mixing + np.diag(0.6 * x), np.ones(6))
        return problem, newton.newton(problem, 1e-12, 1.0, 12, exact=exact)

    (problem, found), (other, reached) = solve(False), solve(True)
    assert found.converged and problem.said.count("accelerated") >= 2
    assert "accelerated" not in other.said and found.iterations < reached.iterations
    assert problem.state.x.array == pytest.approx(other.state.x.array, abs=1e-11)


def test_an_accelerated_step_that_makes_it_worse_is_taken_back():
    problem = _Equations(lambda x: np.where(x > 0.5, x, 1e3), lambda x: np.eye(1), [0.4])
    problem.linearise(None)
    problem.state.x.array = np.array([1.0])
    step = newton.Step(4.0, 1.0, np.array([-0.9]), 0.0, 1.0)
    *_, norm = newton._go_on(problem, problem.residual(), (np.ones(2) * 5, np.ones(2)), step, (1e-9, 1.0))
    assert norm == 1.0 and problem.state.x.array == pytest.approx([1.0])


def test_no_root_is_given_up():
    problem = _Equations(lambda x: x**2 + 1, lambda x: np.diag(2 * x), [2.0])
    found = newton.newton(problem, 1e-9, 1.0, 40)
    assert not found.converged and found.iterations < 40
    assert np.isfinite(problem.state.x.array).all()


def test_no_more_factorizations_than_allowed():
    problem = _Equations(np.arctan, lambda x: np.diag(1 / (1 + x**2)), [3.0])
    problem.allowed = 2
    found = newton.newton(problem, 1e-12, 1.0, 12)
    assert not found.converged and problem.solver.factorizations == 2


class _Jet:
    """A problem whose flow, the single number c^2, exists for c of at least `least`."""

    def __init__(self, least):
        self.least, self.log, self.passed, self.tried = least, io.StringIO(), [], []
        self.state = types.SimpleNamespace(x=types.SimpleNamespace(array=np.zeros(1)))
        self.inflow = 0.0
        self.settings = settings.make()
        self.solver = types.SimpleNamespace(factorizations=0)
        self.forms = types.SimpleNamespace(mixing=types.SimpleNamespace(value=0.0))

    @property
    def left(self):
        return self.settings.max_newton_iterations - self.solver.factorizations

    @property
    def mixing(self):
        return self.forms.mixing.value

    def stalled(self, found):
        return ComputationError("the flow solver stalled", "jet", self.mixing, "none")


@pytest.fixture
def fade_from(monkeypatch):
    """fade_from(least, known) -> (_Jet, Outcome) after fading.from_guess."""

    def solve(problem, absolute, relative, limit):
        problem.solver.factorizations += 2
        problem.tried.append(problem.mixing)
        converged = problem.mixing >= problem.least
        if converged:
            problem.state.x.array = np.array([problem.mixing**2])
        return types.SimpleNamespace(converged=converged)

    monkeypatch.setattr(newton, "newton", solve)
    monkeypatch.setattr(fading, "settle", lambda problem: None)

    def run(least, known):
        problem = _Jet(least)
        return problem, fading.from_guess(problem, known)

    return run


def test_a_flow_without_mixing_is_taken_at_once(fade_from):
    problem, found = fade_from(0.0, 0.0)
    assert found.converged and problem.mixing == 0.0
    assert problem.tried == [0.0, 0.0]


def test_c_is_kept_where_the_flow_is_lost(fade_from):
    problem, found = fade_from(0.14, 0.18)
    assert found.converged and 0.14 <= problem.mixing < 0.18
    assert found.iterations == problem.solver.factorizations
    assert [c for c, _, _ in problem.passed] == sorted((c for c, _, _ in problem.passed), reverse=True)
    assert problem.state.x.array[0] == pytest.approx(problem.mixing**2)
    assert sum(c < 0.14 for c in problem.tried) <= fading.LOST


def test_the_only_flow_gets_a_neighbour_for_the_estimate(fade_from):
    problem, _ = fade_from(0.119, 0.12)
    assert problem.mixing == 0.12
    assert [c for c, _, _ in problem.passed] == pytest.approx([0.18, 0.12])
    assert problem.state.x.array[0] == pytest.approx(0.12**2)


def test_a_flow_at_large_c_only_is_refused(fade_from):
    with pytest.raises(ComputationError, match="stalled"):
        fade_from(0.3, 0.12)
