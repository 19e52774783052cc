"""The error that the mesh makes in FFR everywhere: the residual of the flow, weighted by dual solutions.

Becker and Rannacher 2001, Acta Numerica 10. The dual solution z of a place says how much its FFR J changes with each
equation: K^T z = dJ/dw, where K is Newton's tangent. A Newton step -K^-1 R would change J by -R(w; z). So computed
minus true is +R(w; z - i z). Here i z is the interpolant of z in the space itself, on which R is zero (Galerkin). z is
recovered as cubic velocity and quadratic pressure (errors.recovery).

The contributions change sign along a vessel, and each is known to about a half. Where they nearly cancel, the sum says
nothing. So they are kept apart for stretches one diameter long: part k is the residual r_k of stretch k times z - i z.

Part k is linear in z: it is G_k z, with G_k = (recovery - interpolation)^T r_k. So part k = dJ/dw e_k with K e_k = G_k.
The field e_k is the error, computed minus true, that stretch k makes in the whole flow. One solve for each stretch
gives the parts at every probe, outlet and point of the pull-back.

The artificial viscosity gives one more part. It adds the force A(w) = eps rho h (|u| grad w, grad v) to the equations.
So the solution of K e = -A(w) is its effect on the flow: eps times the flow's derivative with respect to eps.
"""

import numpy as np
import scipy.sparse
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from scipy.spatial import cKDTree

from flow.discretisation import compat, forms, spaces
from flow.geometry import tet10
from flow.errors.recovery import Patches
from flow.physics.units import M_PER_MM

BATCH = 16  # solutions at a time
WINDOW = 5.0  # radii round a point at which _means ends: the Gaussian weight is exp(-25) there


class Field:
    """The changes of a steady flow by k loads, kept where FFR needs them.

    pressure (q, k) in Pa over the pressure's dofs, at `places` (q, 3) in m; outflows (o, k) in m3/s. The flow itself:
    flow_pressure (q,) in Pa, sampler (geometry.locate.FieldSampler), flow_outflows (o,) in m3/s.
    """

    def __init__(self, solved, loads):
        problem, space = solved.problem, solved.space
        self.boundaries, self.sampler, self.flow_outflows = solved.boundaries, solved.sampler, solved.outflows
        self.flow_pressure = problem.state.x.array[space.q_map]
        self.places, self.mass = space.Q.tabulate_dof_coordinates(), _mass(space)
        pressure, outflows = [], []
        for first in range(0, loads.shape[1], BATCH):
            response = problem.responses(loads[:, first : first + BATCH].toarray())
            pressure.append(response[space.q_map])
            outflows.append(np.stack([flux.array_r @ response for flux in self.boundaries.flux]))
        self.pressure, self.outflows = np.concatenate(pressure, axis=1), np.concatenate(outflows, axis=1)

    def parts(self, document, tree, names, points_mm, radii_mm):
        """Change (o + m, k) of FFR by each load: at the mesh's outlets `names`, then round the points (m, 3).

        At a point it is the change of the mean over a ball of about the vessel's radius. Where the inflow is given, the
        pressure at the inlet's centre is FFR's denominator, and its change counts too.
        """
        chosen = [self.boundaries.names.index(name) for name in names]
        means = self._means(points_mm, radii_mm)
        of_outlets = self.boundaries.resistance[chosen, None] * self.outflows[chosen]
        found = np.concatenate([of_outlets, means @ self.pressure])
        if document.get("inlet_flow_m3_per_s") is None:
            return found / document["map_pa"]
        at_inlet = self._means(tree.main.point(0.0)[None], np.array([tree.main.radius(0.0)]))
        reference = (at_inlet @ self.flow_pressure)[0]
        values = np.append(self.boundaries.pressures(self.flow_outflows)[chosen], means @ self.flow_pressure)
        return (found - np.outer(values / reference, at_inlet @ self.pressure)) / reference

    def _means(self, points_mm, radii_mm):
        """Sparse (m, q) matrix; times a pressure (q,) it gives the means round the points, with a Gaussian weight."""
        points, radii = M_PER_MM * points_mm, M_PER_MM * radii_mm
        near = cKDTree(self.places).query_ball_point(points, WINDOW * radii, return_sorted=True)
        rows = np.repeat(np.arange(len(near)), [len(one) for one in near])
        columns = np.concatenate([*near, []]).astype(int)
        gap = self.places[columns] - points[rows]
        weights = np.exp(-np.sum(gap**2, axis=1) / radii[rows] ** 2)
        means = scipy.sparse.csr_matrix((weights, (rows, columns)), (len(near), len(self.places))) @ self.mass
        return scipy.sparse.diags(1.0 / np.asarray(means.sum(axis=1)).ravel()) @ means

    def interpolation_pa(self, points_mm):
        """Sizes (m,) in Pa of the interpolation error of the flow's pressure at points (m, 3).

        The pressure is linear in each cell; the error is its difference to a recovered quadratic pressure.
        """
        sampler, points = self.sampler, M_PER_MM * points_mm
        cell, lam, _ = sampler.locator.find(points)
        nodes, cells = sampler.points, sampler.cells
        field = 2, cells[:, :4], sampler.pressure[:, None], nodes, cells
        smooth = Patches(nodes, cells).recover([field], cell)[0][cells[cell], 0]
        return np.abs(np.einsum("mn,mn->m", tet10.basis(lam), smooth) - sampler(points)[1])


