"""Axisymmetric Navier-Stokes flow through one branch: a fast model, whose flow is also the 3D solver's first guess.

The branch becomes a straight round tube with the radius R(s) = sqrt(A(s) / pi) of its cross-sections. The flow into a
side branch leaves through the wall over the ostium's length. The velocity in the meridian plane (x, r) is
u = (u_x, u_r). All integrals have the weight r:

    rho ((u.grad) u + 1/2 (div u) u, v) + mu (grad u, grad v) + mu (u_r / r, v_r / r) - (p, div v) - (q, div u)
      - beta rho <(u.n)_- u, v> at the outlet = 0,      div u = du_x/dx + du_r/dr + u_r / r

Here (u.n)_- = min(u.n, 0). The inflow has a parabolic profile. The outlet is traction-free, so pressures are relative
to the pressure at the outlet. Elements are Q2-Q1 on curved quadrilaterals. The model leaves out bends, eccentric
lesions and the disturbance by side branches. measured.md has its errors.
"""

import numpy as np
import ufl
from dolfinx import fem, mesh as dolfinx_mesh
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc

from common import fenicsx
from common.errors import ComputationError
from flow.discretisation import compat
from flow.physics import viscosity as viscosities
from flow.physics.navier_stokes import SHEAR_RATE_FLOOR
from flow.physics.units import M3_PER_S_PER_ML_PER_MIN

CELLS_ACROSS = 10  # cells along a radius
INLET, OUTLET = 1, 2
QUADRATURE_DEGREE = 7
# Fractions of the full inflow: the first at which a flow is found, from rest, and the least step between two of them.
FIRST_FRACTION, SHORTEST_STEP = 0.1, 0.02
MOST_NEWTON_STEPS = 10  # most iterations of Newton's method at one inflow
# Newton's method has converged when its update of the axial velocity, over this velocity, is below a tolerance. The
# first tolerance is for fractions of the full inflow, the second for the full inflow.
INTERMEDIATE_TOLERANCE, FINAL_TOLERANCE = 1e-3, 1e-8


