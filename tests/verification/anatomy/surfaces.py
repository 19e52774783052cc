"""Lumen surfaces whose axis and radius are known, and defects made in them on purpose."""

import numpy as np
import vtk
from scipy.interpolate import CubicSpline
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy


def polydata(points, triangles):
    """vtkPolyData of points (n, 3) in double precision and triangles (m, 3)."""
    data = vtk.vtkPolyData()
    vertices = vtk.vtkPoints()
    vertices.SetDataTypeToDouble()
    vertices.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    cells = vtk.vtkCellArray()
    for triangle in triangles:
        cells.InsertNextCell(3, [int(i) for i in triangle])
    data.SetPoints(vertices)
    data.SetPolys(cells)
    return data


def arrays(data):
    """(points, triangles) of a vtkPolyData of triangles."""
    triangles = vtk_to_numpy(data.GetPolys().GetData()).reshape(-1, 4)[:, 1:]
    return vtk_to_numpy(data.GetPoints().GetData()).astype(float), triangles.copy()


def write(path, points, triangles):
    """Writes binary STL, VTP, PLY or OBJ by the suffix."""
    writers = {
        ".stl": vtk.vtkSTLWriter,
        ".vtp": vtk.vtkXMLPolyDataWriter,
        ".ply": vtk.vtkPLYWriter,
        ".obj": vtk.vtkOBJWriter,
    }
    writer = writers[path.suffix]()
    writer.SetFileName(str(path))
    writer.SetInputData(polydata(points, triangles))
    if path.suffix == ".stl":
        writer.SetFileTypeToBinary()
    assert writer.Write()
    return path


def read(path):
    """vtkPolyData of a VTP file."""
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def write_moved(path, data, points):
    """Writes a vtkPolyData with all its arrays to VTP, its points moved to these (n, 3)."""
    data.GetPoints().SetData(numpy_to_vtk(points, deep=True))
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    assert writer.Write()
    return path


def distances(points, data):
    """Distance (mm) of each of the points (n, 3) to the triangles of a vtkPolyData."""
    locator = vtk.vtkStaticCellLocator()
    locator.SetDataSet(data)
    locator.BuildLocator()
    nearest, cell, sub, d2 = [0.0] * 3, vtk.reference(0), vtk.reference(0), vtk.reference(0.0)
    found = []
    for p in points:
        locator.FindClosestPoint(p, nearest, cell, sub, d2)
        found.append(float(d2) ** 0.5)
    return np.array(found)


def onto_cones(points, segments):
    """The points (n, 3) of a tree moved across its axes on the nearest of the cones (start, end, r0, r1).

    On a grid of spacing h the distance is interpolated linearly. So points lie up to h^2 / 8R inside the cones.
    """
    least, moved = np.full(len(points), np.inf), points.copy()
    for a, b, r0, r1 in segments:
        a, b = np.asarray(a, float), np.asarray(b, float)
        length = np.linalg.norm(b - a)
        t = (b - a) / length
        along = (points - a) @ t
        across = points - a - along[:, None] * t
        distance = np.linalg.norm(across, axis=1)
        off = distance - r0 - (r1 - r0) * np.clip(along / length, 0, 1)
        nearer = (off < least) & (along > -1e-6)
        least[nearer] = off[nearer]
        moved[nearer] = (points - (off / distance)[:, None] * across)[nearer]
    return moved


def straight(s):
    """A straight axis along x."""
    return np.column_stack([s, 0 * s, 0 * s])


def arc(curvature):
    """A circular axis in the plane z = 0."""
    return lambda s: np.column_stack([np.sin(curvature * s), 1 - np.cos(curvature * s), 0 * s]) / [
        curvature,
        curvature,
        1,
    ]


def helix(radius, pitch_per_rad):
    """A helical axis by arc length: curvature r / (r^2 + c^2), torsion c / (r^2 + c^2)."""

    def axis(s):
        angle = s / np.hypot(radius, pitch_per_rad)
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), pitch_per_rad * angle])

    return axis


