"""Steady incompressible Navier-Stokes: strong form, weak form, code.

Strong form, in the lumen with outward normal n:

    rho (u.grad) u - div sigma = 0,   div u = 0,   sigma = mu grad u - p I
    u = 0 on the wall,   u = Q g on the inlet with the mean of (-sigma n).n weighted by the profile g equal to MAP,
    sigma n = -P_i n + beta rho (u.n)_- u on outlet i,   P_i = P_v + R_i Q_i,   Q_i = integral of u.n over outlet i.

Weak form: find u, p with, for all v, q,

    rho ((u.grad) u + 1/2 (div u) u, v) + mu (grad u, grad v) - (p, div v) - (q, div u) + gamma (div u, div v)
      + rho (l^2 |D(u)| grad u, grad v) - beta rho sum_i <(u.n)_- u, v>_i + sum_i P_i <n, v>_i + MAP <n, v>_inlet = 0

Where mu depends on the shear rate |D| (physics.viscosity), mu (grad u, grad v) is 2 mu (D(u), D(v)) less its share of
the traction on the caps, <mu (grad u)^T n, v>: the same sigma n acts there.

1/2 (div u) u makes convection conserve energy for the discrete u; gamma (grad-div) improves its mass balance;
with beta = 1/2 backflow through an outlet brings no energy in. sigma is the pseudo-stress, so that a developed profile
leaves undisturbed. l = c l_jet is a mixing length in jets (geometry.jet), |D| = sqrt(2 D:D): with c = 0 the equations
are those above; c > 0 makes the jet's eddy viscosity, by which the way to c = 0 is steady (solvers.nonlinear).
"""

import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from flow.discretisation import compat
from flow.physics import viscosity as viscosities
from flow.geometry.tags import PHYSICAL_INLET

SLOWEST, SMALLEST_RATE = 1e-4, 0.1  # m/s, 1/s: keep the roots of |u| and |D| differentiable at rest


