"""The order in which FlowProblem tries its ways to a flow. The outcome of each way is made up."""

import types

import pytest

from common.errors import ComputationError
from flow.solvers import nonlinear

CONVERGED, FAILED = (types.SimpleNamespace(converged=done, iterations=0) for done in (True, False))
TUBE, TREE = (types.SimpleNamespace(covers_lumen=whole) for whole in (True, False))


class _Problem:
    """The part of FlowProblem that its ways to a flow use. gone: names of the ways that were tried."""

    def __init__(self):
        self.gone, self.flows_found, self.solver = [], [(0.1, None, 0.0)], types.SimpleNamespace(factorizations=7)

    solve, solve_from_guess = nonlinear.FlowProblem.solve, nonlinear.FlowProblem.solve_from_guess

    def set_to_rest(self):
        self.gone.append("rest")

    def stall_error(self, found):
        return ComputationError("the flow solver stalled", "here", 0, "none")


@pytest.fixture
def ways(monkeypatch):
    """ways(predicted, ramp, from_guess) makes a problem on which each way ends as given. None: the way is not tried, or
    fails."""

    def make(predicted=None, ramp=FAILED, guess=None):
        problem = _Problem()

        def way(name, found):
            def go(*_):
                problem.gone.append(name)
                if found is None:
                    raise ComputationError("the flow solver stalled", name, 0, "none")
                return found

            return go

        monkeypatch.setattr(nonlinear.predicted_start, "try_predicted_flow", lambda *_: predicted)
        monkeypatch.setattr(nonlinear.ramp, "raise_flow", way("ramp", ramp))
        monkeypatch.setattr(nonlinear.continuation, "from_rest", way("eps", CONVERGED))
        monkeypatch.setattr(nonlinear.continuation, "from_guess", way("guess", guess))
        return problem

    return make


@pytest.mark.parametrize(
    ("lumen", "predicted", "ramp", "stop_early", "gone"),
    [
        (TUBE, CONVERGED, FAILED, False, []),
        (TUBE, FAILED, CONVERGED, False, ["rest", "ramp"]),
        (TUBE, FAILED, FAILED, False, ["rest", "ramp", "rest", "eps"]),
        (TUBE, CONVERGED, FAILED, True, []),
        (TREE, CONVERGED, FAILED, False, []),
        (TREE, FAILED, CONVERGED, False, ["rest", "eps"]),
        (TREE, None, CONVERGED, True, ["rest", "eps"]),
    ],
)
def test_each_way_follows_the_one_that_failed(ways, lumen, predicted, ramp, stop_early, gone):
    problem = ways(predicted, ramp)
    assert problem.solve(None, lumen, stop_early) is CONVERGED and problem.gone == gone


def test_a_tube_whose_mesh_only_begins_is_given_up_after_one_way(ways):
    problem = ways(FAILED, CONVERGED)
    with pytest.raises(ComputationError, match="stalled"):
        problem.solve(None, TUBE, stop_early=True)
    assert problem.gone == []


def test_a_guess_that_leads_nowhere_leaves_the_problem_at_rest(ways):
    problem = ways(guess=None)
    assert problem.solve_from_guess(None, full_effort=True) is None
    assert problem.gone == ["guess", "rest"] and problem.flows_found == []
    with pytest.raises(ComputationError, match="stalled"):
        problem.solve_from_guess(None)
    assert ways(guess=CONVERGED).solve_from_guess(None, full_effort=True) is CONVERGED
