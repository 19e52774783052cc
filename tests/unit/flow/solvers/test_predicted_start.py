"""The start of Newton's method from the flow of the reduced models: when it is used, and which steps follow."""

import io
import types

import numpy as np
import pytest

from flow import settings
from flow.solvers import newton, predicted_start


class _Problem:
    """The part of solvers.nonlinear.FlowProblem that predicted_start uses."""

    def __init__(self, left=100):
        self.taken, self.factorizations_left, self.log, self.settings = None, left, io.StringIO(), settings.make()
        self.boundaries = types.SimpleNamespace(set_full_flow=lambda: None)
        self.forms = types.SimpleNamespace(artificial_viscosity=types.SimpleNamespace(value=0.4))
        self.space = types.SimpleNamespace(nodes=lambda: (np.zeros((2, 3)), None))
        self.solver = types.SimpleNamespace(factorizations=0)

    def set_flow(self, velocity, pressure, inflow):
        self.taken = inflow

    def residual(self):
        return np.zeros(2), 0.0, 1.0


def _predicted(whole, value):
    return types.SimpleNamespace(
        covers_lumen=whole,
        flows=np.array([2.0, 1.0]),
        network_pressures=None,
        ffr=lambda pressures: value,
        fields=lambda points: (np.zeros((2, 3)), np.zeros(2)),
    )


@pytest.fixture
def steps(monkeypatch):
    """Names of the methods in the order in which they are called."""
    called = []

    def picard(problem, free, inlet):
        called.append("picard")
        problem.solver.factorizations += 1
        return problem.residual()

    def solve(problem, tolerance_n, limit):
        called.append("newton")
        problem.solver.factorizations += 3
        return types.SimpleNamespace(converged=True)

    monkeypatch.setattr(newton, "picard", picard)
    monkeypatch.setattr(newton, "newton", solve)
    return called


@pytest.mark.parametrize(
    ("whole", "value", "expected"),
    [
        (True, 0.5, ["newton"]),
        (False, 0.97, ["picard", "picard", "newton"]),
        (False, 0.9, []),
    ],
)
def test_the_start_depends_on_tree_and_loss(steps, whole, value, expected):
    problem = _Problem()
    found = predicted_start.try_predicted_flow(problem, _predicted(whole, value))
    assert steps == expected
    assert (found is None) == (not expected)
    assert problem.taken == (3.0 if expected else None)
    assert problem.forms.artificial_viscosity.value == (0.0 if expected else 0.4)
    assert problem.solver.factorizations == (len(expected) - 1 + 3 if found else 0)


def test_no_picard_step_without_a_factorization_left(steps):
    predicted_start.try_predicted_flow(_Problem(left=0), _predicted(False, 0.97))
    assert steps == ["newton"]
