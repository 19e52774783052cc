"""The flow on one mesh: how it is found, and the record of it that later steps read."""

import sys

from common.errors import ComputationError
from flow.discretisation import spaces
from flow.geometry import centreline, locate
from flow.physics import ffr, outlets
from flow.physics.units import M_PER_MM
from flow.solvers import nonlinear

# Effort on a mesh. BEGUN: finer meshes follow, so a large eps may be left. WHOLE: every way is tried. NEAR: only from
# the flow on the mesh before, which can answer itself.
BEGUN, WHOLE, NEAR = "begun", "whole", "near"
# Status of an answer. With eps > 0 left it is the steady flow of a modified model.
CONVERGED, ARTIFICIAL = STATUSES = ("converged", "converged with artificial viscosity")


class Solved:
    """One mesh with its flow: FlowProblem and its Outcome, error estimate.

    names, outflows in m3/s, pressures in Pa: of the outlets, in the mesh's order; inflow in m3/s.
    """

    model = "3D Navier-Stokes, Taylor-Hood P2-P1 on quadratic tetrahedra"

    def __init__(self, path, space, boundaries, problem, outcome):
        self.path, self.space, self.boundaries, self.problem, self.outcome = path, space, boundaries, problem, outcome
        self.artificial = problem.artificial  # eps of the steady flow
        self.estimate, self.cpu_seconds = None, 0.0
        self.sampler = locate.FieldSampler(self.space, self.problem.state.x.array)
        self.names, self.inflow = boundaries.names, problem.inflow
        self.outflows = self.boundaries.outflows(self.problem.state_vector())
        self.pressures = boundaries.pressures(self.outflows)

    @property
    def status(self):
        """One of STATUSES."""
        return ARTIFICIAL if self.problem.artificial > 0 else CONVERGED

    def destroy(self):
        self.problem.destroy()
        self.boundaries.destroy()


def solve_mesh(path, document, settings, tree, predicted, before=None, spent=0, effort=WHOLE, start=None):
    """Solved from a mesh file. The first guess is the flow of `start`, else of `before`, else of `predicted`.

    start: inputs.solution.Start, of another state; before: Solved on another mesh; predicted: coupled.Predictor.
    spent: factorizations made on other meshes; effort: BEGUN, WHOLE or NEAR. Raises ComputationError where no flow is
    found, and InputError where mesh, centreline and boundary values do not belong together.
    """
    space = spaces.read(path)
    ffr.check_inside(document["probes"], tree, space)
    centreline.check_wall(tree, space.nodes()[0][space.wall_nodes()] / M_PER_MM, path)
    boundaries = outlets.Boundaries(space, document)
    outlets.check_places(space, document, predicted.tree, path)
    problem = nonlinear.FlowProblem(space, boundaries, document, settings, spent)
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
