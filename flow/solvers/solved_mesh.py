"""The flow on one mesh: how it is found, and the object with its results that later steps read."""

import sys

from common.errors import ComputationError
from flow.discretisation import spaces
from flow.geometry import centreline
from flow.physics import ffr, outlets
from flow.physics.units import M_PER_MM
from flow.solvers import nonlinear

# Effort on a mesh, eps being the factor of the artificial viscosity (solvers.continuation). EFFORT_EARLY_STOP: finer
# meshes follow, so continuation may end at a large eps. EFFORT_FULL: every way to a flow is tried, with eps as small as
# possible. EFFORT_GUESS_ONLY: the flow on the mesh before is the only start. If it leads to no flow, that flow is the
# answer.
EFFORT_EARLY_STOP, EFFORT_FULL, EFFORT_GUESS_ONLY = "early stop", "full", "guess only"
# Status of an answer. CONVERGED_WITH_VISCOSITY: an eps > 0 is left, so it is the steady flow of a modified model.
CONVERGED, CONVERGED_WITH_VISCOSITY = STATUSES = ("converged", "converged with artificial viscosity")


class SolvedMesh:
    """One mesh with its flow.

    problem: nonlinear.FlowProblem; outcome: newton.Outcome; iterations: factorizations until the flow was found;
    estimate: result of errors.error_estimate.estimate_error, set later; sampler: geometry.locate.FieldSampler.
    outlet_names, outflows in m3/s and pressures in Pa list the outlets in the mesh's order; inflow in m3/s.
    """

    model = "3D Navier-Stokes, Taylor-Hood P2-P1 on quadratic tetrahedra"

    def __init__(self, path, space, boundaries, problem, outcome):
        self.path, self.space, self.boundaries, self.problem, self.outcome = path, space, boundaries, problem, outcome
        self.artificial_viscosity = problem.artificial_viscosity  # eps of the steady flow
        self.iterations, self.estimate, self.cpu_seconds = problem.solver.factorizations, None, 0.0
        self.sampler = space.sampler(problem.state.x.array)
        self.outlet_names, self.inflow = boundaries.outlet_names, problem.inflow
        self.outflows = boundaries.outflows(problem.state.x.array)
        self.pressures = boundaries.pressures(self.outflows)

    @property
    def status(self):
        """One of STATUSES."""
        return CONVERGED_WITH_VISCOSITY if self.problem.artificial_viscosity > 0 else CONVERGED

    def destroy(self):
        """Frees PETSc's memory."""
        self.problem.destroy()


def solve_mesh(
    path, document, settings, tree, predictor, coarser=None, earlier_factorizations=0, effort=EFFORT_FULL, start=None
):
    """Solves the flow on the mesh file `path`, from `start`, else `coarser`, else `predictor`. Returns SolvedMesh.

    document: content of boundary.json; tree: geometry.centreline.Tree without extensions; start:
    inputs.solution.StartState, the flow of another state of the vessel; coarser: SolvedMesh on another mesh; predictor:
    reduced.coupled.Predictor; earlier_factorizations: factorizations made on other meshes; effort: EFFORT_EARLY_STOP,
    EFFORT_FULL or EFFORT_GUESS_ONLY. Raises ComputationError where no flow is found, and InputError where mesh,
    centreline and boundary values do not belong together.
    """
    space = spaces.read(path)
    ffr.check_inside(document["probes"], tree, space)
    centreline.check_wall(tree, space.nodes()[0][space.wall_nodes()] / M_PER_MM, path)
    boundaries = outlets.Boundaries(space, document)
    outlets.check_outlet_places(space, document, predictor.tree, path)
    problem = nonlinear.FlowProblem(space, boundaries, document, settings, earlier_factorizations)
    print(f"{path}: {space.dofs} dofs", file=sys.stderr, flush=True)
    network = predictor.network
    order = [network.outlet_names.index(name) for name in boundaries.outlet_names]

    def resistances_at(fraction):
        return network.resistances_at(predictor.flows, fraction)[order]

    try:
        outcome = None
        if start is not None:
            outcome = problem.solve_from_state(start)
        elif coarser is not None:
            outcome = problem.solve_from_guess(coarser.problem, effort == EFFORT_FULL)
        if outcome is None:
            outcome = problem.solve(resistances_at, predictor, effort == EFFORT_EARLY_STOP)
    except ComputationError as error:
        error.factorizations = problem.solver.factorizations
        problem.destroy()
        raise
    return SolvedMesh(path, space, boundaries, problem, outcome)
