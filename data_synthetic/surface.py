"""Closed triangle surface of an implicit lumen, every wall vertex on the field's zero level, flat caps."""

import numpy as np
import vtk
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

from common.errors import ComputationError

from . import field as implicit

SMOOTHING_PASSES = 30


def to_arrays(poly):
    """(points (n, 3), triangles (m, 3)) of a vtkPolyData of triangles."""
    points = vtk_to_numpy(poly.GetPoints().GetData()).astype(float)
    return points, vtk_to_numpy(poly.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64)


def to_poly(points, triangles):
    """vtkPolyData (double precision) of points (n, 3) and triangles (m, 3)."""
    poly, vtk_points, cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    vtk_points.SetDataTypeToDouble()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(points, float), deep=True))
    offsets = np.arange(0, 3 * len(triangles) + 1, 3, dtype=np.int64)
    connectivity = np.ascontiguousarray(triangles, np.int64).ravel()
    cells.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True),
        numpy_to_vtkIdTypeArray(connectivity, deep=True),
    )
    poly.SetPoints(vtk_points)
    poly.SetPolys(cells)
    return poly


def _contour(low, values, spacing_mm):
    image = vtk.vtkImageData()
    image.SetDimensions(*values.shape)
    image.SetOrigin(*low)
    image.SetSpacing(spacing_mm, spacing_mm, spacing_mm)
    image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(order="F"), deep=True))
    edges = vtk.vtkFlyingEdges3D()
    edges.SetInputData(image)
    edges.SetValue(0, 0.0)
    edges.ComputeNormalsOff()
    edges.ComputeScalarsOff()
    edges.Update()
    return edges.GetOutput()


def _relaxed(poly):
    """Evens out the slivers of the contour; the Newton projections that follow restore the exact wall."""
    smooth = vtk.vtkWindowedSincPolyDataFilter()
    smooth.SetInputData(poly)
    smooth.SetNumberOfIterations(SMOOTHING_PASSES)
    smooth.SetPassBand(0.03)
    smooth.NormalizeCoordinatesOn()
    smooth.BoundarySmoothingOff()
    smooth.Update()
    return smooth.GetOutput()


def _drop_beyond(points, triangles, keep):
    """Triangles with all vertices kept, and the points that they use."""
    triangles = triangles[np.all(keep[triangles], axis=1)]
    used, inverse = np.unique(triangles, return_inverse=True)
    return points[used], inverse.reshape(-1, 3)


