"""Continuation to eps = 0 on small systems: a smooth branch of solutions, one that ends, and one that needs short
steps."""

import io
import types

import numpy as np
import pytest

from common.errors import ComputationError
from flow import settings
from flow.solvers import continuation
from flow.solvers.nonlinear import FlowProblem
from flow_equations import Equations


class _Flow(Equations):
    """Equations that depend on eps, with the other attributes of solvers.nonlinear.FlowProblem that continuation
    uses."""

    def __init__(self, function, jacobian, start):
        super().__init__(
            lambda x: function(x, self.artificial_viscosity), lambda x: jacobian(x, self.artificial_viscosity), start
        )
        self.forms.artificial_viscosity = types.SimpleNamespace(value=0.0)
        self.forms.picard = None  # its step is Newton's, undamped
        self.boundaries = types.SimpleNamespace(set_full_flow=lambda: None)
        self.flows_found, self.log, self.tried = [], io.StringIO(), []
        self.settings = settings.make()

    artificial_viscosity = FlowProblem.artificial_viscosity

    def set_guess(self, space, values, inflow):
        self.state.x.array, self.inflow = np.array(values), inflow

    def stall_error(self, found):
        return ComputationError("the flow solver stalled", "eps", self.artificial_viscosity, "none")


def _smooth():
    """A problem whose solution is x = 2 - eps, for every eps."""
    tangent = lambda x, eps: np.diag(1 + x * (3 * x - 4 + 2 * eps))  # noqa: E731
    return _Flow(lambda x, eps: (x - 2 + eps) * (1 + x**2), tangent, [1.5])


def _ends(least):
    """A problem with the solution x = 2 + sqrt(eps - least). Below eps = least it has no solution."""

    def tangent(x, eps):
        return np.diag(2 * (x - 2) + 1e-9)  # 1e-9 keeps it regular where the branch of solutions ends

    return _Flow(lambda x, eps: (x - 2) ** 2 + least - eps, tangent, [4.0])


def _steep(width):
    """A problem whose solution changes from 1 to 3 while ln eps changes by about `width`, around eps = .03.

    There Newton's method needs a near guess.
    """

    def function(x, eps):
        return np.sinh(4 * (x - 2 + np.tanh(np.log(max(eps, 1e-12) / 0.03) / width)))

    def tangent(x, eps):
        return np.diag(4 * np.hypot(1, function(x, eps)))

    return _Flow(function, tangent, [1.0])


def test_a_smooth_branch_is_followed_to_none():
    problem = _smooth()
    found = continuation.from_rest(problem)
    assert found.converged and problem.artificial_viscosity == 0.0
    assert problem.state.x.array == pytest.approx([2.0], abs=1e-8)


def test_a_mesh_that_begins_the_way_may_find_a_flow_without_any():
    problem = _smooth()
    assert continuation.from_rest(problem, stop_early=True).converged and problem.artificial_viscosity == 0.0


def test_a_mesh_that_begins_the_way_ends_early_and_another_goes_on():
    coarse, fine = _ends(0.004), _ends(0.004)
    assert (
        continuation.from_rest(coarse, stop_early=True).converged
        and coarse.artificial_viscosity == continuation.COARSE_MESH_EPS
    )
    assert [one[0] for one in coarse.flows_found][-1] == continuation.COARSE_MESH_EPS
    coarse.space = fine.space
    assert continuation.from_guess(fine, coarse).converged
    assert (
        fine.flows_found[0][0] == continuation.COARSE_MESH_EPS
        and 0.004 <= fine.artificial_viscosity < continuation.SMALL_EPS
    )


def test_where_the_branch_ends_its_least_flow_answers():
    problem = _ends(0.02)
    found = continuation.from_rest(problem)
    assert found.converged and 0.02 <= problem.artificial_viscosity < 0.03
    assert abs(problem.state.x.array[0] - 2) == pytest.approx(np.sqrt(problem.artificial_viscosity - 0.02), abs=1e-4)
    assert [one[0] for one in problem.flows_found] == sorted((one[0] for one in problem.flows_found), reverse=True)


def test_a_branch_that_ends_early_is_refused():
    with pytest.raises(ComputationError, match="stalled"):
        continuation.from_rest(_ends(0.08))


def test_a_flow_that_is_not_found_at_the_first_eps_is_refused():
    with pytest.raises(ComputationError, match="stalled"):
        continuation.from_rest(_ends(3.0))


def test_steps_are_shortened_where_the_flow_changes_fast():
    far, near = _steep(3.0), _steep(0.2)
    for problem in (far, near):
        continuation.from_rest(problem)
        assert problem.artificial_viscosity == 0.0 and problem.state.x.array == pytest.approx([3.0], abs=1e-6)
    assert len(near.flows_found) > len(far.flows_found)


def test_the_factorizations_allowed_bound_the_way():
    problem = _steep(0.2)
    problem.allowed_factorizations = 14
    try:
        continuation.from_rest(problem)
    except ComputationError:
        pass
    assert problem.solver.factorizations <= 14


def test_the_last_bit_of_the_way_is_gone_again_on_a_finer_mesh():
    coarse, fine = _smooth(), _smooth()
    continuation.from_rest(coarse)
    coarse.space = fine.space
    found = continuation.from_guess(fine, coarse)
    assert found.converged and fine.artificial_viscosity == 0.0
    assert fine.flows_found[0][0] == coarse.flows_found[-2][0] > 0 and len(fine.flows_found) == 2


@pytest.mark.parametrize("lower_further", (True, False))
def test_what_the_other_mesh_left_behind_from_a_large_eps_is_left_behind_from_there(lower_further):
    coarse, fine = _smooth(), _smooth()
    coarse.flows_found = [(0.02, np.array([1.98]), 0.0), (0.0, np.array([2.0]), 0.0)]
    found = continuation.from_guess(fine, coarse, lower_further)
    assert found.converged and [one[0] for one in fine.flows_found] == [0.02, 0.0]


def test_a_flow_of_another_mesh_that_no_path_led_to_is_the_start():
    coarse, fine = _smooth(), _smooth()
    coarse.state.x.array, coarse.space = np.array([2.0]), fine.space
    found = continuation.from_guess(fine, coarse)
    assert found.converged and fine.artificial_viscosity == 0.0


def test_a_finer_mesh_begins_at_the_eps_of_the_other_and_may_do_without():
    coarse, fine = _ends(0.015), _smooth()
    continuation.from_rest(coarse)
    found = continuation.from_guess(fine, coarse)
    assert (
        found.converged
        and fine.flows_found[0][0] == coarse.artificial_viscosity >= 0.015
        and fine.artificial_viscosity == 0.0
    )


def test_the_finest_mesh_keeps_the_eps_of_the_other():
    coarse, fine = _ends(0.015), _smooth()
    continuation.from_rest(coarse)
    found = continuation.from_guess(fine, coarse, lower_further=False)
    assert found.converged and fine.artificial_viscosity == coarse.artificial_viscosity >= 0.015


def test_where_the_last_flow_of_another_mesh_leads_to_none_those_before_do():
    coarse, fine = _smooth(), _ends(0.01)
    coarse.flows_found = [(eps, np.array([2.1]), 0.0) for eps in (0.02, 0.004, 0.0)]
    found = continuation.from_guess(fine, coarse)
    assert found.converged and fine.flows_found[0][0] <= 0.02 and fine.artificial_viscosity >= 0.01
