"""Parts of FFR's error, from a dual solution for each probe: a second way for tests of errors.error_field.

errors.error_field computes the same parts from an error field for each stretch of the tree. Here the dual problem
K^T z = dJ/dw is solved for each probe. Patch recovery makes a smoother z. The residual is weighted by the recovered
minus the interpolated z.
"""

import numpy as np
import ufl
from dolfinx import fem

from flow.discretisation import compat, spaces
from flow.errors import recovery
from flow.errors.error_field import dof_points, richer_residual, stretch_numbers
from flow.physics.units import M_PER_MM
from flow.solvers import linear


def error_parts(solved, document, tree):
    """Parts (p, k) of the estimated error of FFR, computed minus true, for p probes and k stretches of the tree.

    A part is the error that arises in its stretch. The sum over the stretches estimates the error at a probe.
    solved: solvers.solved_mesh.SolvedMesh; document: as boundary.json.
    """
    problem, space = solved.problem, solved.space
    points = [tuple(probe["point_mm"]) for probe in document["probes"]]
    probes = {point: probe for point, probe in zip(points, document["probes"])}  # several probes may share a place
    duals = [dual(problem, _goal(problem, document, tree, probe)) for probe in probes.values()]
    richer = spaces.LumenSpace(space.mesh, space.facet_tags, degree=space.degree + 1)
    weights = _recovered(space, richer, duals)
    held = np.concatenate([richer.wall_dofs, richer.inlet_dofs])
    weights[:, held] = 0.0
    interpolated = interpolate_state(space, richer, problem.state.x.array)
    parts = richer_residual(problem, richer, interpolated, document) * weights
    stretch = stretch_numbers(tree)[tree.nearest(dof_points(richer) / M_PER_MM)[0]]
    found = dict(zip(probes, (np.bincount(stretch, one) for one in parts)))
    return np.array([found[point] for point in points])


def dual(problem, goal):
    """Values (n,) over W of z with K^T z = goal (n,), where K is the last tangent of `problem`."""
    if problem.bordered is None or problem.linearised_as != (True, problem.artificial_viscosity):
        problem.linearise(problem.forms.tangent)
    bordered, space, solver = problem.bordered, problem.space, linear.DirectSolver()
    solver.set_matrix(problem.matrix.matrix.T.tocsr())
    transposed = linear.BorderedSystem(solver, bordered.rows.T, bordered.columns.T, bordered.corner.T)
    z, on_border = transposed.solve(goal[space.free_dofs, None], np.zeros((len(bordered.rows), 1)))
    values = np.zeros(space.dofs)
    values[space.free_dofs] = z[:, 0]
    values[space.inlet_dofs] = problem.boundaries.profile[space.inlet_dofs] * on_border[0, 0]
    return values


def _goal(problem, document, tree, probe):
    """Values (n,) over W: the derivative of a probe's FFR. The probe's pressure is a Gaussian average over about the
    vessel's width."""
    branch = tree[probe["branch"]]
    s_mm, _ = branch.project(np.array(probe["point_mm"]))
    point, space = branch.point(s_mm), problem.space
    window = fem.Function(space.Q)
    gap = space.Q.tabulate_dof_coordinates() - M_PER_MM * point
    window.x.array[:] = np.exp(-np.sum(gap**2, axis=1) / (M_PER_MM * branch.radius(s_mm)) ** 2)
    _, q = ufl.TestFunctions(space.W)
    mean = compat.assemble(compat.form(window * q * ufl.dx))
    return mean / fem.assemble_scalar(compat.form(window * ufl.dx)) / document["map_pa"]


def _recovered(space, richer, duals):
    """Recovered minus interpolated dual solutions, (d, n) values over W of `richer`; duals: d arrays of values over W
    of `space`."""
    nodes, cells = space.nodes()
    velocity, pressure = np.zeros((len(nodes), 3 * len(duals))), np.zeros((len(nodes), len(duals)))
    for d, dual in enumerate(duals):
        velocity[:, 3 * d : 3 * d + 3] = dual[space.v_map].reshape(-1, 3)
        pressure[cells[:, :4], d] = dual[space.q_map][compat.cell_dofs(space.Q)]
    fields = [
        (space.degree + 1, cells, velocity, richer.V.tabulate_dof_coordinates(), compat.cell_dofs(richer.V)),
        (space.degree, cells[:, :4], pressure, richer.Q.tabulate_dof_coordinates(), compat.cell_dofs(richer.Q)),
    ]
    smooth_velocity, smooth_pressure = (recover(recovery.Patches(nodes, cells), *field) for field in fields)
    difference = np.zeros((len(duals), richer.dofs))
    for d, dual in enumerate(duals):
        difference[d, richer.v_map] = smooth_velocity[:, 3 * d : 3 * d + 3].ravel()
        difference[d, richer.q_map] = smooth_pressure[:, d]
        difference[d] -= interpolate_state(space, richer, dual)
    return difference


def recover(patches, degree, sources, values, targets, cell_targets):
    """Recovered values (m, k) at the targets (m, 3) of all cells, patch by patch; arguments as in Patches.recover,
    with values (n, k)."""
    sums, counts = np.zeros((len(targets), values.shape[1])), np.zeros(len(targets))
    touching = patches._patches_touching(None)
    given = degree, sources, cell_targets, len(targets), values.shape[1]
    for nodes, at in patches._equal_patches(touching, *given):
        known, at_targets, inverse = recovery._fit_patches(patches.nodes[nodes], targets[at], recovery.TERMS[degree])
        np.add.at(sums, at, at_targets @ (inverse @ (known.transpose(0, 2, 1) @ values[nodes])))
        np.add.at(counts, at, 1)
    return sums / counts[:, None]


def interpolate_state(space, richer, values):
    """Values (n,) of a state over W of `space`, interpolated to W of the LumenSpace `richer` by dolfinx."""
    result = np.zeros(richer.dofs)
    for source, target, of_source, of_target in (
        (space.V, richer.V, space.v_map, richer.v_map),
        (space.Q, richer.Q, space.q_map, richer.q_map),
    ):
        coarse, fine = fem.Function(source), fem.Function(target)
        coarse.x.array[:] = values[of_source]
        fine.interpolate(coarse)
        result[of_target] = fine.x.array
    return result
