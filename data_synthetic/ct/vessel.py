"""The vessel to be scanned: a lumen surface with extended ends, and plaque and wall behind each point of it."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from common.errors import InputError


# The vessel is extended this far beyond the ends of the surface. No blur reaches so far, so the image shows no end.
EXTENSION_MM = 4.0
COPLANAR_COSINE = np.cos(np.radians(1.0))  # neighbouring triangles of a flat end differ by at most 1 degree


@dataclass
class Vessel:
    """A vessel to be scanned.

    pieces: closed surfaces (points (n, 3) mm, triangles (m, 3)). The first piece is the lumen; one prism for each end
    follows. tissue_points_mm (k, 3): points on the walls of all pieces. plaque_mm (k,), plaque_type (k,): thickness and
    type (common.patient.plaque_types) of the plaque behind each of these points.
    """

    pieces: list
    tissue_points_mm: np.ndarray
    plaque_mm: np.ndarray
    plaque_type: np.ndarray
    lumen_wall_indices: np.ndarray  # indices of the lumen's wall points; tissue_points_mm begins with these points


def from_surface(poly, where):
    """Vessel of a closed lumen (vtkPolyData of triangles). Raises InputError if it is open or has no flat ends."""
    points, triangles = vtp.points_and_triangles(poly)
    if not np.isfinite(points).all():
        raise InputError("a point of the surface is not finite", where, "nan or infinite", "export it again")
    _check_closed(triangles, where)
    a, b, c = points[triangles].transpose(1, 0, 2) - points.mean(axis=0)
    if np.sum(a * np.cross(b, c)) < 0:
        triangles = triangles[:, ::-1]  # the surface is inside out; its ends would be extended inwards
    cap_of = _cap_numbers(poly, points, triangles)
    if cap_of.max() < 1:
        raise InputError(
            "the surface has fewer than two flat ends", where, cap_of.max() + 1, "give a capped lumen, in mm"
        )
    thickness, kind = _plaque_behind_points(poly, points, triangles)
    wall = np.unique(triangles[cap_of < 0])
    pieces, places, plaques, kinds = [(points, triangles)], [points[wall]], [thickness[wall]], [kind[wall]]
    for number in range(cap_of.max() + 1):
        prism, rim, normal = _extend_cap(points, triangles[cap_of == number])
        pieces.append(prism)
        for height in np.arange(0.25, EXTENSION_MM + 2.0, 0.25):
            places.append(points[rim] + height * normal)
            plaques.append(thickness[rim])
            kinds.append(kind[rim])
    return Vessel(pieces, np.concatenate(places), np.concatenate(plaques), np.concatenate(kinds), wall)


def _check_closed(triangles, where):
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    if np.any(count != 2):
        value = f"{np.sum(count != 2)} loose edges"
        raise InputError("the lumen surface is not closed", where, value, "close it first")


def _area_vectors(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)


def _cap_numbers(poly, points, triangles):
    """Number (m,) of the flat end to which each triangle belongs, -1 on the wall.

    The numbers come from the array `region_id` if the surface has it. Otherwise flat discs are taken for ends.
    """
    region = poly.GetCellData().GetArray("region_id")
    if region is not None:
        return vtk_to_numpy(region).astype(int) - 1
    vectors = _area_vectors(points, triangles)
    area = np.linalg.norm(vectors, axis=1)
    normals = vectors / np.maximum(area, 1e-30)[:, None]
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    order = np.lexsort(edges.T)
    owner = np.tile(np.arange(len(triangles)), 3)[order]
    i, j = owner[::2], owner[1::2]
    flat = np.sum(normals[i] * normals[j], axis=1) > COPLANAR_COSINE
    graph = coo_matrix((np.ones(flat.sum()), (i[flat], j[flat])), shape=(len(triangles),) * 2)
    _, label = connected_components(graph, directed=False)
    total = np.stack([np.bincount(label, vectors[:, k]) for k in range(3)], axis=1)
    size = np.linalg.norm(total, axis=1)
    result, number = np.full(len(triangles), -1), 0
    for patch in np.argsort(-size, kind="stable"):
        inside = label == patch
        if size[patch] < 0.2:
            break
        if size[patch] < 0.999 * area[inside].sum():
            continue  # bent: part of the wall
        rim = points[np.unique(triangles[inside])]
        reach = np.linalg.norm(rim - rim.mean(axis=0), axis=1).max()
        if size[patch] > 0.5 * np.pi * reach**2:  # a disc rather than a strip of a straight wall
            result[inside] = number
            number += 1
    return result


def _plaque_behind_points(poly, points, triangles):
    """(thickness in mm (n,), type (n,)) of the plaque behind each point of a lumen.

    If the lumen was widened by a procedure, the plaque is thinner than before, since its area in a section is kept:
    (R + t)^2 - R^2 is the same before and after, where R is the lumen's radius and t the thickness.
    """
    data = poly.GetPointData()
    if data.GetArray("plaque_thickness_mm") is None or data.GetArray("plaque_type") is None:
        return np.zeros(len(points)), np.zeros(len(points), int)
    thickness = vtk_to_numpy(data.GetArray("plaque_thickness_mm")).astype(float)
    kind = vtk_to_numpy(data.GetArray("plaque_type")).astype(int)
    if data.GetArray("displacement_mm") is not None and data.GetArray("radius_mm") is not None:
        vectors = _area_vectors(points, triangles)
        normal = np.zeros_like(points)
        for k in range(3):
            np.add.at(normal, triangles[:, k], vectors)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None]
        growth = np.sum(vtk_to_numpy(data.GetArray("displacement_mm")) * normal, axis=1)
        before = vtk_to_numpy(data.GetArray("radius_mm")).astype(float)
        after = np.maximum(before + growth, 0.05)
        thickness = np.sqrt(after**2 + (before + thickness) ** 2 - before**2) - after
    return thickness, kind


def _extend_cap(points, cap):
    """(prism, indices of the cap's rim, normal (3,)); the prism extends a cap along its normal.

    prism: (points, triangles) of a closed surface.
    """
    normal = _area_vectors(points, cap).sum(axis=0)
    normal /= np.linalg.norm(normal)
    used, local = np.unique(cap, return_inverse=True)
    local, n = local.reshape(-1, 3), len(used)
    edges = np.concatenate([local[:, [0, 1]], local[:, [1, 2]], local[:, [2, 0]]])
    codes, twins = edges[:, 0] * n + edges[:, 1], edges[:, 1] * n + edges[:, 0]
    rim = edges[~np.isin(codes, twins)]
    a, b = rim[:, 0], rim[:, 1]
    sides = np.concatenate([np.stack([a, b, b + n], axis=1), np.stack([a, b + n, a + n], axis=1)])
    triangles = np.concatenate([local[:, ::-1], local + n, sides])
    start = points[used] - 1e-3 * normal
    return (np.concatenate([start, points[used] + EXTENSION_MM * normal]), triangles), used[np.unique(a)], normal
