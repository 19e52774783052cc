"""The flow on one mesh: FlowProblem and its Outcome, what answered, and how it is found."""

import sys

from common.errors import ComputationError
from flow.discretisation import mixing, spaces
from flow.geometry import centreline, locate
from flow.physics import ffr, outlets
from flow.solvers import nonlinear

# of an answer: steady flow; steady flow with c > 0, of a modified model; mean over time
CONVERGED, EDDY, UNSTEADY = STATUSES = ("converged", "converged with eddy viscosity", "unsteady")


class Solved:
    """One mesh with its flow: FlowProblem and its Outcome (None: no steady flow), error estimate, march."""

    def __init__(self, path, space, boundaries, problem, outcome):
        self.path, self.space, self.boundaries, self.problem, self.outcome = path, space, boundaries, problem, outcome
        self.mixing = problem.mixing  # c of the steady flow
        self.unsteady = None  # flow.unsteady.Answer where the flow is a mean
        self.estimate, self.marched, self.cpu_seconds = None, False, 0.0
        self.read()

    def read(self):
        """Takes the problem's state as the flow."""
        self.sampler = locate.FieldSampler(self.space, self.problem.state.x.array)
        self.outflows = self.boundaries.outflows(self.problem.state_vector())

    @property
    def known(self):
        """Whether this is a steady flow of the unmodified model whose error is estimated: an answer in itself."""
        return self.status == CONVERGED and self.outcome is not None and self.estimate is not None

    @property
    def status(self):
        """One of STATUSES."""
        if self.unsteady:
            return UNSTEADY
        return EDDY if self.problem.mixing > 0 else CONVERGED

    def destroy(self):
        self.problem.destroy()
        self.boundaries.destroy()


def solve_mesh(path, document, settings, tree, predicted, start=None, spent=0, march=False, near=False):
    """Solved from a mesh file; the guess is that of `start` (Solved on another mesh), else of `predicted` (Predictor).

    spent: factorizations already made of those allowed. march: where there is no steady flow Solved has no outcome.
    near: only a flow that Newton's method finds from `start` is wanted. Raises ComputationError.
    """
    space = spaces.read(path)
    ffr.check_inside(document["probes"], tree, space)
    centreline.check_wall(tree, space.nodes()[0][space.wall_nodes()] / ffr.M_PER_MM, path)
    boundaries = outlets.Boundaries(space, document)
    outlets.check_places(space, document, predicted.tree, path)
    jet_length = mixing.mixing_length(space, tree, settings.jet_spread)
    problem = nonlinear.FlowProblem(space, boundaries, document, settings, jet_length, spent)
    print(f"{path}: {space.dofs} dofs", file=sys.stderr, flush=True)
    network = predicted.network
    order = [network.names.index(name) for name in boundaries.names]

    def resistances_at(fraction):
        return network.resistances_at(predicted.flows, fraction)[order]

    try:
        if start is None:
            outcome = problem.solve(resistances_at, predicted)
        else:
            outcome = problem.solve_from_guess(start.problem, predicted, near or march and start.mixing > 0)
    except ComputationError as error:
        error.factorizations = problem.solver.factorizations
        if not march:
            problem.destroy()
            boundaries.destroy()
            raise
        print(f"{path}: no steady flow, marched in time:\n{error}", file=sys.stderr, flush=True)
        outcome = None
    return Solved(path, space, boundaries, problem, outcome)
