"""Steady Navier-Stokes in the meridian plane of a narrowed straight tube: a reference that shares no code with flow.

The mesh has curved Q3-Q2 quadrilaterals on the mapped rectangle (s, r / R(s)). The unknowns are u_x, u_r and p, and
integrals have the weight r. Equations, boundary conditions and coupling are those of discretisation.forms: a parabolic
inflow Q at the mean pressure MAP, and the traction P_v + R Q at the outlet.
"""

import numpy as np
import ufl
from dolfinx import fem, geometry, mesh
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc

from common import fenicsx

FRACTIONS = (0.1, 0.25, 0.5, 0.65, 0.8, 0.9, 1.0)


def containing_cells(domain, points):
    """Index (n,) of the first cell found that contains each of points (n, 3), in the domain's unit."""
    if hasattr(geometry, "bb_tree"):  # FEniCSx 0.9
        candidates = geometry.compute_collisions_points(geometry.bb_tree(domain, domain.topology.dim), points)
    else:  # FEniCSx 0.5
        candidates = geometry.compute_collisions(geometry.BoundingBoxTree(domain, domain.topology.dim), points)
    colliding = geometry.compute_colliding_cells(domain, candidates, points)
    return np.array([colliding.links(k)[0] for k in range(len(points))], np.int32)


def _graded(length, throat, count):
    """Function from a fraction in [0, 1] of the grid's cells to s in mm; the cells are small round the throat."""
    s = np.linspace(0, length, 20001)
    gap = np.clip(np.abs(s - throat) - 5.0, 0, None)
    width = 0.1 + np.where(s < throat, 0.03, 0.02) * gap
    steps = np.concatenate([[0.0], np.cumsum(0.5 * (1 / width[1:] + 1 / width[:-1]) * np.diff(s))])
    return lambda x: np.interp(x, steps / steps[-1], s)


def _domain(radius, place, cells):
    """Curved quadrilaterals of nine nodes on the mapped rectangle, in m; place: the function of _graded."""
    along, across = cells
    fraction, share = np.meshgrid(np.linspace(0, 1, 2 * along + 1), np.linspace(0, 1, 2 * across + 1), indexing="ij")
    s = place(fraction.ravel())
    points = 1e-3 * np.stack([s, share.ravel() * radius(s)], axis=1)
    return quadrilaterals(points, cells_of(np.arange(len(points)).reshape(fraction.shape)))


def cells_of(number):
    """Nodes (c, 9) of the cells of a grid, from the nodes' numbers (2 along + 1, 2 across + 1)."""
    # The order of nodes that basix gives a Q2 cell: corners, middles of edges 01, 02, 13, 23, centre. A step here is
    # half a cell.
    local = [(0, 0), (2, 0), (0, 2), (2, 2), (1, 0), (0, 1), (2, 1), (1, 2), (1, 1)]
    along, across = (size - 2 for size in number.shape)
    return np.stack([number[i : i + along : 2, j : j + across : 2].ravel() for i, j in local], axis=1)


def quadrilaterals(points, cells):
    """Mesh of curved quadrilaterals (c, 9) at points (n, 2) in m."""
    return mesh.create_mesh(MPI.COMM_WORLD, cells, points, fenicsx.quadratic_domain("quadrilateral"))


