"""From linear to quadratic tetrahedra with the wall's middle nodes on the smooth surface, every Jacobian checked."""

import dataclasses

import numpy as np

from flow import tet10
from flow.smooth_surface import edge_middles

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


def curve(surface, points, tetrahedra):
    """QuadraticMesh from linear tetrahedra whose first vertices are the surface's.

    Wall edges of elements whose Jacobian would get too small are straightened, one layer of elements after the other
    until none is left; interior edges are straight.
    """
    sides = np.sort(tetrahedra[:, tet10.EDGES], axis=2).reshape(-1, 2)
    stride = len(points)
    keys, cell_edge = np.unique(sides[:, 0] * stride + sides[:, 1], return_inverse=True)
    cell_edge = cell_edge.reshape(-1, 6)
    ends = np.stack([keys // stride, keys % stride], axis=1)
    middles = 0.5 * (points[ends[:, 0]] + points[ends[:, 1]])
    straight = middles.copy()
    surface_edges, surface_side = surface.edges()
    place = np.searchsorted(keys, surface_edges[:, 0] * stride + surface_edges[:, 1])
    middles[place] = edge_middles(surface, surface_edges, surface_side)
    curved = np.linalg.norm(middles - straight, axis=1) > 0
    total, straightened = int(curved.sum()), 0
    while True:
        bad = _bad_elements(points, middles, tetrahedra, cell_edge, curved)
        edges = np.unique(cell_edge[bad])
        edges = edges[curved[edges]]
        if len(edges) == 0:
            break
        middles[edges], curved[edges] = straight[edges], False
        straightened += len(edges)
    # gmsh's triangle of six nodes: corners, then the middles of 01, 12, 20
    triangles = np.concatenate([surface.triangles, stride + place[surface_side]], axis=1)
    return QuadraticMesh(
        np.concatenate([points, middles]),
        np.concatenate([tetrahedra, stride + cell_edge], axis=1),
        triangles,
        surface.region,
        total,
        straightened,
    )


def _bad_elements(points, middles, tetrahedra, cell_edge, curved):
    """Curved elements in which det J may fall below SMALLEST_RATIO of its mean."""
    candidates = np.flatnonzero(curved[cell_edge].any(axis=1))
    nodes = np.concatenate([points[tetrahedra[candidates]], middles[cell_edge[candidates]]], axis=1)
    lower, upper = tet10.jacobian_bounds(nodes)
    return candidates[lower < SMALLEST_RATIO * 0.5 * (lower + upper)]


def quality(mesh):
    """Quality figures: gamma (3 inradius / circumradius) of the corner tetrahedra, scaled Jacobian of the
    curved ones."""
    corners = mesh.points[mesh.tetrahedra[:, :4]]
    gamma = _gamma(corners)
    lower, upper = tet10.jacobian_bounds(mesh.points[mesh.tetrahedra])
    return {
        "gamma_min": float(gamma.min()),
        "gamma_1_percent": float(np.percentile(gamma, 1)),
        "gamma_mean": float(gamma.mean()),
        "jacobian_ratio_min": float((lower / upper).min()),
        "jacobian_min_mm3": float(lower.min()),
        "curved_edges": mesh.curved_edges,
        "straightened_edges": mesh.straightened_edges,
    }


def _gamma(corners):
    """3 r_in / r_circ of tetrahedra (t, 4, 3); 1 for the regular one, 0 or below for a flat or inverted one."""
    a, b, c = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    six_volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    areas = sum(0.5 * np.linalg.norm(np.cross(u, v), axis=1) for u, v in ((a, b), (b, c), (c, a), (b - a, c - a)))
    inner = 0.5 * six_volume / areas
    la, lb, lc = (np.einsum("ij,ij->i", v, v)[:, None] for v in (a, b, c))
    outer = np.linalg.norm(la * np.cross(b, c) + lb * np.cross(c, a) + lc * np.cross(a, b), axis=1)
    outer = outer / np.maximum(2 * np.abs(six_volume), 1e-300)
    return 3.0 * inner / outer
