"""The flow on one mesh: how it is found, and the object with its results that later steps read."""

import sys

from common.errors import ComputationError
from flow.discretisation import spaces
from flow.geometry import centreline, locate
from flow.physics import ffr, outlets
from flow.physics.units import M_PER_MM
from flow.solvers import nonlinear

# Effort on a mesh, eps being the factor of the artificial viscosity (solvers.continuation). BEGUN: finer meshes follow,
# so continuation may end at a large eps. WHOLE: every way to a flow is tried, with eps as small as possible. NEAR: the
# flow on the mesh before is the only start, since that mesh can answer if this one finds no flow.
BEGUN, WHOLE, NEAR = "begun", "whole", "near"
# Status of an answer. ARTIFICIAL: an eps > 0 is left, so it is the steady flow of a modified model.
CONVERGED, ARTIFICIAL = STATUSES = ("converged", "converged with artificial viscosity")


class Solved:
    """One mesh with its flow.

    problem: nonlinear.FlowProblem; outcome: nonlinear.Outcome; estimate: errors.error_estimate.of, set later; sampler:
    locate.FieldSampler. names, outflows in m3/s, pressures in Pa: of the outlets, in the mesh's order; inflow in m3/s.
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
        """Frees PETSc's memory."""
        self.problem.destroy()
        self.boundaries.destroy()


def solve_mesh(path, document, settings, tree, predicted, before=None, spent=0, effort=WHOLE, start=None):
    """Solves the flow on the mesh file `path`, from `start`, else from `before`, else from `predicted`. Returns Solved.

    document: of boundary.json; tree: geometry.centreline.Tree without extensions; start: inputs.solution.Start, the
    flow of another state of the vessel; before: Solved on another mesh; predicted: reduced.coupled.Predictor; spent:
    factorizations made on other meshes; effort: BEGUN, WHOLE or NEAR. Raises ComputationError where no flow is found,
    and InputError where mesh, centreline and boundary values do not belong together.
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
