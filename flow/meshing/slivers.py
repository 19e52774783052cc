"""Removes slivers: flat tetrahedra that gmsh's optimiser leaves, as all their corners lie on the wall and are fixed.

An edge of the sliver that runs through the lumen is split. The new point is the edge's middle, moved towards the other
corners of the cells around the edge. Splitting ends when no sliver is left, when no split gives cells better than the
sliver, or after MOST_SPLITS splits.
"""

import numpy as np

from flow.geometry import tet10
from flow.geometry.curving import gamma

# The new point is tried at these shares of the way from the edge's middle to other corners.
TRIED_SHARES = (0.05, 0.1, 0.2, 0.35, 0.5, 0.7)
MOST_SPLITS = 100


def split_slivers(points, tetrahedra, edges, least_gamma):
    """(points, tetrahedra) in which gamma (geometry.curving) of each cell is at least `least_gamma`, if possible.

    points (n, 3): new ones are appended; tetrahedra (t, 4) of positive volume; edges (e, 2) of the surface, which are
    not split.
    """
    fixed = {tuple(edge) for edge in np.sort(edges, axis=1).tolist()}
    for _ in range(MOST_SPLITS):
        found = gamma(points[tetrahedra])
        worst = int(np.argmin(found))
        if found[worst] >= least_gamma:
            break
        inner = np.sort(tetrahedra[worst][tet10.EDGES], axis=1)
        tried = [_best_split(points, tetrahedra, edge) for edge in inner if tuple(edge.tolist()) not in fixed]
        best = max(tried, key=lambda one: one[0], default=(0.0,))
        if best[0] <= found[worst]:
            break
        _, point, around, new = best
        points = np.concatenate([points, point[None]])
        tetrahedra = np.concatenate([np.delete(tetrahedra, around, axis=0), new])
    return points, tetrahedra


def _best_split(points, tetrahedra, edge):
    """The best split of `edge` (2,): (least gamma of the new cells, new point (3,), numbers of the cells around the
    edge, new cells (k, 4))."""
    around = np.flatnonzero((tetrahedra == edge[0]).any(axis=1) & (tetrahedra == edge[1]).any(axis=1))
    cells = tetrahedra[around]
    new = np.concatenate([np.where(cells == end, len(points), cells) for end in edge])
    middle, others = points[edge].mean(axis=0), points[np.setdiff1d(cells, edge)]
    tried = []
    for share in TRIED_SHARES:
        for towards in (others.mean(axis=0), *others):
            point = (1 - share) * middle + share * towards
            tried.append((float(gamma(np.concatenate([points, point[None]])[new]).min()), point, around, new))
    return max(tried, key=lambda one: one[0])
