"""Closed triangle surface of an implicit lumen: flat caps, and a wall with every vertex on the field's zero level."""

import numpy as np
import vtk
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay
from vtk.util.numpy_support import numpy_to_vtk

from common import vtp
from common.errors import ComputationError

from . import cut
from . import field as implicit

SMOOTHING_PASSES = 30


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


def _smoothed(poly):
    """A smoothed contour, without its thin triangles. `build` then projects the vertices back onto the exact wall."""
    smooth = vtk.vtkWindowedSincPolyDataFilter()
    smooth.SetInputData(poly)
    smooth.SetNumberOfIterations(SMOOTHING_PASSES)
    smooth.SetPassBand(0.03)
    smooth.NormalizeCoordinatesOn()
    smooth.BoundarySmoothingOff()
    smooth.Update()
    return smooth.GetOutput()


def _keep_vertices(points, triangles, keep):
    """The triangles whose vertices are all kept, and the points that they use."""
    triangles = triangles[np.all(keep[triangles], axis=1)]
    used, inverse = np.unique(triangles, return_inverse=True)
    return points[used], inverse.reshape(-1, 3)


def _boundary_loops(triangles):
    """Loops of vertex indices along the open edges, in the opposite direction to the edges' triangles."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    twins = set(map(tuple, edges[:, ::-1]))
    previous = {b: a for a, b in map(tuple, edges) if (a, b) not in twins}
    loops = []
    while previous:
        start, loop = min(previous), []
        at = start
        while at in previous:
            loop.append(at)
            at = previous.pop(at)
        loops.append(loop)
    return loops


def build(field, spacing_mm):
    """Closed lumen surface of a LumenField, first found on a grid of spacing_mm.

    Returns (points (n, 3) mm, triangles (m, 3) outward, on_cap (n,) bool). Wall vertices lie on the field's zero level,
    rim vertices on both the wall and the cap's plane. Raises ComputationError if the cut at an end fails.
    """
    low, values = implicit.sample_grid(field, spacing_mm)
    poly = _smoothed(_contour(low, values, spacing_mm))
    points, triangles = (
        vtp.points(poly),
        vtp.triangles(poly)[:, ::-1],
    )  # vtkFlyingEdges3D orients triangles towards lower values, here inwards
    points = field.project(points)
    ends = implicit.open_ends(field.branches)
    for _, centre, normal, radius in ends:
        points, triangles = cut.cut_at_end(field, points, triangles, centre, normal, radius)
    points, triangles = _largest_component(points, triangles)
    loops = _boundary_loops(triangles)
    if len(loops) != len(ends):
        raise ComputationError(
            "the cut surface has the wrong number of openings",
            "lumen surface",
            f"{len(loops)} for {len(ends)} ends",
            "a finer generation spacing, or branches farther apart",
        )
    return _add_caps(points, triangles, loops, ends)


def _largest_component(points, triangles):
    """The connected part with most triangles. Other parts may be pieces of the field's extensions beyond its ends."""
    i, j = triangles[:, 0], triangles[:, 1]
    k = triangles[:, 2]
    rows, columns = np.concatenate([i, j]), np.concatenate([j, k])
    graph = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(len(points),) * 2)
    _, labels = connected_components(graph, directed=False)
    largest = np.argmax(np.bincount(labels[triangles[:, 0]]))
    return _keep_vertices(points, triangles, labels == largest)


def _add_caps(points, triangles, loops, ends):
    """Closes each opening, a ring of vertices in the plane of its end, with a flat disc."""
    on_cap = np.zeros(len(points), bool)
    for loop in loops:
        rim = np.array(loop)
        middle = points[rim].mean(axis=0)
        _, centre, normal, _ = min(ends, key=lambda e: np.linalg.norm(e[1] - middle))
        _check_rim(points[rim], centre, normal)
        inner, cap = _cap_disc(points[rim], centre, normal)
        numbering = np.concatenate([rim, len(points) + np.arange(len(inner))])
        points = np.concatenate([points, inner])
        on_cap[rim] = True
        on_cap = np.concatenate([on_cap, np.full(len(inner), True)])
        triangles = np.concatenate([triangles, numbering[cap]])
    return points, triangles, on_cap


def _check_rim(rim_points, centre, normal):
    """Raises ComputationError unless the closed rim goes round the centre once without turning back."""
    spoke, following = rim_points - centre, np.roll(rim_points, -1, axis=0) - centre
    turn = np.arctan2(np.cross(spoke, following) @ normal, np.sum(spoke * following, axis=1))
    if abs(abs(turn.sum()) - 2 * np.pi) > 1e-6 or np.any(turn * turn.sum() <= 0):
        place = np.round(centre, 2).tolist()
        raise ComputationError("the edge of an end turns back", "lumen surface", f"near {place} mm", "a finer spacing")


def _cap_disc(rim_points, centre, normal):
    """Flat cap: (inner points (k, 3) mm, triangles facing along the outward normal).

    The triangles number the rim's points first, then the inner points. Every point of the rim must be in sight from the
    centre. The rim's points are moved to a unit circle, each at its angle, and triangulated there. Otherwise a hollow
    in the rim would be filled up to the rim's convex hull.
    """
    u = rim_points[0] - centre
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    x, y = (rim_points - centre) @ u, (rim_points - centre) @ v
    angle, reach = np.arctan2(y, x), np.hypot(x, y)
    count = int(len(rim_points) / (2 * np.pi)) + 2
    edge = 2 * np.pi / len(rim_points)
    i, j = np.meshgrid(np.arange(-count, count + 1), np.arange(-2 * count, 2 * count + 1))
    lattice = edge * np.stack([i + 0.5 * (j % 2), j * np.sqrt(0.75)], axis=-1).reshape(-1, 2)
    lattice = lattice[np.linalg.norm(lattice, axis=1) < 1 - 0.6 * edge]
    flat = np.concatenate([np.stack([np.cos(angle), np.sin(angle)], axis=1), lattice])
    triangles = Delaunay(flat).simplices
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    order = np.argsort(angle)
    scale = np.interp(np.arctan2(lattice[:, 1], lattice[:, 0]), angle[order], reach[order], period=2 * np.pi)
    inner = lattice * scale[:, None]
    return centre + inner[:, :1] * u + inner[:, 1:] * v, triangles
