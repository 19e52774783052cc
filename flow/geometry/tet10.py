"""The quadratic tetrahedron: nodes 0-3 at the corners, 4-9 at the middles of the edges EDGES, in that order.

With the barycentric coordinates l_i, also called lam, the basis functions are N_i = l_i (2 l_i - 1) at corners and
N_ab = 4 l_a l_b at middles.
"""

import numpy as np

from flow.geometry.vectors import determinant

EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [2, 3], [1, 3]])  # gmsh's order of middle nodes
VTK_ORDER = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]  # VTK's last two middle nodes are those of the edges 13, 23
OUTWARD_FACES = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))  # corners, outwards for a tetrahedron of positive volume
LEAST_JACOBIAN_RATIO = 0.05  # meshes with a smaller ratio of least to largest Jacobian in a cell are refused


def six_volumes(points, tetrahedra):
    """Six times the signed volumes (t,) of tetrahedra (t, 4 or more) with straight edges, by points (n, 3)."""
    a, b, c, d = (points[tetrahedra[:, k]] for k in range(4))
    return np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a))


def orient_positive(points, tetrahedra):
    """The tetrahedra (t, 4), two corners of those with negative volume swapped, so that all volumes are positive."""
    negative = six_volumes(points, tetrahedra) < 0
    tetrahedra = tetrahedra.copy()
    tetrahedra[negative] = tetrahedra[negative][:, [0, 2, 1, 3]]
    return tetrahedra


def basis(lam):
    """Basis functions (..., 10) at barycentric coordinates lam (..., 4)."""
    return np.concatenate([lam * (2 * lam - 1), 4 * lam[..., EDGES[:, 0]] * lam[..., EDGES[:, 1]]], axis=-1)


def gradients(lam):
    """Derivatives (..., 10, 3) of the basis functions by (l_1, l_2, l_3) at barycentric coordinates lam (..., 4)."""
    dl = np.array([[-1.0, -1.0, -1.0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    corners = (4 * lam - 1)[..., None] * dl
    a, b = EDGES[:, 0], EDGES[:, 1]
    middles = 4 * (lam[..., a, None] * dl[b] + lam[..., b, None] * dl[a])
    return np.concatenate([corners, middles], axis=-2)


def _cubic_lattice():
    """All quadruples (20, 4) of integers from 0 on with the sum 3: the places of a cubic's Bezier coefficients."""
    return np.array([[3 - i - j - k, i, j, k] for i in range(4) for j in range(4 - i) for k in range(4 - i - j)])


def _bernstein(lam, index):
    """Cubic Bernstein polynomials of the lattice `index` (20, 4) at barycentric coordinates lam (..., 4)."""
    factorial = np.array([1, 1, 2, 6])
    coefficient = 6 / factorial[index].prod(axis=1)
    return coefficient * np.prod(lam[..., None, :] ** index, axis=-1)


_LATTICE = _cubic_lattice()
_POINTS = _LATTICE / 3.0  # barycentric coordinates of 20 points, whose values determine a cubic
# Matrix from a cubic's values at _POINTS to its Bezier coefficients. Its exact entries are multiples of 1 / 12.
_TO_BEZIER = np.round(12 * np.linalg.inv(_bernstein(_POINTS, _LATTICE))) / 12
_GRADIENTS = gradients(_POINTS)


def jacobian_bounds(nodes):
    """(lower (t,), upper (t,)) bounds of det J in elements with the nodes (t, 10, 3).

    J is the derivative of the map from the reference element. det J is a cubic polynomial, and its Bezier coefficients
    bound it from both sides (Johnen, Remacle, Geuzaine 2013, J Comput Phys 233).
    """
    jacobian = np.einsum("tnx,pnr->tpxr", nodes, _GRADIENTS)
    bezier = np.einsum("tp,bp->tb", determinant(jacobian), _TO_BEZIER)
    return bezier.min(axis=1), bezier.max(axis=1)


def count_overlapping(tetrahedra):
    """Number of faces with both of their cells on the same side; tetrahedra (n, 4), each of positive volume.

    This happens where a mesh was folded and a cell is inverted. The cell by itself looks good, but it overlaps its
    neighbours, and the flow through their common faces is lost.
    """
    faces = np.concatenate([tetrahedra[:, face] for face in OUTWARD_FACES])
    first = faces.argmin(axis=1)
    turned = np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1)  # the least corner first
    _, counts = np.unique(turned, axis=0, return_counts=True)
    return int((counts > 1).sum())