class NavierStokes:
    """Residual and tangents of a state w = (u, p) on a LumenSpace, SI units, compiled when first asked for.

    viscosity is one of physics.viscosity; space has W, mesh, facets (tags) and outlets (their tags), in three or two
    dimensions, for all but `residual` and `whole_tangent` also W's parts V and Q; mixing is c, jet_length the Function
    l_jet in m. picard freezes the convecting velocity and the viscosities and adds the inertia of a backward-Euler step
    with the local time step h / (|u| `rate`), rate = 1 / CFL number.
    """

    def __init__(self, space, state, density, viscosity, grad_div, backflow, jet_length):
        self.density = density
        u, p = ufl.split(state)
        v, q = ufl.TestFunctions(space.W)
        du, dp = ufl.TrialFunctions(space.W)
        degree = compat.degrees(space.W)[0]
        exact = 3 * degree - 1  # for convection on straight elements, which most are
        self._dx = dx = ufl.Measure("dx", domain=space.mesh, metadata={"quadrature_degree": exact})
        ds = ufl.Measure(
            "ds",
            domain=space.mesh,
            subdomain_data=space.facets,
            metadata={"quadrature_degree": exact + 1},
        )
        outlets = ds(tuple(space.outlets))
        n = ufl.FacetNormal(space.mesh)

        def transport(w, u_):
            """(w.grad) u + 1/2 (div w) u"""
            return ufl.dot(ufl.grad(u_), w) + 0.5 * ufl.div(w) * u_

        shear = ufl.sym(ufl.grad(u))
        rate = ufl.sqrt(2 * ufl.inner(shear, shear) + SMALLEST_RATE**2)

        def friction(u_):
            if isinstance(viscosity, viscosities.Newtonian):
                return viscosity.value * ufl.inner(ufl.grad(u_), ufl.grad(v)) * dx
            caps = ds((PHYSICAL_INLET, *space.outlets))
            return (
                2 * viscosity(rate) * ufl.inner(ufl.sym(ufl.grad(u_)), ufl.sym(ufl.grad(v))) * dx
                - viscosity(rate) * ufl.dot(ufl.dot(ufl.grad(u_).T, n), v) * caps
            )

        def dilatation(u_):
            return grad_div * ufl.div(u_) * ufl.div(v) * dx

        def stokes(u_, p_):
            return friction(u_) + dilatation(u_) - (p_ * ufl.div(v) + q * ufl.div(u_)) * dx

        inward = 0.5 * (ufl.dot(u, n) - abs(ufl.dot(u, n)))

        def returning(u_):
            return -density * backflow * inward * ufl.inner(u_, v) * outlets

        def oseen(u_):
            """Convection of u_ by the state, with the backflow term."""
            return density * ufl.inner(transport(u, u_), v) * dx + returning(u_)

        self.mixing = fem.Constant(space.mesh, PETSc.ScalarType(0.0))
        eddy_viscosity = density * (self.mixing * jet_length) ** 2 * rate

        def jet(u_):
            coarser = {"quadrature_degree": 2 * degree - 1}
            return eddy_viscosity * ufl.inner(ufl.grad(u_), ufl.grad(v)) * ufl.dx(space.mesh, metadata=coarser)

        self.losses = {"friction": friction(u), "grad_div": dilatation(u), "eddy": jet(u), "backflow": returning(u)}
        self.kinetic = lambda tags: 0.5 * density * ufl.inner(u, u) * ufl.dot(u, n) * ds(tags)  # leaves, in W
        self.rate = fem.Constant(space.mesh, PETSc.ScalarType(0.0))
        width = (6.0 / 8.0) ** 0.5 * abs(ufl.JacobianDeterminant(space.mesh)) ** (
            1.0 / space.mesh.geometry.dim
        )  # about half an edge

        def inertia(du_, v_, rate_):
            """Of a backward-Euler step with the local time step h / (|u| rate_)."""
            speed = ufl.sqrt(ufl.inner(u, u) + SLOWEST**2)
            return density * rate_ * speed / width * ufl.inner(du_, v_) * dx

        # without jets, and with them: where c is 0 nothing is computed for them
        steady = stokes(u, p) + oseen(u)
        self._residuals = steady, steady + jet(u)
        linear = stokes(du, dp) + oseen(du) + inertia(du, v, self.rate)
        self._picards = linear, linear + jet(du)
        self._inertia, self._mass = inertia, lambda du_, v_: density * ufl.inner(du_, v_) * dx
        self._space, self._state, self._compiled = space, state, {}
        self._arguments = ufl.TestFunction(space.W), ufl.TrialFunction(space.W)

    def _once(self, name, build):
        """The compiled form that build(index) makes when first asked for; index: of _residuals and _picards."""
        index = int(self.mixing.value > 0)
        if (name, index) not in self._compiled:
            self._compiled[name, index] = build(index)
        return self._compiled[name, index]

    @property
    def residual(self):
        """Without the pressure loads."""
        return self._once("residual", lambda index: compat.form(self._residuals[index]))

    def assembled(self, vector):
        """The residual at the present state, into `vector`."""
        with vector.localForm() as local:
            local.set(0.0)
        fem_petsc.assemble_vector(vector, self.residual)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)

    @staticmethod
    def integral(form):
        """Value of a form without arguments."""
        return float(fem.assemble_scalar(compat.form(form)))

    @property
    def whole_tangent(self):
        """Newton's over W, the derivative of the residual."""
        trial = self._arguments[1]
        return self._once("whole", lambda k: compat.form(ufl.derivative(self._residuals[k], self._state, trial)))

    @property
    def tangent(self):
        """Newton's velocity block, over V; `divergence` and its transposed are the rest of the tangent."""
        return self._once("tangent", lambda index: compat.form(self._velocity_tangent(index)))

    @property
    def picard(self):
        """The velocity block of Picard's linearisation with inertia."""
        test, trial = self._arguments

        def build(index):
            du, v = self._velocities()
            return compat.form(ufl.replace(self._picards[index], {test: self._padded(v), trial: self._padded(du)}))

        return self._once("picard", build)

    @property
    def divergence(self):
        """Continuity's row of the tangent, -(q, div du) with q in Q and du in V; it depends on no state."""
        du, q = ufl.TrialFunction(self._space.V), ufl.TestFunction(self._space.Q)
        return self._once("divergence", lambda _: compat.form(-q * ufl.div(du) * self._dx))

    @property
    def mass(self):
        """rho (du, v) over V, whose product with du/dt is the inertia of a flow in time."""
        return self._once("mass", lambda _: compat.form(self._mass(*self._velocities())))

    def _velocities(self):
        return ufl.TrialFunction(self._space.V), ufl.TestFunction(self._space.V)

    @staticmethod
    def _padded(velocity):
        """As one over W, with pressure 0."""
        return ufl.as_vector([*velocity, 0.0])

    def _velocity_tangent(self, index):
        du, v = self._velocities()
        momentum = ufl.replace(self._residuals[index], {self._arguments[0]: self._padded(v)})
        return ufl.derivative(momentum, self._state, self._padded(du))
