"""Material laws of a solid at finite strain, as UFL: a Yeoh wall, and a plaque of multiplicative J2 plasticity.

Source of the return mapping: J. C. Simo, T. J. R. Hughes, Computational Inelasticity (1998), box 9.1 (neo-Hookean,
isochoric-volumetric split, radial return in the Kirchhoff stress). It has a closed form, so UFL derives the tangent.
"""

import ufl

DEVIATORIC_DEGREE, VOLUMETRIC_DEGREE = 5, 3  # 3x3 Gauss points; only 2x2 for the volumetric part, which avoids locking


def deformation_gradient(u):
    """3x3 deformation gradient of a plane displacement u."""
    g = ufl.grad(u)
    return ufl.as_tensor([[1 + g[0, 0], g[0, 1], 0], [g[1, 0], 1 + g[1, 1], 0], [0, 0, 1]])


def plane_tensor(v):
    """Symmetric 3x3 tensor with components (11, 22, 33, 12) of v."""
    return ufl.as_tensor([[v[0], v[3], 0], [v[3], v[1], 0], [0, 0, v[2]]])


def full_tensor(v):
    """Symmetric 3x3 tensor with components (11, 22, 33, 12, 13, 23) of v."""
    return ufl.as_tensor([[v[0], v[3], v[4]], [v[3], v[1], v[5]], [v[4], v[5], v[2]]])


def plaque_return(f, plastic, hardening_strain, shear, yield_stress, hardening):
    """Radial return of the plaque.

    f: 3x3 deformation gradient. plastic: Cp^-1 at the last step, where Cp (3x3) is the right Cauchy-Green tensor of the
    plastic part of f. hardening_strain: equivalent plastic strain at the last step. shear, yield_stress, hardening:
    constants of the plaque in MPa. Returns (deviatoric Kirchhoff stress 3x3 in MPa, new Cp^-1, new equivalent plastic
    strain).
    """
    volume = ufl.det(f)
    be_bar = volume ** (-2.0 / 3.0) * f * plastic * f.T
    trace = ufl.tr(be_bar)
    trial = shear * ufl.dev(be_bar)
    size = ufl.sqrt(ufl.inner(trial, trial) + 1e-16)
    mu_bar = shear * trace / 3
    excess = size - (2.0 / 3.0) ** 0.5 * (yield_stress + hardening * hardening_strain)
    flow = ufl.conditional(ufl.gt(excess, 0), excess, 0.0) / (2 * mu_bar * (1 + hardening / (3 * mu_bar)))
    stress = (1 - 2 * mu_bar * flow / size) * trial
    inverse = ufl.inv(f)
    new_plastic = volume ** (2.0 / 3.0) * inverse * (stress / shear + trace / 3 * ufl.Identity(3)) * inverse.T
    return stress, new_plastic, hardening_strain + (2.0 / 3.0) ** 0.5 * flow


def wall_stress(f, c10, c20):
    """Deviatoric Kirchhoff stress of the Yeoh wall W = c10 (I1 - 3) + c20 (I1 - 3)^2, with the isochoric I1."""
    b_bar = isochoric_left_cauchy_green(f)
    return 2 * (c10 + 2 * c20 * (ufl.tr(b_bar) - 3)) * ufl.dev(b_bar)


def isochoric_left_cauchy_green(f):
    """Left Cauchy-Green tensor of the deformation gradient f without its change of volume."""
    return ufl.det(f) ** (-2.0 / 3.0) * f * f.T


def volumetric_stress(f, bulk):
    """Kirchhoff pressure (positive in tension) of the energy U = bulk/4 (J^2 - 1 - 2 ln J), where J = det f."""
    return 0.5 * bulk * (ufl.det(f) ** 2 - 1)


def device_pressure(distance, radius, stiffness, cap, smoothing_mm=0.004, sqrt=ufl.sqrt):
    """Pressure (MPa) of a round device on a wall at distance d from its axis: smoothcap(k <R - d>).

    R: free radius (mm). k: stiffness (MPa/mm). <x> is x if positive, else 0, smoothed over smoothing_mm. smoothcap(p) =
    p c / (p^4 + c^4)^(1/4) tends to the cap c (MPa). sqrt: square root that suits the arguments, numpy.sqrt for arrays.
    """
    gap = radius - distance
    p = stiffness * 0.5 * (gap + sqrt(gap**2 + smoothing_mm**2))
    return p * cap / (p**4 + cap**4) ** 0.25
