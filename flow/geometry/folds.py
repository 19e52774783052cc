"""Folds of a surface: two facets turned back on each other, a flake without thickness that no volume mesh can fill.

Seen on a lumen after radius correction: three edges with facets at a cosine of -1.00, where all others had .48 or more.
"""

import numpy as np

from flow.geometry.surface import WALL, Surface, beside
from flow.geometry.vectors import dot, unit

FOLDED = -0.9  # cosine between the normals of two facets beside each other
MOST_FLIPS = 100


def unfolded(surface):
    """The Surface with the edges of its folds flipped, those it can be; the same where it has none."""
    for _ in range(MOST_FLIPS):
        edges, side = surface.edges()
        pairs, normals = beside(side), unit(surface.area_vectors())
        cosine = dot(normals[pairs[:, 0]], normals[pairs[:, 1]])
        cosine[(surface.region[pairs] != WALL).any(axis=1)] = 1.0
        known = {tuple(edge) for edge in edges.tolist()}
        for k in np.argsort(cosine, kind="stable"):
            if cosine[k] >= FOLDED:
                return surface
            flipped = _flipped(surface, edges[k], pairs[k], known)
            if flipped is not None:
                surface = flipped
                break
        else:
            return surface
    return surface


def _flipped(surface, edge, pair, known):
    """The Surface with the edge between two facets exchanged for the other diagonal, None where that is an edge too."""
    first, second = surface.triangles[pair]
    (c,), (d,) = (np.setdiff1d(facet, edge) for facet in (first, second))
    if tuple(sorted((int(c), int(d)))) in known:
        return None
    k = int(np.flatnonzero(first == c)[0])
    a, b = first[(k + 1) % 3], first[(k + 2) % 3]
    triangles = surface.triangles.copy()
    triangles[pair] = [[a, d, c], [d, b, c]]
    return Surface(surface.points, triangles, surface.region)
