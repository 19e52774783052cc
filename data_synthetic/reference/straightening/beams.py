"""Beams along the axis of a vessel: the stent, which is straight if free, and the vessel, which shears."""

import numpy as np
from scipy.sparse import coo_matrix

LARGEST_ELEMENT_MM = 0.25
TANGENT_STEP_MM = 1e-3  # half the step of the central difference that gives the curvature from tangents


def shear_share(inner_outer_area):
    """Share of a tube's section that bears shear: 6/11 if it is thin, 0.9 if it is full.

    inner_outer_area: area inside the tube over that inside its outside. Poisson's ratio is 0.5 (Cowper, J Appl Mech 33
    (1966) 335, hollow circle).
    """
    both = (1 + inner_outer_area) ** 2
    return 9 * both / (10 * both + 26 * inner_outer_area)


def healthy_stiffness(branch, wall_mm, middle_s_mm, settings):
    """(bending stiffness E I in N mm2, shear stiffness in N) of the healthy wall as at middle_s_mm.

    The wall is a tube. E = 6 C10 and G = 2 C10 are the moduli of a Yeoh solid at small strain. settings: section
    `reference`.
    """
    inner = float(branch.healthy_radius(np.array(middle_s_mm)))
    outer, c10 = inner + wall_mm, settings["wall_c10_mpa"]
    bending = 6 * c10 * np.pi / 4 * (outer**4 - inner**4)
    return bending, shear_share((inner / outer) ** 2) * 2 * c10 * np.pi * (outer**2 - inner**2)


def foundation_n_per_mm2(branch, wall_mm, middle_s_mm, settings):
    """Support of the vessel by the tissue around it, as at middle_s_mm: force per length and sideways displacement.

    The surroundings resist a radial displacement with the pressure 2 G / r_outer per displacement, G being their shear
    modulus (see materials). If the cylinder moves sideways, the part of this pressure along the motion varies as the
    cosine squared of the angle from the motion. Its integral round the cylinder is 2 pi G per length. The exact value
    for a slender rod in an incompressible medium is the same within a tenth, at the wavelength of this supported beam.
    """
    outer = float(branch.healthy_radius(np.array(middle_s_mm))) + wall_mm
    return np.pi * outer * settings["support_mpa_per_mm"]


def nodes(length_mm, stents, step_mm=LARGEST_ELEMENT_MM):
    """Arc lengths (n,) from 0 to length_mm, at most step_mm apart, the stents' ends among them."""
    ends = np.unique(np.clip([0.0, length_mm] + [e for one in stents for e in one.ends()], 0, length_mm))
    parts = [np.linspace(a, b, int(np.ceil((b - a) / step_mm - 1e-9)) + 1) for a, b in zip(ends[:-1], ends[1:])]
    return np.unique(np.concatenate(parts))


def stent_bending(stents, s_mm):
    """Bending stiffness (n - 1,) in N mm2 of the stents between the nodes s_mm (n,): the largest where they overlap."""
    middle = 0.5 * (s_mm[1:] + s_mm[:-1])
    return np.max([one.bending_n_mm2 * one.covers(middle) for one in stents], axis=0)


def stent_matrix(s_mm, bending_n_mm2):
    """Stiffness (2n, 2n) of a slender beam, over deflection (mm) and slope of each node in turn.

    s_mm (n,): arc lengths of the nodes. bending_n_mm2 (n - 1,): E I of the cubic Hermite elements between them.
    """
    h = np.diff(s_mm)
    second_derivatives, _, weights = _hermite_curvatures(h)
    element = np.einsum(
        "eg,egi,egj->eij",
        bending_n_mm2[:, None] * 0.5 * h[:, None] * weights,
        second_derivatives,
        second_derivatives,
    )
    return _assembled(element)


def straightening_load(axis, s_mm, bending_n_mm2):
    """Load (2n, 3), over the unknowns of `stent_matrix`, of stents that are straight if free and bent along the axis.

    bending_n_mm2 (n - 1,): E I of the stents in the elements between the nodes s_mm (n,).
    """
    h = np.diff(s_mm)
    second_derivatives, points, weights = _hermite_curvatures(h)
    natural_curvature = curvature_vectors(axis, 0.5 * (s_mm[1:] + s_mm[:-1])[:, None] + 0.5 * h[:, None] * points)
    load = -np.einsum(
        "eg,egi,egk->eik",
        bending_n_mm2[:, None] * (0.5 * h[:, None] * weights),
        second_derivatives,
        natural_curvature,
    )
    right_side = np.zeros((2 * len(s_mm), 3))
    np.add.at(right_side, _unknowns(len(h)), load)
    return right_side


def vessel_matrix(s_mm, bending_n_mm2, shear_n, foundation_n_per_mm2=0.0):
    """Stiffness (2n, 2n) of a beam that shears, over deflection (mm) and rotation of each of its n nodes in turn.

    s_mm (n,): arc lengths of the nodes. bending_n_mm2 (E I) and shear_n (shear modulus times the section that bears
    shear): those of the elements, each (n - 1,) or one for all. foundation_n_per_mm2: support per length and
    deflection, lumped to the nodes. The elements are exact under loads at the nodes (Przemieniecki, Theory of Matrix
    Structural Analysis, 1968).
    """
    h = np.diff(s_mm)
    bending, shear = np.broadcast_to(bending_n_mm2, h.shape), np.broadcast_to(shear_n, h.shape)
    phi = 12 * bending / (shear * h**2)
    twelve, half = 12 * np.ones_like(h), 6 * h
    near, far = (4 + phi) * h**2, (2 - phi) * h**2
    rows = [
        [twelve, half, -twelve, half],
        [half, near, -half, far],
        [-twelve, -half, twelve, -half],
        [half, far, -half, near],
    ]
    element = np.moveaxis(np.array(rows), 2, 0) * (bending / (h**3 * (1 + phi)))[:, None, None]
    element[:, [0, 2], [0, 2]] += 0.5 * foundation_n_per_mm2 * h[:, None]
    return _assembled(element)


def curvature_vectors(axis, s_mm):
    """Curvature vectors c'' (..., 3) in 1/mm of an axis at arc lengths s_mm."""
    low, high = np.maximum(s_mm - TANGENT_STEP_MM, 0), np.minimum(s_mm + TANGENT_STEP_MM, axis.length_mm)
    return (axis.frame(high)[0] - axis.frame(low)[0]) / (high - low)[..., None]


def _unknowns(elements):
    """Numbers (elements, 4) of the unknowns of each element: deflection and slope of its two nodes."""
    return 2 * np.arange(elements)[:, None] + np.arange(4)


def _assembled(element):
    """Sparse matrix (2n, 2n) of the elements' matrices (n - 1, 4, 4)."""
    unknowns = _unknowns(len(element))
    rows, columns = np.repeat(unknowns, 4, axis=1).ravel(), np.tile(unknowns, 4).ravel()
    size = 2 * len(element) + 2
    return coo_matrix((element.ravel(), (rows, columns)), shape=(size, size)).tocsc()


def _hermite_curvatures(h):
    """Second derivatives of the cubic Hermite functions at 4 Gauss points of elements: (values, points, weights).

    h (e,): lengths of the elements. The values have the shape (elements, points, functions).
    """
    points, weights = np.polynomial.legendre.leggauss(4)
    x = 0.5 * (1 + points)
    h = h[:, None]
    second_derivative = [(12 * x - 6) / h**2, (6 * x - 4) / h, (6 - 12 * x) / h**2, (6 * x - 2) / h]
    return np.stack(second_derivative, axis=2), points, weights
