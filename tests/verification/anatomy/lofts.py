"""Lumens as other programs loft them: rings with few corners along an axis, joined by quadrangles, with flat ends."""

import numpy as np
import surfaces


def frames(axis, s):
    """(tangent, u, v) along an axis, each (n, 3): u and v turn as little as they can."""
    tangent = (axis(s + 1e-5) - axis(s - 1e-5)) / 2e-5
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    u = np.zeros_like(tangent)
    across = np.eye(3)[np.argmin(np.abs(tangent[0]))]
    u[0] = np.cross(tangent[0], across)
    for i in range(1, len(s)):
        u[i] = u[i - 1] - tangent[i] * (u[i - 1] @ tangent[i])
        u[i] /= np.linalg.norm(u[i])
    u[0] /= np.linalg.norm(u[0])
    return tangent, u, np.cross(tangent, u)


def loft(axis, radius, length, corners, spacing, caps="fan", slant=0.0):
    """Triangles (points, triangles) of rings of `corners` points every `spacing` mm along an axis of arc length.

    caps: "fan" (a point in the middle), "polygon" (no inner point), "round" (a half ball) or "open". slant: degrees by
    which both end planes lean. Outward. The corners lie on the circle of `radius`, a function of arc length.
    """
    s = np.linspace(0, length, max(2, round(length / spacing) + 1))
    r = radius(s)
    if caps == "round":  # rings of the half balls, from the pole on
        angle = np.linspace(0.15, np.pi / 2, 7)[:-1]
        s = np.concatenate([-r[0] * np.cos(angle), s, length + r[-1] * np.cos(angle[::-1])])
        r = np.concatenate([r[0] * np.sin(angle), r, r[-1] * np.sin(angle[::-1])])
        caps = "fan"
    tangent, u, v = frames(axis, s)
    angle = 2 * np.pi * np.arange(corners) / corners
    ring = np.cos(angle)[None, :, None] * u[:, None] + np.sin(angle)[None, :, None] * v[:, None]
    lean = np.tan(np.radians(slant)) * np.cos(angle)
    fade = np.zeros((len(s), 1))  # rings near an end lean less and less, so that they do not cross
    for at, sign in ((s, 1), (length - s, -1)):
        reach = 3 * r[0 if sign > 0 else -1]
        fade[:, 0] += sign * np.clip(1 - at / reach, 0, 1)
    points = axis(s)[:, None] + r[:, None, None] * (ring + (fade * lean)[..., None] * tangent[:, None])
    points = points.reshape(-1, 3)
    triangles = []
    for i in range(len(s) - 1):
        for k in range(corners):
            a, b = i * corners + k, i * corners + (k + 1) % corners
            triangles += [(a, b, a + corners), (a + corners, b, b + corners)]
    first, last = np.arange(corners), (len(s) - 1) * corners + np.arange(corners)
    for rim, outward in ((first, -1), (last, 1)):
        if caps == "fan":
            points = np.vstack([points, points[rim].mean(axis=0)])
            fan = [(len(points) - 1, rim[k], rim[(k + 1) % corners]) for k in range(corners)]
        elif caps == "polygon":
            fan = [(rim[0], rim[k], rim[k + 1]) for k in range(1, corners - 1)]
        else:
            fan = []
        triangles += fan if outward > 0 else [t[::-1] for t in fan]
    return points, np.array(triangles)


def narrowed(healthy, percent, at, length):
    """Radius (mm) of arc length: a cosine narrowing by `percent` of the diameter, `length` mm long, about `at`."""

    def radius(s):
        inside = np.abs(s - at) < length / 2
        return healthy * (1 - percent / 100 * inside * (0.5 + 0.5 * np.cos(2 * np.pi * (s - at) / length)))

    return radius


def noised(points, deviation, seed):
    """Points moved at random in every direction; `deviation` mm a coordinate."""
    return points + deviation * np.random.default_rng(seed).standard_normal(points.shape)


