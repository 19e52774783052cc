"""The flow on one mesh: FlowProblem and its Outcome, what answered, and how it is found."""

import sys

from common.errors import ComputationError
from flow.discretisation import spaces
from flow.geometry import centreline, locate
from flow.physics import ffr, outlets
from flow.solvers import nonlinear

# how far a flow is looked for: on a mesh that only begins the way; by all ways; where the mesh before has an answer,
# from that flow alone
BEGUN, WHOLE, NEAR = "begun", "whole", "near"
# of an answer: steady flow; steady flow with eps > 0, of a modified model
CONVERGED, ARTIFICIAL = STATUSES = ("converged", "converged with artificial viscosity")


class Solved:
    """One mesh with its flow: FlowProblem and its Outcome, error estimate."""

    def __init__(self, path, space, boundaries, problem, outcome):
        self.path, self.space, self.boundaries, self.problem, self.outcome = path, space, boundaries, problem, outcome
        self.artificial = problem.artificial  # eps of the steady flow
        self.estimate, self.cpu_seconds = None, 0.0
        self.sampler = locate.FieldSampler(self.space, self.problem.state.x.array)
        self.outflows = self.boundaries.outflows(self.problem.state_vector())

    @property
    def status(self):
        """One of STATUSES."""
        return ARTIFICIAL if self.problem.artificial > 0 else CONVERGED

    def destroy(self):
        self.problem.destroy()
        self.boundaries.destroy()


def solve_mesh(path, document, settings, tree, predicted, may_stay, before=None, spent=0, effort=WHOLE, start=None):
    """Solved from a mesh file; the guess is that of `before` (Solved on another mesh), else of `predicted` (Predictor).

    may_stay(Solved) -> whether so little artificial viscosity may answer; spent: factorizations already made of those
    allowed; effort: BEGUN, WHOLE or NEAR; start: inputs.solution.Start, the flow of another state, in place of both.
    Raises ComputationError.
    """
    space = spaces.read(path)
    ffr.check_inside(document["probes"], tree, space)
    centreline.check_wall(tree, space.nodes()[0][space.wall_nodes()] / ffr.M_PER_MM, path)
    boundaries = outlets.Boundaries(space, document)
    outlets.check_places(space, document, predicted.tree, path)
    problem = nonlinear.FlowProblem(space, boundaries, document, settings, spent)
    problem.may_stay = lambda: may_stay(Solved(path, space, boundaries, problem, None))
    print(f"{path}: {space.dofs} dofs", file=sys.stderr, flush=True)
    network = predicted.network
    order = [network.names.index(name) for name in boundaries.names]

    def resistances_at(fraction):
        return network.resistances_at(predicted.flows, fraction)[order]

    try:
        outcome = None
        if start is not None:
            outcome = problem.solve_from_state(start)
        elif before is not None:
            outcome = problem.solve_from_guess(before.problem, effort == WHOLE)
        if outcome is None:
            outcome = problem.solve(resistances_at, predicted, effort == BEGUN)
    except ComputationError as error:
        error.factorizations = problem.solver.factorizations
        problem.destroy()
        boundaries.destroy()
        raise
    return Solved(path, space, boundaries, problem, outcome)
