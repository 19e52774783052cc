"""Curves linear tetrahedra to quadratic ones, with the wall's edge middles on the smooth surface.

The Jacobian of every curved element is checked.
"""

import dataclasses

import numpy as np

from flow.geometry import tet10

SMALLEST_RATIO = 0.15  # an element stays curved if its least det J is at least this share of its middle value


@dataclasses.dataclass
class QuadraticMesh:
    """A mesh of quadratic tetrahedra.

    points (n, 3) in mm; tetrahedra (t, 10), ordered as in geometry.tet10; triangles (f, 6) of wall and caps, with
    region ids region (f,); curved_edges: number of edges whose middle point was curved at first; straightened_edges:
    how many of them were straightened again.
    """

    points: np.ndarray
    tetrahedra: np.ndarray
    triangles: np.ndarray
    region: np.ndarray
    curved_edges: int
    straightened_edges: int


def curve(boundary, region, points, tetrahedra, edges, middles_of_edges):
    """QuadraticMesh from points (n, 3) in mm and linear tetrahedra (t, 4).

    middles_of_edges (e, 3) in mm: given middle points of the edges (e, 2); all other edges are straight. boundary
    (f, 3), region (f,): the triangles of wall and caps. Where the Jacobian of an element would get too small, the
    element's edges are straightened. This may spoil a neighbour, so the check is repeated until no such element is
    left.
    """
    stride = len(points)
    keys, cell_edge = np.unique(_edge_keys(tetrahedra[:, tet10.EDGES].reshape(-1, 2), stride), return_inverse=True)
    cell_edge = cell_edge.reshape(-1, 6)
    straight = 0.5 * (points[keys // stride] + points[keys % stride])
    middles = straight.copy()
    middles[np.searchsorted(keys, _edge_keys(edges, stride))] = middles_of_edges
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
    place = np.searchsorted(keys, _edge_keys(sides, stride)).reshape(-1, 3)
    return QuadraticMesh(
        np.concatenate([points, middles]),
        np.concatenate([tetrahedra, stride + cell_edge], axis=1),
        np.concatenate([boundary, stride + place], axis=1),
        region,
        total,
        straightened,
    )


def _edge_keys(edges, stride):
    """One number for each undirected edge (e, 2), the same for both directions; stride: number of points."""
    return edges.min(axis=1) * stride + edges.max(axis=1)


def _bad_elements(points, middles, tetrahedra, cell_edge, curved):
    """Numbers of the curved elements in which det J may fall below SMALLEST_RATIO of its middle value.

    The middle value is the mean of the two bounds of det J (tet10.jacobian_bounds). middles (k, 3) of all edges;
    cell_edge (t, 6): the elements' edges; curved (k,) bool: whether an edge is curved.
    """
    candidates = np.flatnonzero(curved[cell_edge].any(axis=1))
    nodes = np.concatenate([points[tetrahedra[candidates]], middles[cell_edge[candidates]]], axis=1)
    lower, upper = tet10.jacobian_bounds(nodes)
    return candidates[lower < SMALLEST_RATIO * 0.5 * (lower + upper)]


def quality(mesh, swept):
    """{name: figure} of a QuadraticMesh: gamma (see `gamma`), least over largest Jacobian in a cell, numbers of edges.

    swept (t,) bool: which cells are swept. They are stretched, so only their Jacobian counts. gamma is computed from
    the corners of the other cells, and is None if there are none.
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
    """3 inradius / circumradius (t,) of tetrahedra with corners (t, 4, 3): 1 for a regular one, 0 for a flat one, below
    0 for an inverted one."""
    a, b, c = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    six_volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    areas = sum(0.5 * np.linalg.norm(np.cross(u, v), axis=1) for u, v in ((a, b), (b, c), (c, a), (b - a, c - a)))
    inner = 0.5 * six_volume / areas
    la, lb, lc = (np.einsum("ij,ij->i", v, v)[:, None] for v in (a, b, c))
    outer = np.linalg.norm(la * np.cross(b, c) + lb * np.cross(c, a) + lc * np.cross(a, b), axis=1)
    outer = outer / np.maximum(2 * np.abs(six_volume), 1e-300)
    return 3.0 * inner / outer
