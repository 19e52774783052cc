"""The template of a cross-section: the unit disc in rings of 6, 12, 18, ... points, triangulated.

Boundary layers split the outermost ring. The circles between have as many points as the rim, so that the wall's
triangles do not change.
"""

import dataclasses

import numpy as np

LAYER_GROWTH = 2.0  # of the layers' widths from the wall inwards


@dataclasses.dataclass
class Disc:
    """vertices (n, 2) and middles (e, 2) of the edges (e, 2), both as (rho, angle); triangles (t, 3) counter-clockwise.

    rim (6 rings,): the outermost vertices in order of angle.
    """

    rings: int
    vertices: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray
    middles: np.ndarray
    rim: np.ndarray


def make(rings, wall_layers=1):
    """Disc of `rings` rings of equal width, the outermost split into layers that grow by LAYER_GROWTH inwards."""
    vertices, first = [[0.0, 0.0]], [0]
    for k in range(1, rings + 1):
        first.append(len(vertices))
        vertices += [[k / rings, np.pi * j / (3 * k)] for j in range(6 * k)]
    triangles = []
    for k in range(1, rings + 1):
        triangles += _between(k, first)
    if wall_layers > 1:
        vertices, triangles = _layered(wall_layers, vertices, triangles, first[rings])
    vertices, triangles = np.array(vertices), np.array(triangles)
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges = np.unique(sides, axis=0)
    rim = np.arange(len(vertices) - 6 * rings, len(vertices))
    return Disc(rings, vertices, triangles, edges, _middles(vertices, edges), rim)


def _between(k, first):
    """Triangles between rings k - 1 and k, counter-clockwise."""

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


def _layered(layers, vertices, triangles, outermost):
    """(vertices, triangles) with the outermost ring's triangles in the innermost layer, two a side in the others.

    outermost: number of the outermost ring's first point; the ring moves inwards, further circles follow.
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


def _middles(vertices, edges):
    """Middles of edges in polar coordinates: between the radii and between the angles of the ends."""
    (rho_a, angle_a), (rho_b, angle_b) = vertices[edges[:, 0]].T, vertices[edges[:, 1]].T
    turn = (angle_b - angle_a + np.pi) % (2 * np.pi) - np.pi
    turn[rho_a == 0] = 0.0
    start = np.where(rho_a == 0, angle_b, angle_a)
    return np.stack([0.5 * (rho_a + rho_b), start + 0.5 * turn], axis=1)
