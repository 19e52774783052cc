"""From linear to quadratic tetrahedra with the wall's middle nodes on the smooth surface, every Jacobian checked."""

import dataclasses

import numpy as np

from flow.geometry import tet10

SMALLEST_RATIO = 0.15  # least det J over the mean det J of an element that stays curved


@dataclasses.dataclass
class QuadraticMesh:
    """points (n, 3) mm, tetrahedra (t, 10), triangles (f, 6), region (f,), number of edges straightened."""

    points: np.ndarray
    tetrahedra: np.ndarray
    triangles: np.ndarray
    region: np.ndarray
    curved_edges: int
    straightened_edges: int


def curve(boundary, region, points, tetrahedra, edges, middles_of_edges):
    """QuadraticMesh from linear tetrahedra, the middle points (e, 3) of some of its edges (e, 2) given.

    boundary (f, 3), region (f,): the triangles of wall and caps. Given middles of elements whose Jacobian would get too
    small are straightened, one layer of elements after the other until none is left; all other edges are straight.
    """
    stride = len(points)
    keys, cell_edge = np.unique(_keys(tetrahedra[:, tet10.EDGES].reshape(-1, 2), stride), return_inverse=True)
    cell_edge = cell_edge.reshape(-1, 6)
    straight = 0.5 * (points[keys // stride] + points[keys % stride])
    middles = straight.copy()
    middles[np.searchsorted(keys, _keys(edges, stride))] = middles_of_edges
    curved = np.linalg.norm(middles - straight, axis=1) > 0
    total, straightened = int(curved.sum()), 0
    while True:
        bad = _bad_elements(points, middles, tetrahedra, cell_edge, curved)
        chosen = np.unique(cell_edge[bad])
        chosen = chosen[curved[chosen]]
        if len(chosen) == 0:
            break
        middles[chosen], curved[chosen] = straight[chosen], False
        straightened += len(chosen)
    # gmsh's triangle of six nodes: corners, then the middles of 01, 12, 20
    sides = boundary[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    place = np.searchsorted(keys, _keys(sides, stride)).reshape(-1, 3)
    return QuadraticMesh(
        np.concatenate([points, middles]),
        np.concatenate([tetrahedra, stride + cell_edge], axis=1),
        np.concatenate([boundary, stride + place], axis=1),
        region,
        total,
        straightened,
    )


def _keys(edges, stride):
    """One number for each undirected edge (e, 2)."""
    return edges.min(axis=1) * stride + edges.max(axis=1)


def _bad_elements(points, middles, tetrahedra, cell_edge, curved):
    """Curved elements in which det J may fall below SMALLEST_RATIO of its mean."""
    candidates = np.flatnonzero(curved[cell_edge].any(axis=1))
    nodes = np.concatenate([points[tetrahedra[candidates]], middles[cell_edge[candidates]]], axis=1)
    lower, upper = tet10.jacobian_bounds(nodes)
    return candidates[lower < SMALLEST_RATIO * 0.5 * (lower + upper)]


def quality(mesh, swept):
    """Quality figures: gamma (3 inradius / circumradius) of the corner tetrahedra, scaled Jacobian of the curved ones.

    gamma is that of cells that are not swept (swept (t,) bool), None where all are: stretched cells are judged by the
    Jacobian alone.
    """
    corners = mesh.points[mesh.tetrahedra[~swept, :4]]
    found = gamma(corners) if len(corners) else None
    lower, upper = tet10.jacobian_bounds(mesh.points[mesh.tetrahedra])
    ratio = lower / upper
    return {
        "gamma_min": float(found.min()) if len(corners) else None,
        "gamma_1_percent": float(np.percentile(found, 1)) if len(corners) else None,
        "gamma_mean": float(found.mean()) if len(corners) else None,
        "jacobian_ratio_min": float(ratio.min()),
        "jacobian_ratio_min_swept": float(ratio[swept].min()) if swept.any() else None,
        "jacobian_min_mm3": float(lower.min()),
        "curved_edges": mesh.curved_edges,
        "straightened_edges": mesh.straightened_edges,
    }


def gamma(corners):
    """3 r_in / r_circ of tetrahedra (t, 4, 3); 1 for the regular one, 0 or below for a flat or inverted one."""
    a, b, c = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    six_volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    areas = sum(0.5 * np.linalg.norm(np.cross(u, v), axis=1) for u, v in ((a, b), (b, c), (c, a), (b - a, c - a)))
    inner = 0.5 * six_volume / areas
    la, lb, lc = (np.einsum("ij,ij->i", v, v)[:, None] for v in (a, b, c))
    outer = np.linalg.norm(la * np.cross(b, c) + lb * np.cross(c, a) + lc * np.cross(a, b), axis=1)
    outer = outer / np.maximum(2 * np.abs(six_volume), 1e-300)
    return 3.0 * inner / outer
