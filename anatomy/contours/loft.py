"""Makes a closed triangle surface with flat, tagged ends from rings along an axis."""

import numpy as np
from matplotlib.path import Path
from scipy.spatial import Delaunay

from common.errors import ComputationError, InputError

WALL, INLET, OUTLET = 0, 1, 2  # region_id (docs/design.md)


def surface(rings_mm, names_mm):
    """(points (p, 3) in mm, triangles (m, 3), region (m,)) of the closed surface through rings (k, n, 3).

    The rings run from distal to proximal. The outlet's cap closes the distal ring, the inlet's cap the proximal ring.
    Triangles face outwards. region: WALL, INLET or OUTLET. names_mm (k,): z of each ring in the tables, for messages.
    Raises InputError if rings intersect because the axis bends too sharply for the lumen's width.
    """
    _check_advance(rings_mm, names_mm)
    count, around = rings_mm.shape[:2]
    points = rings_mm.reshape(-1, 3)
    wall = _wall(rings_mm)
    parts, region = [wall], [np.zeros(len(wall), int)]
    step = np.diff(rings_mm.mean(axis=1), axis=0)
    for ring, tag, out in ((0, OUTLET, -step[0]), (count - 1, INLET, step[-1])):
        inner, cap = _cap(rings_mm[ring], out)
        number = np.concatenate([ring * around + np.arange(around), len(points) + np.arange(len(inner))])
        points = np.vstack([points, inner])
        parts.append(number[cap])
        region.append(np.full(len(cap), tag))
    triangles = np.vstack(parts)
    _check_closed(triangles)
    return points, triangles, np.concatenate(region)


def volume_mm3(points, triangles):
    """Volume in mm3 within a closed surface; positive if its triangles face outwards."""
    a, b, c = (points[triangles[:, k]] - points[0] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def _wall(rings_mm):
    """Triangles between neighbouring rings, facing outwards, along the shorter diagonal of each quadrangle."""
    count, around = rings_mm.shape[:2]
    index = np.arange(count * around).reshape(count, around)
    a, b = index[:-1], np.roll(index, -1, axis=1)[:-1]
    c, d = np.roll(index, -1, axis=1)[1:], index[1:]
    flat = rings_mm.reshape(-1, 3)
    short = np.linalg.norm(flat[a] - flat[c], axis=2) <= np.linalg.norm(flat[b] - flat[d], axis=2)
    one = np.where(short[..., None], np.stack([a, b, c], axis=2), np.stack([a, b, d], axis=2))
    two = np.where(short[..., None], np.stack([a, c, d], axis=2), np.stack([b, c, d], axis=2))
    triangles = np.concatenate([one.reshape(-1, 3), two.reshape(-1, 3)])
    anticlockwise = _normal(rings_mm[0]) @ (rings_mm[1].mean(axis=0) - rings_mm[0].mean(axis=0)) > 0
    return triangles if anticlockwise else triangles[:, ::-1]


def _check_advance(rings_mm, names_mm):
    """Raises InputError if the wall would fold: where a ring's point is not proximal of the same point before."""
    step = np.diff(rings_mm, axis=0)
    axis = np.diff(rings_mm.mean(axis=1), axis=0)
    normals = np.array([_normal(ring) for ring in rings_mm[:-1]])
    normals *= np.sign(np.einsum("ij,ij->i", normals, axis))[:, None]
    behind = np.einsum("ijk,ik->ij", step, normals).min(axis=1)
    if (behind <= 0).any():
        z = names_mm[int(behind.argmin())]
        value = f"the wall goes back by {-behind.min():.2g} mm: the centreline bends within the lumen"
        remedy = "give a smoother centreline; check its units (centreline: units) and the tables' (units)"
        raise InputError("the frames run into each other", f"z {z:.1f} mm", value, remedy)


def _normal(ring):
    """Unit normal (3,) of a ring (n, 3)."""
    relative = ring - ring.mean(axis=0)
    normal = np.cross(relative, np.roll(relative, -1, axis=0)).sum(axis=0)
    return normal / np.linalg.norm(normal)


def _cap(ring, out):
    """(inner points (q, 3), triangles (m, 3)) that close a plane ring (n, 3).

    Triangles number the ring's points first, then the inner points. They face the direction out (3,).
    """
    centre, normal = ring.mean(axis=0), _normal(ring)
    u = ring[0] - centre
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    rim = np.column_stack([(ring - centre) @ u, (ring - centre) @ v])
    inner = _inner(rim)
    flat = np.vstack([rim, inner])
    triangles = Delaunay(flat).simplices
    triangles = triangles[Path(rim).contains_points(flat[triangles].mean(axis=1))]
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    facing = (normal @ out) > 0
    triangles = np.where(((area > 0) == facing)[:, None], triangles, triangles[:, ::-1])
    return centre + inner[:, :1] * u + inner[:, 1:] * v, triangles


def _inner(rim):
    """Triangular grid of points (q, 2) inside a rim (n, 2), at least 0.7 grid spacings from the rim's points."""
    edge = 1.2 * np.linalg.norm(rim - np.roll(rim, 1, axis=0), axis=1).mean()
    low, high = rim.min(axis=0), rim.max(axis=0)
    rows = []
    for k, y in enumerate(np.arange(low[1], high[1], edge * np.sqrt(3) / 2)):
        x = np.arange(low[0] + 0.5 * edge * (k % 2), high[0], edge)
        rows.append(np.column_stack([x, np.full(len(x), y)]))
    grid = np.vstack(rows)
    near = np.linalg.norm(grid[:, None] - rim[None], axis=2).min(axis=1)
    return grid[Path(rim).contains_points(grid) & (near > 0.7 * edge)]


def _check_closed(triangles):
    """Raises ComputationError unless every edge belongs to two triangles."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    _, times = np.unique(edges, axis=0, return_counts=True)
    if (times != 2).any():
        value = f"{int((times != 2).sum())} loose edges"
        remedy = "leave out the first or the last frame, whose outline is doubtful: drop_frames or z_range_mm"
        raise ComputationError("the lofted lumen is not closed", "ends of the pull-back", value, remedy)
