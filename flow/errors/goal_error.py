"""What the mesh has done to FFR: the residual weighted by the dual solution.

Becker and Rannacher 2001, Acta Numerica 10.
The dual solution z of a probe says how much FFR there changes with each equation: K^T z = dJ/dw, K being Newton's
tangent and J the mean of p / MAP near the probe. A Newton step -K^-1 R would change J by -R(w; z), so computed minus
true is +R(w; z - i z), i z being z in the space itself, where R is zero (Galerkin). z is recovered as cubic velocity
and quadratic pressure (errors.recovery), with which the residual of the present flow is weighted.

Its parts differ in sign along a vessel, and each is known to a half or so: where they nearly cancel the sum says
nothing. So the parts of stretches one diameter long are told apart too.
"""

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc

from flow.discretisation import compat, spaces
from flow.physics import viscosity
from flow.discretisation.forms import NavierStokes
from flow.errors.recovery import Patches

M_PER_MM = 1e-3


def of(solved, document, tree):
    """Estimated parts (p, k) of FFR's error at each of the document's p probes, computed minus true, by the k stretches
    of the tree that they arise in; their sum estimates the error. solved: solvers.solved_mesh.Solved."""
    problem, space = solved.problem, solved.space
    points = [tuple(probe["point_mm"]) for probe in document["probes"]]
    probes = {point: probe for point, probe in zip(points, document["probes"])}  # some share a place
    duals = []
    for probe in probes.values():
        goal = _goal(problem, document, tree, probe)
        duals.append(problem.dual(goal))
        goal.destroy()
    richer = spaces.LumenSpace(space.mesh, space.facets, degree=space.degree + 1)
    weights = _recovered(space, richer, duals)
    held = np.concatenate([richer.wall, richer.inlet])
    weights[:, held] = 0.0
    loads = residual(problem, richer, document)
    parts = loads.array * weights
    loads.destroy()
    stretch = stretches(tree)[tree.nearest(places(richer) / M_PER_MM)[0]]
    found = dict(zip(probes, (np.bincount(stretch, one) for one in parts)))
    return np.array([found[point] for point in points])


def stretches(tree):
    """Number (n,) of the stretch in which each point of the tree's centrelines lies, in the order of Tree.nearest.

    A stretch is one local diameter long.
    """
    found, first = [], 0
    for branch in tree:
        diameters = np.diff(branch.s_mm) / (branch.radius_mm[1:] + branch.radius_mm[:-1])
        found.append(first + np.floor(np.append(0.0, np.cumsum(diameters)) + 1e-9).astype(int))
        first = found[-1][-1] + 1
    return np.concatenate(found)


def places(space):
    """Points (n, 3) in m of the dofs over W of a LumenSpace."""
    found = np.empty((space.dofs, 3))
    found[space.v_map] = np.repeat(space.V.tabulate_dof_coordinates(), 3, axis=0)
    found[space.q_map] = space.Q.tabulate_dof_coordinates()
    return found


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
        difference[d] -= _carried(space, richer, dual)
    return difference


def _carried(space, richer, values):
    """Values over W of the richer space on the same mesh of a state's values."""
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


def residual(problem, richer, document):
    """The momentum and continuity residual of the present flow as a vector over the richer space's W."""
    settings, boundaries = problem.settings, problem.boundaries
    state = fem.Function(richer.W)
    state.x.array[:] = _carried(problem.space, richer, problem.state.x.array)
    forms = NavierStokes(
        richer,
        state,
        document["density_kg_per_m3"],
        viscosity.of(document),
        settings.grad_div_pa_s,
        settings.backflow_coefficient,
    )
    forms.artificial.value = problem.artificial
    found = compat.petsc_vector(fem.Function(richer.W)).copy()
    forms.assembled(found)
    outflows = boundaries.outflows(problem.state_vector())
    for tag, pressure in zip(richer.outlets, boundaries.pressures(outflows)):
        flux = richer.flux_vector(tag)
        found.axpy(pressure, flux)
        flux.destroy()
    return found