def decimated(points, triangles, kept):
    """A closed surface with this part of its triangles left, as quadric decimation chooses them."""
    filter_ = surfaces.vtk.vtkQuadricDecimation()
    filter_.SetInputData(surfaces.polydata(points, triangles))
    filter_.SetTargetReduction(1 - kept)
    filter_.Update()
    return surfaces.arrays(filter_.GetOutput())


class UnionFailed(Exception):
    """VTK's boolean union found no surface."""


def fused(pieces):
    """One closed surface round closed ones [(points, triangles), ...], by VTK's boolean union, piece after piece.

    Raises UnionFailed where the union fails. It may leave tears at the seams, as unions of other programs do.
    """
    whole = surfaces.polydata(*pieces[0])
    for piece in pieces[1:]:
        union = surfaces.vtk.vtkBooleanOperationPolyDataFilter()
        union.SetOperationToUnion()
        union.SetInputData(0, whole)
        union.SetInputData(1, surfaces.polydata(*piece))
        triangles = surfaces.vtk.vtkTriangleFilter()
        triangles.SetInputConnection(union.GetOutputPort())
        clean = surfaces.vtk.vtkCleanPolyData()
        clean.SetInputConnection(triangles.GetOutputPort())
        clean.Update()
        whole = clean.GetOutput()
        if whole.GetNumberOfCells() == 0:
            raise UnionFailed("the boolean union is empty")
    return surfaces.arrays(whole)


def voxelised(points, triangles, edge):
    """(labels (nx, ny, nz) of 0 and 1, low corner) of the voxels whose centres a closed surface contains."""
    low = points.min(axis=0) - 4 * edge
    counts = np.ceil((points.max(axis=0) + 4 * edge - low) / edge).astype(int) + 1
    stencil = surfaces.vtk.vtkPolyDataToImageStencil()
    stencil.SetInputData(surfaces.polydata(points, triangles))
    stencil.SetOutputOrigin(*low)
    stencil.SetOutputSpacing(edge, edge, edge)
    stencil.SetOutputWholeExtent(0, int(counts[0]) - 1, 0, int(counts[1]) - 1, 0, int(counts[2]) - 1)
    image = surfaces.vtk.vtkImageStencilToImage()
    image.SetInputConnection(stencil.GetOutputPort())
    image.SetInsideValue(1)
    image.SetOutsideValue(0)
    image.Update()
    scalars = surfaces.vtk_to_numpy(image.GetOutput().GetPointData().GetScalars())
    return scalars.reshape(counts, order="F").astype(int), low


def contoured(points, triangles, edge):
    """Marching cubes of the mask of a closed surface, smoothed as segmentation programs do (windowed sinc)."""
    labels, low = voxelised(points, triangles, edge)
    surface = surfaces.level_surface(low, 0.5 - labels.astype(float), edge)
    smooth = surfaces.vtk.vtkWindowedSincPolyDataFilter()
    smooth.SetInputConnection(surface.GetOutputPort())
    smooth.SetNumberOfIterations(20)
    smooth.SetPassBand(0.1)
    smooth.NormalizeCoordinatesOn()
    smooth.BoundarySmoothingOff()
    smooth.Update()
    return surfaces.arrays(smooth.GetOutput())


def with_ring_cap(points, triangles, around, rings):
    """A tube, open at both ends, with a flat cap at its start (the first `around` points) made of `rings` rings.

    The other end stays open.
    """
    rim, centre = points[:around], points[:around].mean(axis=0)
    shares = np.linspace(1, 0, rings + 1)[1:-1]
    added = [centre + share * (rim - centre) for share in shares]
    rows = [np.arange(around) + (k and len(points) + (k - 1) * around) for k in range(rings)]
    first = np.arange(around)
    second = (first + 1) % around
    parts = [triangles]
    for outer, inner in zip(rows, rows[1:]):
        parts += [np.column_stack([outer[first], inner[first], outer[second]])]
        parts += [np.column_stack([inner[first], inner[second], outer[second]])]
    middle = len(points) + (rings - 1) * around
    parts.append(np.column_stack([np.full(around, middle), rows[-1][second], rows[-1][first]]))
    return np.vstack([points, *added, centre]), np.vstack(parts)
