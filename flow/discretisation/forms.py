"""The compiled forms of physics.navier_stokes on a function space: residual, tangents, terms of the energy balance.

The artificial viscosity is eps rho h |u| (physics.navier_stokes). With eps = 0 the compiled forms do not contain it.
"""

import ufl
from dolfinx import fem
from petsc4py import PETSc

from flow.discretisation import compat
from flow.geometry.tags import PHYSICAL_INLET
from flow.physics import navier_stokes as weak, viscosity as viscosities


class NavierStokes:
    """Residual and tangents of a state w = (u, p) on a LumenSpace, in SI units, each compiled at its first use.

    state: Function on space.W; density in kg/m3; viscosity: law of physics.viscosity; grad_div in Pa s; backflow:
    coefficient beta of the outlet term. `artificial_viscosity` is a constant with the value eps. `space` may also be
    another object, in two or three dimensions, with W, mesh, facet_tags and outlet_tags. All forms but `residual` also
    need the parts V and Q of W.
    """

    def __init__(self, space, state, density, viscosity, grad_div, backflow):
        self.density = density
        u, p = ufl.split(state)
        v, q = ufl.TestFunctions(space.W)
        du, dp = ufl.TrialFunctions(space.W)
        mesh, degree = space.mesh, compat.degrees(space.W)[0]
        exact_degree = 3 * degree - 1  # polynomial degree of the convection term on straight elements, as most are
        dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": exact_degree})
        ds = ufl.Measure(
            "ds", domain=mesh, subdomain_data=space.facet_tags, metadata={"quadrature_degree": exact_degree + 1}
        )
        coarse_dx = ufl.dx(mesh, metadata={"quadrature_degree": 2 * degree - 1})
        width = (6.0 / 8.0) ** 0.5 * abs(ufl.JacobianDeterminant(mesh)) ** (1.0 / mesh.geometry.dim)
        outlets, caps = ds(tuple(space.outlet_tags)), ds((PHYSICAL_INLET, *space.outlet_tags))
        domain = weak.Domain(dx, outlets, caps, ufl.FacetNormal(mesh), width)
        fluid = weak.Fluid(density, viscosity, grad_div, backflow)
        self.artificial_viscosity = fem.Constant(mesh, PETSc.ScalarType(0.0))

        def artificial(u_):
            return weak.artificial_viscosity(u, u_, v, self.artificial_viscosity, fluid, domain, coarse_dx)

        steady = weak.residual(u, p, v, q, fluid, domain)
        linear = weak.oseen(u, du, dp, v, q, fluid, domain)
        self._residuals, self._picards = (steady, steady + artificial(u)), (linear, linear + artificial(du))
        self.losses = {
            "friction": weak.friction(u, u, v, fluid, domain),
            "grad_div": weak.dilatation(u, v, fluid, domain),
            "artificial": artificial(u),
            "backflow": weak.backflow(u, u, v, fluid, domain),
        }
        # kinetic energy that leaves the lumen through the boundaries `tags`, in watts
        self.kinetic_energy_flow = lambda tags: 0.5 * density * ufl.inner(u, u) * ufl.dot(u, domain.n) * ds(tags)
        self._mass = lambda du_, v_: density * ufl.inner(du_, v_) * dx
        self._dx, self._space, self._state, self._compiled = dx, space, state, {}
        self._arguments = ufl.TestFunction(space.W), ufl.TrialFunction(space.W)

    def _compiled_form(self, name, build):
        """The compiled form `name`, made by build(index) at its first use.

        index: 1 with artificial viscosity, else 0. It selects the form in _residuals and _picards.
        """
        index = int(self.artificial_viscosity.value > 0)
        if (name, index) not in self._compiled:
            self._compiled[name, index] = build(index)
        return self._compiled[name, index]

    @property
    def residual(self):
        """The compiled residual over W, without the pressure loads of inlet and outlets."""
        return self._compiled_form("residual", lambda index: compat.form(self._residuals[index]))

    def assemble_residual(self):
        """The residual (n,) over W at the present state."""
        return compat.assemble(self.residual)

    def artificial_force(self):
        """The part of the residual (n,) over W that the artificial viscosity makes, at the present state."""
        return compat.assemble(self._compiled_form("artificial", lambda _: compat.form(self.losses["artificial"])))

    @staticmethod
    def integral(form):
        """Value of a UFL form without test or trial functions."""
        return float(fem.assemble_scalar(compat.form(form)))

    @property
    def tangent(self):
        """Velocity block of Newton's tangent, over V; the rest of the tangent is `divergence` and its transpose."""
        return self._compiled_form("tangent", lambda index: compat.form(self._velocity_tangent(index)))

    @property
    def picard(self):
        """Velocity block of Picard's linearisation. It keeps the convecting velocity and the viscosities fixed."""
        test, trial = self._arguments

        def build(index):
            du, v = self._velocities()
            return compat.form(
                ufl.replace(
                    self._picards[index], {test: self._with_zero_pressure(v), trial: self._with_zero_pressure(du)}
                )
            )

        return self._compiled_form("picard", build)

    @property
    def divergence(self):
        """Rows of the tangent for the continuity equation: -(q, div du), q in Q, du in V. They depend on no state."""
        du, q = ufl.TrialFunction(self._space.V), ufl.TestFunction(self._space.Q)
        return self._compiled_form("divergence", lambda _: compat.form(-q * ufl.div(du) * self._dx))

    @property
    def mass(self):
        """rho (du, v) over V. In a time-dependent flow this matrix times du/dt is the force of inertia."""
        return self._compiled_form("mass", lambda _: compat.form(self._mass(*self._velocities())))

    def _velocities(self):
        """(trial function, test function) of the velocity over V."""
        return ufl.TrialFunction(self._space.V), ufl.TestFunction(self._space.V)

    @staticmethod
    def _with_zero_pressure(velocity):
        """A velocity over V as a function over W, with pressure 0."""
        return ufl.as_vector([*velocity, 0.0])

    def _velocity_tangent(self, index):
        """UFL derivative of the momentum residual with respect to the velocity, over V. index: see `_compiled_form`."""
        du, v = self._velocities()
        momentum = ufl.replace(self._residuals[index], {self._arguments[0]: self._with_zero_pressure(v)})
        return ufl.derivative(momentum, self._state, self._with_zero_pressure(du))


def from_document(space, state, document, settings):
    """NavierStokes with the fluid of `document`, the content of boundary.json, and the weights of the settings."""
    fluid = document["density_kg_per_m3"], viscosities.from_document(document)
    return NavierStokes(space, state, *fluid, settings.grad_div_pa_s, settings.backflow_coefficient)