def of(solved, document, tree):
    """(parts (p, k + 1) at the document's probes, Field) of a solvers.solved_mesh.Solved with a steady flow.

    The first k parts are the errors of FFR by the mesh in each stretch, the last the effect of the artificial
    viscosity. Raises ComputationError where a linear solve fails.
    """
    problem = solved.problem
    loads = [sources(problem, document, tree), scipy.sparse.csc_matrix(-problem.forms.artificial_force()[:, None])]
    field = Field(solved, scipy.sparse.hstack(loads, "csc"))
    on = [tree.place_of(probe)[:2] for probe in document["probes"]]
    points = np.array([branch.point(s_mm) for branch, s_mm in on])
    return field.parts(document, tree, [], points, np.array([branch.radius(s_mm) for branch, s_mm in on])), field


def sources(problem, document, tree):
    """Sparse (dofs of W, k): G_k of each stretch."""
    space = problem.space
    richer = spaces.LumenSpace(space.mesh, space.facets, degree=space.degree + 1)
    vector = residual_of(problem, richer, document)
    residual = vector.array.copy()
    vector.destroy()
    residual[richer.wall] = residual[richer.inlet] = 0.0
    numbers = stretches(tree)
    stretch, count = numbers[tree.nearest(places(richer) / M_PER_MM)[0]], numbers.max() + 1
    nodes, cells = space.nodes()
    corner = np.empty(len(space.q_map), int)
    corner[compat.cell_dofs(space.Q)] = cells[:, :4]
    found = scipy.sparse.csc_matrix((space.dofs, count))
    parts = ((space.V, space.v_map, richer.V, richer.v_map, 3), (space.Q, space.q_map, richer.Q, richer.q_map, 1))
    fields, of_cells = [], (cells, cells[:, :4])
    for k, (part, rows, rich, dofs, width) in enumerate(parts):
        loads, group = residual[dofs].reshape(-1, width), stretch[dofs[::width]]
        given = rich.tabulate_dof_coordinates(), compat.cell_dofs(rich), group
        fields.append((compat.degree(rich), of_cells[k], loads, *given))
        back = compat.interpolation(part, rich).T
        for c in range(width):
            by_group = scipy.sparse.csr_matrix((loads[:, c], (np.arange(len(loads)), group)), (len(loads), count))
            found -= _placed(back @ by_group, rows[c::width], space.dofs)
    velocity, (pressure,) = Patches(nodes, cells).transposed(fields, count)
    for rows, part in [*((space.v_map[c::3], velocity[c]) for c in range(3)), (space.q_map, pressure[corner])]:
        found += _placed(part, rows, space.dofs)
    return found


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


def _placed(part, rows, size):
    """Sparse (size, k) matrix with the rows of `part` (n, k) at the row numbers `rows` (n,)."""
    part = part.tocoo()
    return scipy.sparse.csc_matrix((part.data, (rows[part.row], part.col)), (size, part.shape[1]))


def _mass(space):
    """Sparse (q, q) mass matrix of the pressure's space."""
    p, q = ufl.TrialFunction(space.Q), ufl.TestFunction(space.Q)
    return compat.csr(fem_petsc.assemble_matrix(compat.form(p * q * ufl.dx)))


def carried(space, richer, values):
    """A state's values over W of `space`, interpolated to W of the richer space on the same mesh."""
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


def residual_of(problem, richer, document):
    """The momentum and continuity residual of the present flow as a vector over the richer space's W."""
    boundaries = problem.boundaries
    state = fem.Function(richer.W)
    state.x.array[:] = carried(problem.space, richer, problem.state.x.array)
    weak = forms.of(richer, state, document, problem.settings)
    weak.artificial.value = problem.artificial
    found = compat.new_vector(richer.W)
    weak.assembled(found)
    outflows = boundaries.outflows(problem.state_vector())
    for tag, pressure in zip(richer.outlets, boundaries.pressures(outflows)):
        flux = richer.flux_vector(tag)
        found.axpy(pressure, flux)
        flux.destroy()
    return found
