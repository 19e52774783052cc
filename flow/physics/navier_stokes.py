"""Steady incompressible Navier-Stokes in a lumen: the weak form in UFL, with one function for each term.

Strong form, with outward normal n:

    rho (u.grad) u - div sigma = 0,   div u = 0,   sigma = mu grad u - p I
    u = 0 on the wall,   u = Q g on the inlet with the mean of (-sigma n).n weighted by the profile g equal to MAP,
    sigma n = -P_i n + beta rho (u.n)_- u on outlet i,   P_i = P_v + R_i Q_i,   Q_i = integral of u.n over outlet i.

(u.n)_- = min(u.n, 0) is the backflow. `residual` holds all terms except the pressures P_i and MAP on the caps
(physics.outlets). sigma is the pseudo-stress, with grad u in place of grad u + (grad u)^T. With it a fully developed
profile leaves through an outlet undisturbed.

In the functions below u, p are velocity (m/s) and pressure (Pa), v, q their test functions, and w the convecting
velocity, all UFL expressions. `fluid` is a Fluid, `domain` a Domain.
"""

import dataclasses

import ufl

from flow.physics import viscosity as viscosities

# Speed in m/s and shear rate in 1/s. Their squares are added under the roots of |u| and of the shear rate, so that both
# can be differentiated at rest.
SPEED_FLOOR, SHEAR_RATE_FLOOR = 1e-4, 0.1


@dataclasses.dataclass
class Fluid:
    """Density in kg/m3, a viscosity of physics.viscosity, and the weights of two terms.

    grad_div: weight of the term (div u, div v), which is 0 for an exact flow; backflow: weight of the term on the
    outlets.
    """

    density: float
    viscosity: object
    grad_div: float  # gamma, Pa s
    backflow: float  # beta


@dataclasses.dataclass
class Domain:
    """UFL measures of the lumen (dx), its outlets and all caps, outward normal n, and width of the cells in m.

    The width of a cell of volume V is (3/4)^(1/2) (6 V)^(1/3): 0.77 of the edge of a regular tetrahedron.
    """

    dx: object
    outlets: object
    caps: object
    n: object
    width: object


def residual(u, p, v, q, fluid, domain):
    """The steady equations of (u, p) tested with (v, q)."""
    return oseen(u, u, p, v, q, fluid, domain)


def oseen(w, u, p, v, q, fluid, domain):
    """The equations of (u, p), with w as the convecting velocity and in the viscosity: linear in (u, p)."""
    return (
        friction(w, u, v, fluid, domain)
        + dilatation(u, v, fluid, domain)
        + continuity(u, p, v, q, domain)
        + convection(w, u, v, fluid, domain)
        + backflow(w, u, v, fluid, domain)
    )


def convection(w, u, v, fluid, domain):
    """rho ((w.grad) u + 1/2 (div w) u, v). Discrete flows have div w not exactly 0; the second part keeps energy
    conserved."""
    return fluid.density * ufl.inner(ufl.dot(ufl.grad(u), w) + 0.5 * ufl.div(w) * u, v) * domain.dx


def friction(w, u, v, fluid, domain):
    """mu (grad u, grad v) for a Newtonian fluid.

    Where mu depends on the shear rate of w, it is 2 mu (D(u), D(v)) minus <mu (grad u)^T n, v> on the caps. By the
    second term the traction on the caps stays sigma n, with the pseudo-stress sigma.
    """
    if isinstance(fluid.viscosity, viscosities.Newtonian):
        return fluid.viscosity.value * ufl.inner(ufl.grad(u), ufl.grad(v)) * domain.dx
    mu = fluid.viscosity(shear_rate(w))
    within = 2 * mu * ufl.inner(ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))) * domain.dx
    return within - mu * ufl.dot(ufl.dot(ufl.grad(u).T, domain.n), v) * domain.caps


def continuity(u, p, v, q, domain):
    """-(q, div u) of the continuity equation, and -(p, div v), the pressure gradient in the momentum equation."""
    return -(p * ufl.div(v) + q * ufl.div(u)) * domain.dx


def dilatation(u, v, fluid, domain):
    """gamma (div u, div v), the grad-div term: it improves the local mass balance."""
    return fluid.grad_div * ufl.div(u) * ufl.div(v) * domain.dx


def backflow(w, u, v, fluid, domain):
    """-beta rho <(w.n)_- u, v> on the outlets. With beta = 1/2 blood that flows back in brings no kinetic energy."""
    inward = 0.5 * (ufl.dot(w, domain.n) - abs(ufl.dot(w, domain.n)))
    return -fluid.density * fluid.backflow * inward * ufl.inner(u, v) * domain.outlets


def artificial_viscosity(w, u, v, eps, fluid, domain, dx):
    """eps rho h (|w| grad u, grad v): an artificial viscosity in proportion to the width h of a cell.

    dx: UFL measure of this term. solvers.continuation lowers eps to 0 if it can.
    """
    speed = ufl.sqrt(ufl.inner(w, w) + SPEED_FLOOR**2)
    return eps * fluid.density * domain.width * speed * ufl.inner(ufl.grad(u), ufl.grad(v)) * dx


def shear_rate(u):
    """Shear rate sqrt(2 D(u):D(u)) in 1/s, with SHEAR_RATE_FLOOR so that it can be differentiated at rest."""
    shear = ufl.sym(ufl.grad(u))
    return ufl.sqrt(2 * ufl.inner(shear, shear) + SHEAR_RATE_FLOOR**2)
