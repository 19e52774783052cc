"""The error that the mesh makes in FFR, at any place: the residual of the flow, weighted by dual solutions.

Becker and Rannacher 2001, Acta Numerica 10. J is the FFR at one place, w the flow, R its residual, K Newton's tangent.
The dual solution z says how much J changes with each equation: K^T z = dJ/dw. A Newton step -K^-1 R would change J by
-R(w; z). So computed minus true J is R(w; z - i z). Here i z is the interpolant of z in the finite-element space, for
which R is zero (Galerkin). z itself is recovered as cubic velocity and quadratic pressure (errors.recovery).

The contributions to R(w; z - i z) change sign along a vessel, and each may be wrong by a large share of its value. So
where they nearly cancel, their sum says nothing. They are kept apart for stretches of the vessel one diameter long.
Part k is the residual r_k of stretch k, weighted by z - i z.

Part k is linear in z: it is G_k z, with G_k = (recovery - interpolation)^T r_k. So part k = dJ/dw e_k with K e_k = G_k.
The field e_k is the error, computed minus true, that stretch k makes in the whole flow. One solve for each stretch
gives the parts at every probe, outlet and point of the pull-back.

The artificial viscosity gives one more part. It adds the force A(w) = eps rho h (|u| grad u, grad v) to the equations.
Its effect on the flow is the solution e of K e = -A(w): eps times the flow's derivative with respect to eps.
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

LOADS_AT_ONCE = 16  # number of loads that are solved for together
# The change of FFR at a point is a mean with a Gaussian weight. Pressures more than this many radii away are left out,
# since their weight is below exp(-25).
WINDOW_RADII = 5.0


class ErrorField:
    """The changes that k loads make in a steady flow. Only the values on which FFR depends are kept.

    pressure (q, k) in Pa at the pressure's dofs, which lie at `pressure_points` (q, 3) in m; outflows (o, k) in m3/s.
    solved: solvers.solved_mesh.SolvedMesh; loads (n, k): sparse, over W.
    """

    def __init__(self, solved, loads):
        problem, space = solved.problem, solved.space
        self.boundaries, self.sampler = solved.boundaries, solved.sampler
        self.slopes = self.boundaries.pressure_slopes(self.boundaries.outflows(problem.state.x.array))
        self.pressure_points, self.mass = space.Q.tabulate_dof_coordinates(), _mass_matrix(space)
        pressure, outflows = [], []
        for first in range(0, loads.shape[1], LOADS_AT_ONCE):
            response = problem.responses(loads[:, first : first + LOADS_AT_ONCE].toarray())
            pressure.append(response[space.q_map])
            outflows.append(self.boundaries.outflows(response))
        self.pressure, self.outflows = np.concatenate(pressure, axis=1), np.concatenate(outflows, axis=1)

    def ffr_changes(self, names, points_mm, radii_mm):
        """Change (o + m, k) of FFR by each load, at the mesh's outlets `names` (o), then at points_mm (m, 3).

        At a point it is the change of FFR averaged over about one vessel radius, radii_mm (m,).
        """
        chosen = [self.boundaries.outlet_names.index(name) for name in names]
        means = self._averaging_matrix(points_mm, radii_mm)
        of_outlets = self.slopes[chosen, None] * self.outflows[chosen]
        return np.concatenate([of_outlets, means @ self.pressure]) / self.boundaries.map_pa

    def _averaging_matrix(self, points_mm, radii_mm):
        """Sparse (m, q) matrix. Times pressures (q,) it gives their weighted means round points_mm (m, 3).

        The weight is exp(-(distance / radius)^2), with the radii radii_mm (m,).
        """
        points, radii = M_PER_MM * points_mm, M_PER_MM * radii_mm
        near = cKDTree(self.pressure_points).query_ball_point(points, WINDOW_RADII * radii, return_sorted=True)
        rows = np.repeat(np.arange(len(near)), [len(one) for one in near])
        columns = np.concatenate([*near, []]).astype(int)
        gap = self.pressure_points[columns] - points[rows]
        weights = np.exp(-np.sum(gap**2, axis=1) / radii[rows] ** 2)
        means = scipy.sparse.csr_matrix((weights, (rows, columns)), (len(near), len(self.pressure_points))) @ self.mass
        return scipy.sparse.diags(1.0 / np.asarray(means.sum(axis=1)).ravel()) @ means

    def interpolation_error_pa(self, points_mm):
        """Size (m,) in Pa of the interpolation error of the flow's pressure at points_mm (m, 3).

        The pressure is linear in each cell. The error is its difference from a quadratic pressure (errors.recovery).
        """
        sampler, points = self.sampler, M_PER_MM * points_mm
        cell, lam, _ = sampler.locator.find(points)
        nodes, cells = sampler.locator.nodes, sampler.locator.cells
        smooth = Patches(nodes, cells).recover(2, cells[:, :4], sampler.pressure, nodes, cells, cell)[cells[cell]]
        return np.abs(np.einsum("mn,mn->m", tet10.basis(lam), smooth) - sampler(points)[1])


def solve_error_field(solved, document, tree):
    """(parts (p, k + 1) of the error of FFR at the p probes, ErrorField) of a solvers.solved_mesh.SolvedMesh.

    The first k parts are the errors by the mesh in each stretch, the last is the effect of the artificial viscosity.
    document: content of boundary.json; tree: centreline tree without extensions. Raises ComputationError where a linear
    solve fails.
    """
    problem = solved.problem
    loads = [
        stretch_loads(problem, document, tree),
        scipy.sparse.csc_matrix(-problem.forms.artificial_force()[:, None]),
    ]
    field = ErrorField(solved, scipy.sparse.hstack(loads, "csc"))
    on = [tree.project_probe(probe)[:2] for probe in document["probes"]]
    points = np.array([branch.point(s_mm) for branch, s_mm in on])
    return field.ffr_changes([], points, np.array([branch.radius(s_mm) for branch, s_mm in on])), field


def stretch_loads(problem, document, tree):
    """Sparse matrix (n, k) over W: column k is the load G_k of stretch k. problem: solvers.nonlinear.FlowProblem."""
    space = problem.space
    richer = spaces.LumenSpace(space.mesh, space.facet_tags, degree=space.degree + 1)
    parts = ((space.V, space.v_map, richer.V, richer.v_map, 3), (space.Q, space.q_map, richer.Q, richer.q_map, 1))
    interpolations, state = [], np.empty(richer.dofs)
    for part, rows, rich, dofs, width in parts:
        interpolations.append(compat.interpolation_matrix(part, rich))
        state[dofs] = (interpolations[-1] @ problem.state.x.array[rows].reshape(-1, width)).ravel()
    residual = richer_residual(problem, richer, state, document)
    residual[richer.wall_dofs] = residual[richer.inlet_dofs] = 0.0
    numbers = stretch_numbers(tree)
    stretch, count = numbers[tree.nearest(dof_points(richer) / M_PER_MM)[0]], numbers.max() + 1
    nodes, cells = space.nodes()
    corner = np.empty(len(space.q_map), int)
    corner[compat.cell_dofs(space.Q)] = cells[:, :4]
    found = scipy.sparse.csc_matrix((space.dofs, count))
    fields, of_cells = [], (cells, cells[:, :4])
    for k, (_, rows, rich, dofs, width) in enumerate(parts):
        loads, group = residual[dofs].reshape(-1, width), stretch[dofs[::width]]
        given = rich.tabulate_dof_coordinates(), compat.cell_dofs(rich), group
        fields.append((compat.degree(rich), of_cells[k], loads, *given))
        transposed = interpolations[k].T
        for c in range(width):
            by_group = scipy.sparse.csr_matrix((loads[:, c], (np.arange(len(loads)), group)), (len(loads), count))
            found -= _scatter_rows(transposed @ by_group, rows[c::width], space.dofs)
    velocity, (pressure,) = Patches(nodes, cells).recover_transposed(fields, count)
    for rows, part in [*((space.v_map[c::3], velocity[c]) for c in range(3)), (space.q_map, pressure[corner])]:
        found += _scatter_rows(part, rows, space.dofs)
    return found


def stretch_numbers(tree):
    """Number (n,) of the stretch to which each centreline point belongs, in the numbering of Tree.nearest.

    A stretch is one local diameter long.
    """
    found, first = [], 0
    for branch in tree:
        diameters = np.diff(branch.s_mm) / (branch.radius_mm[1:] + branch.radius_mm[:-1])
        found.append(first + np.floor(np.append(0.0, np.cumsum(diameters)) + 1e-9).astype(int))
        first = found[-1][-1] + 1
    return np.concatenate(found)


def dof_points(space):
    """Points (n, 3) in m at which the dofs over W of a LumenSpace lie."""
    found = np.empty((space.dofs, 3))
    found[space.v_map] = np.repeat(space.V.tabulate_dof_coordinates(), 3, axis=0)
    found[space.q_map] = space.Q.tabulate_dof_coordinates()
    return found


def _scatter_rows(part, rows, size):
    """Sparse (size, k) matrix with row i of `part` (n, k) as its row number rows[i]; other rows are 0."""
    part = part.tocoo()
    return scipy.sparse.csc_matrix((part.data, (rows[part.row], part.col)), (size, part.shape[1]))


def _mass_matrix(space):
    """Sparse (q, q) mass matrix of the pressure space."""
    p, q = ufl.TrialFunction(space.Q), ufl.TestFunction(space.Q)
    return compat.to_csr(fem_petsc.assemble_matrix(compat.form(p * q * ufl.dx)))


def richer_residual(problem, richer, values, document):
    """Momentum and continuity residual (n,) over W of the LumenSpace `richer`.

    values (n,): the present flow of `problem` (solvers.nonlinear.FlowProblem), interpolated to W of `richer`; document:
    content of boundary.json.
    """
    state = fem.Function(richer.W)
    state.x.array[:] = values
    weak = forms.from_document(richer, state, document, problem.settings)
    weak.artificial_viscosity.value = problem.artificial_viscosity
    pressures = problem.boundaries.pressures(problem.boundaries.outflows(problem.state.x.array))
    loads = [pressure * richer.flux_vector(tag) for tag, pressure in zip(richer.outlet_tags, pressures)]
    return weak.assemble_residual() + sum(loads)
