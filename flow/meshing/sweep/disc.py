"""The template of a cross-section: the unit disc in rings of 6, 12, 18, ... points, triangulated.

Boundary layers split the outermost ring. The circles between the layers have as many points as the rim, so the
triangles on the wall are the same with and without layers.
"""

import dataclasses

import numpy as np

LAYER_GROWTH = 2.0  # width of a boundary layer over the width of the next one towards the wall


@dataclasses.dataclass
class Disc:
    """The triangulated unit disc.

    vertices (n, 2), and middles (e, 2) of the edges (e, 2), both as (rho, angle in rad); triangles (t, 3)
    counter-clockwise; rim (6 rings,): numbers of the outermost vertices in order of angle.
    """

    rings: int
    vertices: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray
    middles: np.ndarray
    rim: np.ndarray


def make(rings, wall_layers=1):
    """Disc of `rings` rings of equal width, the outermost one split into `wall_layers` layers."""
    vertices, first = [[0.0, 0.0]], [0]
    for k in range(1, rings + 1):
        first.append(len(vertices))
        vertices += [[k / rings, np.pi * j / (3 * k)] for j in range(6 * k)]
    triangles = []
    for k in range(1, rings + 1):
        triangles += _ring_triangles(k, first)
    if wall_layers > 1:
        vertices, triangles = _split_outer_ring(wall_layers, vertices, triangles, first[rings])
    vertices, triangles = np.array(vertices), np.array(triangles)
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges = np.unique(sides, axis=0)
    rim = np.arange(len(vertices) - 6 * rings, len(vertices))
    return Disc(rings, vertices, triangles, edges, _edge_middles(vertices, edges), rim)


def _ring_triangles(k, first):
    """Triangles between the circles k - 1 and k, counter-clockwise; first[k]: number of circle k's first vertex."""

    def outer(sector, j):
        return first[k] + (sector * k + j) % (6 * k)

    def inner(sector, j):
        return first[k - 1] + (sector * (k - 1) + j) % (6 * (k - 1)) if k > 1 else 0

    found = []
    for sector in range(6):
        for j in range(k):
            found.append([inner(sector, j), outer(sector, j), outer(sector, j + 1)])
            if j < k - 1:
                found.append([inner(sector, j), outer(sector, j + 1), inner(sector, j + 1)])
    return found


def _split_outer_ring(layers, vertices, triangles, outermost):
    """(vertices, triangles) of the disc with its outermost ring split into `layers` layers.

    The triangles of the outermost ring become those of the innermost layer, since its outer circle moves inwards.
    Further circles are added outside it. Each quadrilateral of the other layers is split into two triangles. outermost:
    number of the first vertex of the outermost circle.
    """
    rim, rest = vertices[outermost:], vertices[:outermost]
    around, inner = len(rim), rest[-1][0]
    widths = LAYER_GROWTH ** -np.arange(layers, dtype=float)
    for end in np.cumsum(widths) / widths.sum():
        rest += [[inner + end * (1.0 - inner), angle] for _, angle in rim]
    a = np.arange(around)
    b = (a + 1) % around
    for layer in range(layers - 1):
        low = outermost + layer * around
        sides = np.stack([[a, a + around, b + around], [a, b + around, b]]) + low
        triangles += np.moveaxis(sides, 1, 2).reshape(-1, 3).tolist()
    return rest, triangles


def _edge_middles(vertices, edges):
    """Middles (e, 2) of edges (e, 2) as (rho, angle): the means of the radii and of the angles at the two ends."""
    (rho_a, angle_a), (rho_b, angle_b) = vertices[edges[:, 0]].T, vertices[edges[:, 1]].T
    turn = (angle_b - angle_a + np.pi) % (2 * np.pi) - np.pi
    turn[rho_a == 0] = 0.0
    start = np.where(rho_a == 0, angle_b, angle_a)
    return np.stack([0.5 * (rho_a + rho_b), start + 0.5 * turn], axis=1)
