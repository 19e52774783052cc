"""Parts of FFR's error by a dual solution for each probe: errors.error_field finds them by a field for each stretch.

K^T z = dJ/dw is solved for z, z is recovered, and the residual is weighted by the recovered less the interpolated z.
"""

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc

from flow.discretisation import compat, spaces
from flow.errors.error_field import interpolate_state, dof_points, richer_residual, stretch_numbers
from flow.errors.recovery import Patches
from flow.physics.units import M_PER_MM


def error_parts(solved, document, tree):
    """Estimated parts (p, k) of FFR's error at each of the document's p probes, computed minus true, by the k stretches
    of the tree that they arise in; their sum estimates the error. solved: solvers.solved_mesh.SolvedMesh."""
    problem, space = solved.problem, solved.space
    points = [tuple(probe["point_mm"]) for probe in document["probes"]]
    probes = {point: probe for point, probe in zip(points, document["probes"])}  # some share a place
    duals = []
    for probe in probes.values():
        goal = _goal(problem, document, tree, probe)
        duals.append(dual(problem, goal))
        goal.destroy()
    richer = spaces.LumenSpace(space.mesh, space.facet_tags, degree=space.degree + 1)
    weights = _recovered(space, richer, duals)
    held = np.concatenate([richer.wall_dofs, richer.inlet_dofs])
    weights[:, held] = 0.0
    loads = richer_residual(problem, richer, document)
    parts = loads.array * weights
    loads.destroy()
    stretch = stretch_numbers(tree)[tree.nearest(dof_points(richer) / M_PER_MM)[0]]
    found = dict(zip(probes, (np.bincount(stretch, one) for one in parts)))
    return np.array([found[point] for point in points])


def dual(problem, goal):
    """Values (n,) over W of z with K^T z = goal; K: the last tangent of `problem`, goal: vector over W."""
    if problem.bordered is None or problem.linearised_as != (True, problem.artificial_viscosity):
        problem.linearise(problem.forms.tangent)
    bordered, space = problem.bordered, problem.space

    def solved(right):
        found = right.duplicate()
        bordered.solver.ksp.solveTranspose(right, found)
        return found

    border = [solved(row) for row in bordered.rows]
    schur = np.array(bordered.corner, float).T
    schur -= [[column.dot(vector) for vector in border] for column in bordered.columns]
    z = solved(problem.free_part(goal))
    on_border = np.linalg.solve(schur, [-column.dot(z) for column in bordered.columns])
    z.maxpy(-on_border, border)
    values = np.zeros(space.dofs)
    values[space.free_dofs] = z.array_r
    if problem.boundaries.inflow is None:
        values[space.inlet_dofs] = problem.boundaries.profile.x.array[space.inlet_dofs] * on_border[0]
    return values


def _goal(problem, document, tree, probe):
    """Vector over W: derivative of a probe's FFR, its pressure averaged over a ball of about the vessel's radius.

    Where the inflow is given FFR is over the pressure at the inlet's centre, which changes too.
    """
    branch = tree[probe["branch"]]
    s_mm, _ = branch.project(np.array(probe["point_mm"]))
    at_probe, pressure = _mean_pressure(problem, branch.point(s_mm), branch.radius(s_mm))
    if document.get("inlet_flow_m3_per_s") is None:
        at_probe.scale(1.0 / document["map_pa"])
        return at_probe
    at_inlet, reference = _mean_pressure(problem, tree.main.point(0.0), tree.main.radius(0.0))
    at_probe.axpy(-pressure / reference, at_inlet)
    at_probe.scale(1.0 / reference)
    at_inlet.destroy()
    return at_probe


def _mean_pressure(problem, point_mm, radius_mm):
    """(vector over W whose product with a state is the mean pressure round a point, that mean in Pa)."""
    space = problem.space
    window = fem.Function(space.Q)
    gap = space.Q.tabulate_dof_coordinates() - M_PER_MM * point_mm
    window.x.array[:] = np.exp(-np.sum(gap**2, axis=1) / (M_PER_MM * radius_mm) ** 2)
    _, q = ufl.TestFunctions(space.W)
    mean = fem_petsc.assemble_vector(compat.form(window * q * ufl.dx))
    mean.scale(1.0 / fem.assemble_scalar(compat.form(window * ufl.dx)))
    return mean, float(mean.dot(problem.state_vector()))


def _recovered(space, richer, duals):
    """Recovered minus interpolated dual solutions in the richer space, (d, n) values over its W; duals: d arrays of
    values over W, fitted together."""
    nodes, cells = space.nodes()
    velocity, pressure = np.zeros((len(nodes), 3 * len(duals))), np.zeros((len(nodes), len(duals)))
    for d, dual in enumerate(duals):
        velocity[:, 3 * d : 3 * d + 3] = dual[space.v_map].reshape(-1, 3)
        pressure[cells[:, :4], d] = dual[space.q_map][compat.cell_dofs(space.Q)]
    fields = [
        (space.degree + 1, cells, velocity, richer.V.tabulate_dof_coordinates(), compat.cell_dofs(richer.V)),
        (space.degree, cells[:, :4], pressure, richer.Q.tabulate_dof_coordinates(), compat.cell_dofs(richer.Q)),
    ]
    smooth_velocity, smooth_pressure = Patches(nodes, cells).recover(fields)
    difference = np.zeros((len(duals), richer.dofs))
    for d, dual in enumerate(duals):
        difference[d, richer.v_map] = smooth_velocity[:, 3 * d : 3 * d + 3].ravel()
        difference[d, richer.q_map] = smooth_pressure[:, d]
        difference[d] -= interpolate_state(space, richer, dual)
    return difference