def _boundary_loops(triangles):
    """Loops of vertex indices along the open edges, in the direction opposite to the triangles'."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    twins = set(map(tuple, edges[:, ::-1]))
    follow = {b: a for a, b in map(tuple, edges) if (a, b) not in twins}
    loops = []
    while follow:
        start, loop = min(follow), []
        at = start
        while at in follow:
            loop.append(at)
            at = follow.pop(at)
        loops.append(loop)
    return loops


def build(field, spacing_mm):
    """Closed lumen surface.

    Returns (points (n, 3) mm, triangles (m, 3) outward, on_cap (n,) bool). Wall vertices lie on the field's zero level,
    rim vertices on both the wall and the cap's plane. Raises ComputationError if it is cut wrongly.
    """
    low, values = implicit.sample_grid(field, spacing_mm)
    points, triangles = to_arrays(_relaxed(_contour(low, values, spacing_mm)))
    triangles = triangles[:, ::-1]  # vtkFlyingEdges3D faces the rising field inwards; ours rises outwards
    points = field.project(points)
    ends = implicit.ends(field.branches)
    beyond = np.zeros(len(points), bool)
    for _, centre, normal, radius in ends:
        offset = points - centre
        height = offset @ normal
        # Local: a plane alone would cut neighbouring branches.
        local = np.linalg.norm(offset, axis=1) < 3.5 * radius + 1
        across = np.linalg.norm(offset - height[:, None] * normal, axis=1)
        beyond |= local & (across < 1.6 * radius) & (height > -0.25 * spacing_mm)
    points, triangles = _drop_beyond(points, triangles, ~beyond)
    points, triangles = _largest(points, triangles)
    loops = _boundary_loops(triangles)
    if len(loops) != len(ends):
        raise ComputationError(
            "the cut surface has the wrong number of openings",
            "lumen surface",
            f"{len(loops)} for {len(ends)} ends",
            "a finer generation spacing, or branches farther apart",
        )
    return _capped(field, points, triangles, loops, ends)


def _largest(points, triangles):
    """The component with most triangles (the contour may hold the far stub of an extension)."""
    i, j = triangles[:, 0], triangles[:, 1]
    k = triangles[:, 2]
    rows, columns = np.concatenate([i, j]), np.concatenate([j, k])
    graph = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(len(points),) * 2)
    _, labels = connected_components(graph, directed=False)
    largest = np.argmax(np.bincount(labels[triangles[:, 0]]))
    return _drop_beyond(points, triangles, labels == largest)


def _capped(field, points, triangles, loops, ends):
    """Joins each opening to its cap: a strip of triangles to the rim in the plane, then the flat cap."""
    on_cap = np.zeros(len(points), bool)
    for loop in loops:
        ring = np.array(loop)
        centre_of_loop = points[ring].mean(axis=0)
        _, centre, normal, radius = min(ends, key=lambda e: np.linalg.norm(e[1] - centre_of_loop))
        # The saw-tooth edge gets a rim of its own, as many vertices, on the wall and in the plane.
        rim_points = points[ring].copy()
        for _ in range(6):
            rim_points -= ((rim_points - centre) @ normal)[:, None] * normal
            rim_points = field.project(rim_points, 1)
        rim_points -= ((rim_points - centre) @ normal)[:, None] * normal
        rim_points = _even(rim_points, centre, normal, radius)
        for _ in range(6):
            rim_points = field.project(rim_points, 1)
            rim_points -= ((rim_points - centre) @ normal)[:, None] * normal
        rim = np.arange(len(points), len(points) + len(ring))
        inner, cap = _disc(rim_points, centre, normal, radius)
        numbering = np.concatenate([rim, len(points) + len(ring) + np.arange(len(inner))])
        points = np.concatenate([points, rim_points, inner])
        on_cap = np.concatenate([on_cap, np.full(len(numbering), True)])
        triangles = np.concatenate([triangles, _strip(ring, rim), numbering[cap]])
    return points, triangles, on_cap


def _even(rim_points, centre, normal, radius):
    """Rim vertices at angles half way between their own and even spacing, in the order of the loop."""
    u = rim_points[0] - centre
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    angle = np.unwrap(np.arctan2((rim_points - centre) @ v, (rim_points - centre) @ u))
    turn = np.sign(angle[-1] - angle[0]) * 2 * np.pi
    even = angle.mean() + turn * (np.arange(len(angle)) / len(angle) - 0.5 * (len(angle) - 1) / len(angle))
    even = 0.9 * even + 0.1 * angle
    return centre + radius * (np.cos(even)[:, None] * u + np.sin(even)[:, None] * v)


def _strip(outer, inner):
    """Two triangles a pair of neighbours between two rings of equal length."""
    o, i = outer, inner
    o2, i2 = np.roll(o, -1), np.roll(i, -1)
    return np.concatenate([np.stack([o, o2, i], axis=1), np.stack([o2, i2, i], axis=1)])


def _disc(rim_points, centre, normal, radius):
    """Flat cap: (inner points (k, 3), triangles that number the rim first, facing along the outward normal)."""
    u = rim_points[0] - centre
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    edge = 2 * np.pi * radius / len(rim_points)
    count = int(radius / edge) + 2
    i, j = np.meshgrid(np.arange(-count, count + 1), np.arange(-2 * count, 2 * count + 1))
    lattice = edge * np.stack([i + 0.5 * (j % 2), j * np.sqrt(0.75)], axis=-1).reshape(-1, 2)
    lattice = lattice[np.linalg.norm(lattice, axis=1) < radius - 0.6 * edge]
    flat = np.concatenate([np.stack([(rim_points - centre) @ u, (rim_points - centre) @ v], axis=1), lattice])
    triangles = Delaunay(flat).simplices
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    # Rim vertices in one line give the hull flat triangles that are none.
    triangles = triangles[np.abs(area) > 1e-6 * edge * edge]
    return centre + lattice[:, :1] * u + lattice[:, 1:] * v, triangles