def by_arc_length(curve, stop, samples=20001):
    """(axis of arc length s, length) of a curve p(t), t in [0, stop], by cumulative chords."""
    x = curve(np.linspace(0, stop, samples))
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])
    spline = CubicSpline(s, x)
    return lambda at: spline(at), s[-1]


def hairpin(leg, gap, radius):
    """(axis, length) of two straight legs (mm) joined by a half circle, `gap` mm between their walls."""
    bend = radius + gap / 2

    def axis(s):
        angle = np.clip((s - leg) / bend, 0, np.pi)
        back = np.maximum(s - leg - np.pi * bend, 0)
        return np.column_stack([np.minimum(s, leg) + bend * np.sin(angle) - back, bend * (1 - np.cos(angle)), 0 * s])

    return axis, 2 * leg + np.pi * bend


def tube(axis, radius, length, edge=0.4, noise=0.0, seed=1, capped=True):
    """Swept tube (points, triangles), outward; `radius` is a function of arc length, `noise` radial (mm)."""
    rings = round(length / edge) + 1
    around = round(2 * np.pi * float(np.max(radius(np.linspace(0, length, 50)))) / edge)
    s = np.linspace(0, length, rings)
    x = axis(s)
    tangent = (axis(s + 1e-5) - axis(s - 1e-5)) / 2e-5
    u = np.zeros_like(x)
    u[0] = np.cross(tangent[0], [0.0, 0.0, 1.0])
    for i in range(1, rings):  # carried along without turning
        u[i] = u[i - 1] - tangent[i] * (u[i - 1] @ tangent[i])
    u /= np.linalg.norm(u, axis=1)[:, None]
    v = np.cross(tangent, u)
    angle = 2 * np.pi * (np.arange(around)[None, :] + 0.5 * (np.arange(rings)[:, None] % 2)) / around
    r = np.broadcast_to(radius(s)[:, None], angle.shape)
    r = r + noise * np.random.default_rng(seed).standard_normal(angle.shape)
    ring = np.cos(angle)[..., None] * u[:, None] + np.sin(angle)[..., None] * v[:, None]
    points = (x[:, None] + r[..., None] * ring).reshape(-1, 3)
    triangles = []
    for i in range(rings - 1):
        k = np.arange(around)
        shift = i % 2
        a, b = i * around + k, i * around + (k + 1) % around
        c, d = (i + 1) * around + (k + shift) % around, (i + 1) * around + (k + shift + 1) % around
        triangles += [np.column_stack([a, b, c]), np.column_stack([c, b, d])]
    if capped:
        points = np.vstack([points, x[[0, -1]]])
        k = np.arange(around)
        first, last = len(points) - 2, len(points) - 1
        triangles.append(np.column_stack([np.full(around, first), (k + 1) % around, k]))
        k = k + (rings - 1) * around
        triangles.append(np.column_stack([np.full(around, last), k, (rings - 1) * around + (k + 1) % around]))
    return points, np.vstack(triangles)


def sawtooth(points, triangles, ends, depth, seed=1, reach=2.5):
    """Ends (centre, outward normal, radius) opened by deleting the triangles whose middle lies beyond the end's plane.

    The plane varies by `depth` (mm) from triangle to triangle, and holds within `reach` radii of the end.
    """
    middle = points[triangles].mean(axis=1)
    keep = np.ones(len(triangles), dtype=bool)
    varied = depth * np.random.default_rng(seed).random(len(triangles))
    for centre, normal, radius in ends:
        near = np.linalg.norm(middle - centre, axis=1) < reach * radius
        keep &= ~(near & ((middle - centre) @ normal > -varied))
    return points, triangles[keep]


