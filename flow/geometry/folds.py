"""Removes folds of a surface: two facets turned back on each other enclose no volume that a mesh could fill.

One lumen after radius correction had three edges where the normals of the two facets had a cosine of -1.00. At all its
other edges the cosine was .48 or more.
"""

import numpy as np

from flow.geometry.surface import WALL, Surface, facets_at_edges
from flow.geometry.vectors import dot, unit

FOLD_COSINE = -0.9  # an edge is a fold if the normals of its two facets have a smaller cosine
MOST_FLIPS = 100  # most edges that are flipped


def unfold(surface):
    """The Surface with the edges at its folds flipped where that is possible; unchanged if it has no folds.

    Flipping an edge replaces it by the other diagonal of its two facets.
    """
    for _ in range(MOST_FLIPS):
        edges, side = surface.edges()
        pairs, normals = facets_at_edges(side), unit(surface.area_vectors())
        cosine = dot(normals[pairs[:, 0]], normals[pairs[:, 1]])
        cosine[(surface.region[pairs] != WALL).any(axis=1)] = 1.0
        known = {tuple(edge) for edge in edges.tolist()}
        for k in np.argsort(cosine, kind="stable"):
            if cosine[k] >= FOLD_COSINE:
                return surface
            flipped = _flip_edge(surface, edges[k], pairs[k], known)
            if flipped is not None:
                surface = flipped
                break
        else:
            return surface
    return surface


def _flip_edge(surface, edge, pair, known):
    """The Surface with `edge` (2,) between the facets `pair` (2,) flipped; None if the other diagonal is an edge too.

    known: all edges, as tuples of ascending vertices.
    """
    first, second = surface.triangles[pair]
    (c,), (d,) = (np.setdiff1d(facet, edge) for facet in (first, second))
    if tuple(sorted((int(c), int(d)))) in known:
        return None
    k = int(np.flatnonzero(first == c)[0])
    a, b = first[(k + 1) % 3], first[(k + 2) % 3]
    triangles = surface.triangles.copy()
    triangles[pair] = [[a, d, c], [d, b, c]]
    return Surface(surface.points, triangles, surface.region)
