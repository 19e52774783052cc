"""Steady incompressible Navier-Stokes in a lumen: the weak form, one function a term, in UFL.

Strong form, with outward normal n:

    rho (u.grad) u - div sigma = 0,   div u = 0,   sigma = mu grad u - p I
    u = 0 on the wall,   u = Q g on the inlet with the mean of (-sigma n).n weighted by the profile g equal to MAP,
    sigma n = -P_i n + beta rho (u.n)_- u on outlet i,   P_i = P_v + R_i Q_i,   Q_i = integral of u.n over outlet i.

`residual` is the whole of it but for the pressures P_i and MAP on the caps (physics.outlets). sigma is the
pseudo-stress, so that a developed profile leaves undisturbed.
"""

import dataclasses

import ufl

from flow.physics import viscosity as viscosities

SLOWEST, SMALLEST_RATE = 1e-4, 0.1  # m/s, 1/s: keep the roots of |u| and |D| differentiable at rest


@dataclasses.dataclass
class Fluid:
    """Density (kg/m3), a viscosity of physics.viscosity, weights of the terms that only the discrete flow needs."""

    density: float
    viscosity: object
    grad_div: float  # gamma, Pa s
    backflow: float  # beta


@dataclasses.dataclass
class Domain:
    """Measures of the lumen, of its outlets and of all caps; normal; width of the cells, about half an edge (m)."""

    dx: object
    outlets: object
    caps: object
    n: object
    width: object


def residual(u, p, v, q, fluid, on):
    """The steady equations of (u, p) tested with (v, q)."""
    return oseen(u, u, p, v, q, fluid, on)


def oseen(w, u, p, v, q, fluid, on):
    """Those equations with (u, p) where the flow w carries it and sets its viscosity."""
    return (
        friction(w, u, v, fluid, on)
        + dilatation(u, v, fluid, on)
        + continuity(u, p, v, q, on)
        + convection(w, u, v, fluid, on)
        + backflow(w, u, v, fluid, on)
    )


def convection(w, u, v, fluid, on):
    """rho ((w.grad) u + 1/2 (div w) u, v): the second part makes it conserve energy for the discrete w."""
    return fluid.density * ufl.inner(ufl.dot(ufl.grad(u), w) + 0.5 * ufl.div(w) * u, v) * on.dx


def friction(w, u, v, fluid, on):
    """mu (grad u, grad v); where mu depends on the shear rate of w 2 mu (D(u), D(v)) less its share of the traction on
    the caps, <mu (grad u)^T n, v>: the same sigma n acts there."""
    if isinstance(fluid.viscosity, viscosities.Newtonian):
        return fluid.viscosity.value * ufl.inner(ufl.grad(u), ufl.grad(v)) * on.dx
    mu = fluid.viscosity(shear_rate(w))
    within = 2 * mu * ufl.inner(ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))) * on.dx
    return within - mu * ufl.dot(ufl.dot(ufl.grad(u).T, on.n), v) * on.caps


def continuity(u, p, v, q, on):
    """-(q, div u), and the pressure's force -(p, div v)."""
    return -(p * ufl.div(v) + q * ufl.div(u)) * on.dx


def dilatation(u, v, fluid, on):
    """gamma (div u, div v), grad-div: a better mass balance."""
    return fluid.grad_div * ufl.div(u) * ufl.div(v) * on.dx


def backflow(w, u, v, fluid, on):
    """-beta rho <(w.n)_- u, v> on the outlets: with beta = 1/2 blood that flows back in brings no energy."""
    inward = 0.5 * (ufl.dot(w, on.n) - abs(ufl.dot(w, on.n)))
    return -fluid.density * fluid.backflow * inward * ufl.inner(u, v) * on.outlets


def artificial(w, u, v, eps, fluid, on, dx):
    """eps rho h (|w| grad u, grad v): a viscosity in proportion to the cell's width; solvers.continuation takes eps
    to 0."""
    speed = ufl.sqrt(ufl.inner(w, w) + SLOWEST**2)
    return eps * fluid.density * on.width * speed * ufl.inner(ufl.grad(u), ufl.grad(v)) * dx


def shear_rate(u):
    """|D(u)| = sqrt(2 D:D), differentiable at rest."""
    shear = ufl.sym(ufl.grad(u))
    return ufl.sqrt(2 * ufl.inner(shear, shear) + SMALLEST_RATE**2)