class Tube:
    """Flow in a tube with the `radius` (k,) in m at the places s (k,) in m.

    s has an even number of intervals: every second place is the middle of a cell. leaks: [(s, length)], place and
    length in m of the ostium of each side branch. density in kg/m3; viscosity: law of physics.viscosity; backflow:
    coefficient beta of the outlet term.
    """

    def __init__(self, s, radius, leaks, density, viscosity, backflow):
        self.s, self.radius, self.rho = s, radius, np.linspace(0, 1, 2 * CELLS_ACROSS + 1)
        self.domain = _domain(s, radius, self.rho)
        velocity, pressure = compat.vector_element(self.domain, 2), compat.scalar_element(self.domain, 1)
        self.W = compat.function_space(self.domain, compat.mixed_element(velocity, pressure))
        self.state = fem.Function(self.W)
        self._number_dofs()
        self._prescribe(leaks)
        self._compile_forms(density, viscosity, backflow)
        self.solved_inflow = None
        self.ksp = PETSc.KSP().create(MPI.COMM_SELF)
        self.ksp.setType("preonly")
        self.ksp.getPC().setType("lu")
        self.ksp.getPC().setFactorSolverType("mumps")

    def _number_dofs(self):
        """Sets arrays with the dof numbers of u_x and u_r at all nodes, and of p at the cells' corners.

        Rows are places along the tube, columns places from the axis to the wall.
        """
        V, v_map = self.W.sub(0).collapse()
        Q, q_map = self.W.sub(1).collapse()

        def place(space, step):
            x = space.tabulate_dof_coordinates()
            along = np.searchsorted(0.5 * (self.s[1:] + self.s[:-1]), x[:, 0])
            across = np.rint(x[:, 1] / self.radius[along] * 2 * CELLS_ACROSS).astype(int)
            grid = np.empty(((len(self.s) - 1) // step + 1, 2 * CELLS_ACROSS // step + 1), int)
            grid[along // step, across // step] = np.arange(len(x))
            return grid

        grid = place(V, 1)
        self.u_x, self.u_r = (np.asarray(v_map)[2 * grid + k] for k in (0, 1))
        self.p = np.asarray(q_map)[place(Q, 2)]

    def _prescribe(self, leaks):
        """Sets the dofs with prescribed values, and these values for an inflow and for leaks into side branches.

        Inflow and leaks are of 1 m3/s each. Prescribed are both velocities at inlet and wall, and the radial velocity
        on the axis.
        """
        self.prescribed_dofs = np.unique(
            np.concatenate([self.u_x[0], self.u_r[0], self.u_x[:, -1], self.u_r[:, -1], self.u_r[:, 0]])
        )
        self.inflow_values = np.zeros_like(self.state.x.array)
        self.inflow_values[self.u_x[0]] = 2.0 * (1.0 - self.rho**2) / (np.pi * self.radius[0] ** 2)
        self.leak_values = []
        for centre, length in leaks:
            x = np.clip((self.s - centre) / length, -0.5, 0.5)
            shape = np.cos(np.pi * x) ** 2
            shape[[0, -1]] = 0.0
            shape /= max(np.sum(0.5 * (shape[1:] + shape[:-1]) * np.diff(self.s)), 1e-300)
            values = np.zeros_like(self.inflow_values)
            values[self.u_r[:, -1]] = shape / (2.0 * np.pi * self.radius)
            self.leak_values.append(values)

    def _compile_forms(self, density, viscosity, backflow):
        """Compiles the residual of the equations above and its tangent."""
        (u, p), (v, q) = ufl.split(self.state), ufl.TestFunctions(self.W)
        r, n = ufl.SpatialCoordinate(self.domain)[1], ufl.FacetNormal(self.domain)
        metadata = {"quadrature_degree": QUADRATURE_DEGREE}
        dx = ufl.Measure("dx", self.domain, metadata=metadata)
        end = float(self.s[-1])
        facets = dolfinx_mesh.locate_entities_boundary(self.domain, 1, lambda x: np.isclose(x[0], end))
        tags = dolfinx_mesh.meshtags(self.domain, 1, np.sort(facets), np.full(len(facets), OUTLET, np.int32))
        outlet = ufl.Measure("ds", self.domain, subdomain_data=tags, metadata=metadata)(OUTLET)

        def div(w):
            return w[0].dx(0) + w[1].dx(1) + w[1] / r

        if isinstance(viscosity, viscosities.Newtonian):
            friction = viscosity.value * (ufl.inner(ufl.grad(u), ufl.grad(v)) + u[1] * v[1] / r**2) * r * dx
        else:
            shear = ufl.sym(ufl.grad(u))
            mu = viscosity(ufl.sqrt(2 * (ufl.inner(shear, shear) + (u[1] / r) ** 2) + SHEAR_RATE_FLOOR**2))
            friction = 2 * mu * (ufl.inner(shear, ufl.sym(ufl.grad(v))) + u[1] * v[1] / r**2) * r * dx
            friction -= mu * ufl.dot(ufl.dot(ufl.grad(u).T, n), v) * r * outlet
        convection = density * ufl.inner(ufl.dot(ufl.grad(u), u) + 0.5 * div(u) * u, v)
        inward = 0.5 * (u[0] - abs(u[0]))
        residual = friction + (convection - p * div(v) - q * div(u)) * r * dx
        residual -= backflow * density * inward * ufl.inner(u, v) * r * outlet
        self.residual = compat.form(residual)
        self.tangent = compat.form(ufl.derivative(residual, self.state))
        self.condition = fem.dirichletbc(fem.Function(self.W), self.prescribed_dofs.astype(np.int32))
        self.matrix = fem_petsc.create_matrix(self.tangent)

    def solve(self, inflow, leak_flows):
        """Sets `state` to the flow with the given `inflow`, and with `leak_flows` out into the side branches (m3/s).

        Newton's method starts from the flow of the last call, scaled to this inflow. In the first call, or where this
        fails, the inflow is raised from rest in steps. A step is halved where Newton's method fails, and doubled after
        a success. Raises ComputationError where a step gets below SHORTEST_STEP.
        """
        prescribed = inflow * self.inflow_values + sum(
            (q * one for q, one in zip(leak_flows, self.leak_values)), 0.0 * self.inflow_values
        )
        last_fraction, step = (
            (0.0, FIRST_FRACTION) if self.solved_inflow is None else (self.solved_inflow / inflow, 1.0)
        )
        values = self.state.x.array
        while True:
            before = values.copy()
            fraction = min(last_fraction + step, 1.0) if self.solved_inflow is None else 1.0
            if last_fraction > 0:
                values *= fraction / last_fraction
                values[self.p] *= (
                    fraction / last_fraction
                )  # second factor: a jet's losses grow with the square of the flow
            values[self.prescribed_dofs] = fraction * prescribed[self.prescribed_dofs]
            if self._newton(FINAL_TOLERANCE if fraction == 1.0 else INTERMEDIATE_TOLERANCE):
                if fraction == 1.0:
                    self.solved_inflow = inflow
                    return
                last_fraction, step = fraction, 2.0 * step
                continue
            values[:], step = before, 0.5 * step
            if self.solved_inflow is not None:
                values[:], self.solved_inflow, last_fraction, step = 0.0, None, 0.0, FIRST_FRACTION
            elif step < SHORTEST_STEP:
                raise ComputationError(
                    "the axisymmetric model found no steady flow",
                    f"at {fraction:.2f} of the flow",
                    f"{inflow / M3_PER_S_PER_ML_PER_MIN:.1f} mL/min",
                    "check sections.csv",
                )

    def _newton(self, accuracy):
        """Whether Newton's method converges from the present state, which it changes.

        It has converged when the norm of the update of u_x is below `accuracy` times the norm of u_x.
        """
        values, last = self.state.x.array, np.inf
        for _ in range(MOST_NEWTON_STEPS):
            b = fem_petsc.assemble_vector(self.residual)
            self.matrix.zeroEntries()
            fem_petsc.assemble_matrix(self.matrix, self.tangent, bcs=[self.condition])
            self.matrix.assemble()
            b.array[self.prescribed_dofs] = 0.0
            update = b.duplicate()
            self.ksp.setOperators(self.matrix)
            self.ksp.solve(b, update)
            change = update.array
            size = np.linalg.norm(change[self.u_x]) / max(np.linalg.norm(values[self.u_x]), 1e-300)
            values -= change
            for vector in (b, update):
                vector.destroy()
            if not np.isfinite(size) or (size > 4 * last and size > 0.5):
                return False
            if size < accuracy:
                return True
            last = size
        return False

    def axis_pressure(self):
        """(s (m,) in m, pressure minus inlet pressure (m,) in Pa) on the axis, at the ends of the cells."""
        values = self.state.x.array[self.p[:, 0]]
        return self.s[::2], values - values[0]

    def fields(self):
        """(s (k,), rho (j,), u_x (k, j), u_r (k, j), pressure minus inlet pressure (k, j)) at all nodes, in SI units.

        rho is the distance from the axis over the tube's radius. The inlet pressure is the pressure on the axis there.
        """
        values = self.state.x.array
        corner = values[self.p] - values[self.p[0, 0]]
        pressure = np.empty(self.u_x.shape)
        pressure[::2, ::2] = corner
        pressure[1::2, ::2] = 0.5 * (corner[1:] + corner[:-1])
        pressure[:, 1::2] = 0.5 * (pressure[:, 2::2] + pressure[:, :-2:2])
        return self.s, self.rho, values[self.u_x], values[self.u_r], pressure

    @property
    def dofs(self):
        """Number of unknowns."""
        return len(self.state.x.array)

    def destroy(self):
        """Frees PETSc's memory."""
        self.ksp.destroy()
        self.matrix.destroy()


def _domain(s, radius, rho):
    """Mesh of the half-plane (x, r), in m, by nine-node quadrilaterals. Node (i, j) lies at x = s_i, r = rho_j R_i.

    s (k,): arc lengths in m; radius (k,): the tube's radius R there in m; rho (j,): distances from the axis over R.
    """
    along, across = len(s) // 2, len(rho) // 2
    points = np.stack([np.repeat(s, len(rho)), np.outer(radius, rho).ravel()], axis=1)
    number = np.arange(len(points)).reshape(len(s), len(rho))
    steps = [(0, 0), (2, 0), (0, 2), (2, 2), (1, 0), (0, 1), (2, 1), (1, 2), (1, 1)]  # corners, middles, centre
    cells = np.stack([number[i : i + 2 * along - 1 : 2, j : j + 2 * across - 1 : 2].ravel() for i, j in steps], axis=1)
    return dolfinx_mesh.create_mesh(MPI.COMM_SELF, cells, points, fenicsx.quadratic_domain("quadrilateral"))