def tree_field(segments, spacing=0.2, rounded=False):
    """(low corner, field) of the distance (mm) to straight cones (start, end, r0, r1), negative inside, on a grid.

    Each cone runs on past its end by half its radius (`rounded`: ends in a half ball there); the first one at its
    start, too.
    """
    starts, ends = (np.array([s[k] for s in segments], dtype=float) for k in (0, 1))
    margin = max(4, 1.6 * max(max(s[2:]) for s in segments))
    low = np.minimum(starts, ends).min(axis=0) - margin
    counts = np.ceil((np.maximum(starts, ends).max(axis=0) + margin - low) / spacing).astype(int) + 1
    grid = np.stack(np.meshgrid(*[low[k] + spacing * np.arange(counts[k]) for k in range(3)], indexing="ij"), axis=-1)
    field = np.full(counts, np.inf)
    for number, (a, b, r0, r1) in enumerate(segments):
        a, b = np.asarray(a, float), np.asarray(b, float)
        length = np.linalg.norm(b - a)
        t = (b - a) / length
        along = (grid - a) @ t
        radius = r0 + (r1 - r0) * np.clip(along / length, 0, 1)
        beyond = 0 if rounded else 0.5
        inside = np.clip(along, 0 if number else -beyond * r0, length + beyond * r1)
        field = np.minimum(field, np.linalg.norm(grid - a - inside[..., None] * t, axis=-1) - radius)
    return low, field


def level_surface(low, field, spacing):
    """vtkFlyingEdges3D of the field's zero level."""
    image = vtk.vtkImageData()
    image.SetDimensions(*(int(n) for n in field.shape))
    image.SetSpacing(spacing, spacing, spacing)
    image.SetOrigin(*low)
    image.GetPointData().SetScalars(numpy_to_vtk(field.ravel(order="F"), deep=True))
    surface = vtk.vtkFlyingEdges3D()
    surface.SetInputData(image)
    surface.SetValue(0, 0.0)
    surface.ComputeNormalsOff()
    return surface


def tree(segments, spacing=0.2, rounded=False, inner=(), reach=2.5, noise=0.0, seed=1):
    """Tree (points, triangles) of straight cones (start, end, r0, r1) by flying edges of `tree_field`.

    Every end is open, and cut flat within `reach` radii. The segments with the numbers `inner` are not cut: they end in
    another segment, or closed.
    `rounded`: all ends are closed by half balls. `noise`: rms displacement (mm) of the wall, added to the field.
    """
    low, field = tree_field(segments, spacing, rounded)
    # a vertex lies at a random part t of a grid edge: E[t^2 + (1 - t)^2] = 2/3 of the nodes' variance reaches it
    field = field + noise * np.sqrt(1.5) * np.random.default_rng(seed).standard_normal(field.shape)
    surface = level_surface(low, field, spacing)
    cuts = []
    for number, (a, b, r0, r1) in enumerate([] if rounded else segments):
        a, b = np.asarray(a, float), np.asarray(b, float)
        t = (b - a) / np.linalg.norm(b - a)
        cuts += [] if number else [(a, -t, r0)]
        cuts += [] if number in inner else [(b, t, r1)]
    for centre, normal, radius in cuts:
        plane, ball, both = vtk.vtkPlane(), vtk.vtkSphere(), vtk.vtkImplicitBoolean()
        plane.SetOrigin(*centre)
        plane.SetNormal(*(-normal))
        ball.SetCenter(*centre)
        ball.SetRadius(reach * radius)
        both.SetOperationTypeToIntersection()
        both.AddFunction(plane)
        both.AddFunction(ball)
        clip = vtk.vtkClipPolyData()
        clip.SetInputConnection(surface.GetOutputPort())
        clip.SetClipFunction(both)
        surface = clip
    triangulate = vtk.vtkTriangleFilter()
    triangulate.SetInputConnection(surface.GetOutputPort())
    triangulate.Update()
    return arrays(triangulate.GetOutput())
