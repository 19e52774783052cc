"""Straightening of the vessel by its stent: a beam on an elastic foundation along the branch's axis."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

LARGEST_ELEMENT_MM = 0.25
TANGENT_STEP_MM = 1e-3  # half the step of the central difference that gives the curvature from tangents


def wall_bending_n_mm2(inner_mm, outer_mm, wall_c10_mpa):
    """Bending stiffness E I of the healthy wall, a tube: E = 6 C10, the small-strain modulus of a Yeoh solid."""
    return 6 * wall_c10_mpa * np.pi / 4 * (outer_mm**4 - inner_mm**4)


def axis_displacement(branch, wall_mm, stents, middle_s_mm, settings):
    """Displacement of a branch's axis by its stents: (arc lengths (n,) mm, displacement (n, 3) mm).

    It is computed by `beam_displacement`, with wall and surroundings as at middle_s_mm all along. settings: section
    `reference`.

    The surroundings resist a radial displacement with the pressure 2 G / r_outer per displacement, G being their shear
    modulus (see materials). If the cylinder moves sideways, the part of this pressure along the motion varies as the
    cosine squared of the angle from the motion. Its integral round the cylinder is 2 pi G per length. The exact value
    for a slender rod in an incompressible medium is the same within a tenth, at the wavelength of this supported beam.
    """
    return beam_displacement(branch.axis, stents, *vessel_beam(branch, wall_mm, middle_s_mm, settings))


def vessel_beam(branch, wall_mm, middle_s_mm, settings):
    """(bending stiffness in N mm2, foundation in N/mm2) of the vessel as at middle_s_mm."""
    outer = float(branch.healthy_radius(np.array(middle_s_mm))) + wall_mm
    foundation = np.pi * outer * settings["support_mpa_per_mm"]
    return vessel_bending_n_mm2(branch, wall_mm, middle_s_mm, settings), foundation


def vessel_bending_n_mm2(branch, wall_mm, middle_s_mm, settings):
    """The setting `vessel_bending_n_mm2`; if it is None, the bending stiffness of the healthy wall at middle_s_mm."""
    if settings["vessel_bending_n_mm2"] is not None:
        return settings["vessel_bending_n_mm2"]
    inner = float(branch.healthy_radius(np.array(middle_s_mm)))
    return wall_bending_n_mm2(inner, inner + wall_mm, settings["wall_c10_mpa"])


def beam_displacement(axis, stents, vessel_bending_n_mm2, foundation_n_per_mm2, step_mm=LARGEST_ELEMENT_MM):
    """Displacement of the axis: (arc length s (n,) mm, displacement w (n, 3) mm), zero with zero slope at both ends.

    w minimises the integral of E_s |c'' + w''|^2 + E_v |w''|^2 + k |w|^2 over s, where c is the axis before the stent.
    E_s is the bending stiffness of the stents at s, which are straight if free. E_v is the bending stiffness of the
    vessel, which is free of load in its shape c. k is the tissue's support per length. Displacements are small; axial
    stretch is free. The elements are cubic Hermite elements of at most step_mm, with nodes at the stents' ends. So the
    error falls with the fourth power of step_mm.
    """
    s = _beam_nodes(axis.length_mm, stents, step_mm)
    if not stents:
        return s, np.zeros((len(s), 3))
    middle = 0.5 * (s[1:] + s[:-1])
    stent_bending = np.zeros(len(middle))
    for each_stent in stents:
        stent_bending = np.maximum(stent_bending, np.where(each_stent.covers(middle), each_stent.bending_n_mm2, 0.0))
    matrix = beam_matrix(s, stent_bending + vessel_bending_n_mm2, foundation_n_per_mm2)
    right_side = straightening_load(axis, s, stent_bending)
    free = slice(2, -2)
    solved = np.zeros((2 * len(s), 3))
    solved[free] = spsolve(matrix[free, free], right_side[free])
    return s, solved[::2]


def beam_matrix(s_mm, bending_n_mm2, foundation_n_per_mm2):
    """Stiffness (2n, 2n) of a beam on a foundation, over deflection (mm) and slope of each node in turn.

    s_mm (n,): arc lengths of the nodes; bending_n_mm2 (n - 1,): E I of the elements between them.
    """
    h = np.diff(s_mm)
    second_derivatives, values, _, weights = _hermite_functions(h)
    integration_weights = 0.5 * h[:, None] * weights
    stiffness = np.einsum(
        "eg,egi,egj->eij", bending_n_mm2[:, None] * integration_weights, second_derivatives, second_derivatives
    )
    stiffness += foundation_n_per_mm2 * np.einsum("eg,egi,egj->eij", integration_weights, values, values)
    unknowns = _beam_unknowns(len(h))
    shape = (2 * len(s_mm), 2 * len(s_mm))
    rows, columns = np.repeat(unknowns, 4, axis=1).ravel(), np.tile(unknowns, 4).ravel()
    return coo_matrix((stiffness.ravel(), (rows, columns)), shape=shape).tocsc()


def straightening_load(axis, s_mm, stent_bending_n_mm2):
    """Load (2n, 3), over the unknowns of `beam_matrix`, of stents that are straight if free and bent along the axis.

    stent_bending_n_mm2 (n - 1,): E I of the stents in the elements between the nodes s_mm (n,).
    """
    h = np.diff(s_mm)
    second_derivatives, _, points, weights = _hermite_functions(h)
    natural_curvature = _curvature_vectors(axis, 0.5 * (s_mm[1:] + s_mm[:-1])[:, None] + 0.5 * h[:, None] * points)
    load = -np.einsum(
        "eg,egi,egk->eik",
        stent_bending_n_mm2[:, None] * (0.5 * h[:, None] * weights),
        second_derivatives,
        natural_curvature,
    )
    right_side = np.zeros((2 * len(s_mm), 3))
    np.add.at(right_side, _beam_unknowns(len(h)), load)
    return right_side


def _beam_unknowns(elements):
    """Numbers (elements, 4) of the unknowns of each element: deflection and slope of its two nodes."""
    return 2 * np.arange(elements)[:, None] + np.arange(4)


def _beam_nodes(length_mm, stents, step_mm):
    """Arc lengths (n,) from 0 to length_mm, at most step_mm apart, the stents' ends among them."""
    ends = np.unique(np.clip([0.0, length_mm] + [e for one in stents for e in one.ends()], 0, length_mm))
    parts = [np.linspace(a, b, int(np.ceil((b - a) / step_mm - 1e-9)) + 1) for a, b in zip(ends[:-1], ends[1:])]
    return np.unique(np.concatenate(parts))


def _hermite_functions(h):
    """Cubic Hermite functions at 4 Gauss points of elements: (second derivatives, values, points, weights).

    h (e,): lengths of the elements. Second derivatives and values have the shape (elements, points, functions).
    """
    points, weights = np.polynomial.legendre.leggauss(4)
    x = 0.5 * (1 + points)
    one = np.ones((len(h), 1))
    h = h[:, None]
    value = [
        one * (1 - 3 * x**2 + 2 * x**3),
        h * (x - 2 * x**2 + x**3),
        one * (3 * x**2 - 2 * x**3),
        h * (x**3 - x**2),
    ]
    second_derivative = [(12 * x - 6) / h**2, (6 * x - 4) / h, (6 - 12 * x) / h**2, (6 * x - 2) / h]
    return np.stack(second_derivative, axis=2), np.stack(value, axis=2), points, weights


def _curvature_vectors(axis, s_mm):
    """Curvature vectors c'' (..., 3) in 1/mm of an axis at arc lengths s_mm."""
    low, high = np.maximum(s_mm - TANGENT_STEP_MM, 0), np.minimum(s_mm + TANGENT_STEP_MM, axis.length_mm)
    return (axis.frame(high)[0] - axis.frame(low)[0]) / (high - low)[..., None]