class Tube:
    """The flow in a narrowed straight tube.

    radius: function of s, both in mm; length and throat (its place) in mm; document: as boundary.json, in SI units.
    cells: (along, across); degree: of the velocity's elements.
    """

    def __init__(self, radius, length, throat, document, cells, degree=3, backflow=0.5):
        self.document, self.radius, self.radius_0, self.factor = document, radius, float(radius(0.0)) * 1e-3, None
        self.cells, self.place = cells, _graded(length, throat, cells[0])
        self.domain = domain = self._mesh()
        velocity = fenicsx.lagrange("quadrilateral", degree, 2)
        pressure = fenicsx.lagrange("quadrilateral", degree - 1)
        W = fenicsx.function_space(domain, fenicsx.mixed(velocity, pressure))
        self.state = fem.Function(W)
        self._boundaries(W, length * 1e-3)
        self._forms(W, backflow, 3 * degree + 1)

    def _mesh(self):
        return _domain(self.radius, self.place, self.cells)

    def _boundaries(self, W, length):
        locate = mesh.locate_entities_boundary
        self.inlet = locate(self.domain, 1, lambda x: np.isclose(x[0], 0))
        self.outlet = locate(self.domain, 1, lambda x: np.isclose(x[0], length))
        axis = locate(self.domain, 1, lambda x: np.isclose(x[1], 0))
        everything = locate(self.domain, 1, lambda x: np.full(x.shape[1], True))
        wall = np.setdiff1d(everything, np.concatenate([self.inlet, self.outlet, axis]))
        V, _ = W.sub(0).collapse()
        radial, _ = W.sub(0).sub(1).collapse()
        self.profile = fem.Function(V)
        sub = W.sub(0)
        self.conditions = [
            fem.dirichletbc(fem.Function(V), fem.locate_dofs_topological((sub, V), 1, wall), sub),
            fem.dirichletbc(self.profile, fem.locate_dofs_topological((sub, V), 1, self.inlet), sub),
            fem.dirichletbc(
                fem.Function(radial), fem.locate_dofs_topological((sub.sub(1), radial), 1, axis), sub.sub(1)
            ),
        ]

    def _forms(self, W, backflow, quadrature):
        facets = np.concatenate([self.inlet, self.outlet])
        tags = np.repeat([1, 2], [len(self.inlet), len(self.outlet)]).astype(np.int32)
        order = np.argsort(facets)
        ds = ufl.Measure("ds", self.domain, subdomain_data=mesh.meshtags(self.domain, 1, facets[order], tags[order]))
        dx = ufl.Measure("dx", self.domain, metadata={"quadrature_degree": quadrature})
        (u, p), (v, q) = ufl.split(self.state), ufl.TestFunctions(W)
        r = ufl.SpatialCoordinate(self.domain)[1]
        rho, mu = self.document["density_kg_per_m3"], self.document["viscosity_pa_s"]

        def div(w):
            return w[0].dx(0) + w[1].dx(1) + w[1] / r

        friction = mu * (ufl.inner(ufl.grad(u), ufl.grad(v)) + u[1] * v[1] / r**2)
        convection = rho * ufl.inner(ufl.dot(ufl.grad(u), u) + 0.5 * div(u) * u, v)
        inward = 0.5 * (u[0] - abs(u[0]))
        residual = (friction + convection - p * div(v) - q * div(u)) * r * dx
        residual -= backflow * rho * inward * ufl.inner(u, v) * r * ds(2)
        self.residual = fem.form(residual)
        self.tangent = fem.form(ufl.derivative(residual, self.state))
        self.inlet_pressure = fem.form(2.0 / self.radius_0**2 * p * r * ds(1))

    def _solve(self, flow):
        """Solves by Newton's method at the inflow `flow`, from the last solution scaled to this inflow.

        Returns the mean pressure at the inlet, relative to the outlet's.
        """
        mean = flow / (np.pi * self.radius_0**2)
        self.profile.interpolate(lambda x: np.stack([2 * mean * (1 - (x[1] / self.radius_0) ** 2), 0 * x[0]]))
        if self.factor:
            self.state.x.array[:] *= flow / self.factor
        self.factor = flow
        ksp = PETSc.KSP().create(MPI.COMM_WORLD)
        ksp.setType("preonly")
        ksp.getPC().setType("lu")
        ksp.getPC().setFactorSolverType("mumps")
        state = fenicsx.petsc_vector(self.state)
        for _ in range(25):
            b = fem_petsc.assemble_vector(self.residual)
            A = fem_petsc.assemble_matrix(self.tangent, bcs=self.conditions)
            A.assemble()
            fem_petsc.apply_lifting(b, [self.tangent], [self.conditions], [state], -1.0)
            fem_petsc.set_bc(b, self.conditions, state, -1.0)
            update = b.copy()
            ksp.setOperators(A)
            ksp.solve(b, update)
            state.axpy(-1.0, update)
            A.destroy()
            if update.norm() < 1e-8 * state.norm():
                ksp.destroy()
                return fem.assemble_scalar(self.inlet_pressure)
        raise RuntimeError("the axisymmetric flow did not converge")

    def ffr(self, guess, s_mm):
        """FFR on the axis at s_mm.

        The secant method finds the inflow at which the inlet has MAP; `guess`: its start, in m3/s.
        """
        document = self.document
        outlet = document["outlets"][0]

        def excess(flow):
            behind = document["venous_pressure_pa"] + outlet["resistance_pa_s_per_m3"] * flow
            return self._solve(flow) + behind - document["map_pa"]

        for fraction in FRACTIONS[:-1]:
            self._solve(fraction * guess)
        a, b = guess, 0.99 * guess
        f_a, f_b = excess(a), excess(b)
        while abs(f_b) > 1e-3:
            a, b, f_a = b, b - f_b * (b - a) / (f_b - f_a), f_b
            f_b = excess(b)
        drop = fem.assemble_scalar(self.inlet_pressure) - self._on_axis(s_mm)
        return 1.0 - drop / document["map_pa"]

    def ffr_along(self, guess, places_mm):
        """(FFR (n,) on the axis at places_mm, FFR at the outlet), at the inflow that `ffr` finds from `guess`."""
        self.ffr(guess, places_mm[0])
        inlet, map_pa = fem.assemble_scalar(self.inlet_pressure), self.document["map_pa"]
        return 1.0 - (inlet - np.array([self._on_axis(s) for s in places_mm])) / map_pa, 1.0 - inlet / map_pa

    def pressures(self, flow, places_mm):
        """Pressures on the axis at places_mm in Pa, relative to the outlet's, at the inflow `flow` (m3/s)."""
        for fraction in FRACTIONS:
            self._solve(fraction * flow)
        return [self._on_axis(s) for s in places_mm]

    def wall_shear(self, s_mm, flow):
        """Wall shear stress (n,) in Pa, positive downstream, at s_mm (n,) and the inflow `flow` (m3/s).

        The velocity's slope is a difference quotient of second order. Its points lie 2 and 4 thousandths of the inlet's
        radius from the wall, along the wall's normal.
        """
        for fraction in FRACTIONS:
            self._solve(fraction * flow)
        step, reach = 1e-4, 2e-3 * self.radius_0 * 1e3
        slope = (self.radius(s_mm + step) - self.radius(s_mm - step)) / (2 * step)
        outward = np.stack([-slope, np.ones_like(slope)], axis=1) / np.hypot(1.0, slope)[:, None]
        along = np.stack([outward[:, 1], -outward[:, 0]], axis=1)
        wall = np.stack([s_mm, self.radius(s_mm)], axis=1)
        near, far = (np.sum(along * self._at_wall(wall - k * reach * outward), axis=1) for k in (1, 2))
        return self.document["viscosity_pa_s"] * (4 * near - far) / (2 * reach * 1e-3)

    def _at_wall(self, points_mm):
        """Velocity (n, 2) at points (n, 2) in the outermost row of cells."""
        edges = self.place(np.linspace(0, 1, self.cells[0] + 1))
        column = np.searchsorted(edges, points_mm[:, 0], side="right") - 1
        order = np.argsort(self.domain.topology.original_cell_index)
        cells = order[column * self.cells[1] + self.cells[1] - 1].astype(np.int32)
        points = np.column_stack([1e-3 * points_mm, np.zeros(len(points_mm))])
        return self.state.sub(0).eval(points, cells)

    def _on_axis(self, s_mm):
        point = np.array([[s_mm * 1e-3, 1e-7, 0.0]])
        return float(self.state.sub(1).eval(point, containing_cells(self.domain, point))[0])
