"""Finds each branch's centreline from the image and the end points: the cheapest path through the contrast."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import splev, splprep
from scipy.ndimage import distance_transform_edt, gaussian_filter, label
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from common.errors import ComputationError, InputError
from common.implicit.curves import Curve


SEED_RADIUS_MM = 0.6  # radius of the ball in which the blood's CT number is averaged
# Shares of the blood's CT number: above the first a path may cross a voxel, above the second the voxel is lumen.
PASSABLE_SHARE, LUMEN_SHARE = 0.2, 0.5
BRIGHT_RATIO = 1.15  # voxels above this times the blood's CT number at the brightest end are calcium or metal
LARGEST_BLOOD_RISE = 1.5  # blood at an end point is at most this times the inlet's; brighter points lie in calcium
THICK_MM = 1.0  # slices further apart than this may be the reason why a coronary artery is not found
SMOOTHING_MM = 0.15  # rms distance, per coordinate, between a smoothed axis and the voxels of its path


@dataclass
class Line:
    """Axis of one branch.

    parent: index of the branch that it leaves, -1 for the main vessel. end: index of its end point. blood: CT number of
    the blood along the axis (blood.Trend); None as long as it is not known.
    """

    axis: Curve
    parent: int
    end: int
    blood: object = None


def blood_hu(image, inlet_mm):
    """CT number of the blood at a point (3,) in mm such as the inlet: mean over the voxels within 0.6 mm of it.

    In thick slices no voxel may be so near. The nearest one counts then.
    """
    reach = np.ceil(SEED_RADIUS_MM / image.spacing_mm).astype(int)
    index, _ = image.index(inlet_mm)
    box = tuple(slice(max(i - r, 0), i + r + 1) for i, r in zip(index, reach))
    centres = np.stack(np.meshgrid(*[image.centres(k)[box[k]] for k in range(3)], indexing="ij"), axis=-1)
    distance = np.linalg.norm(centres - inlet_mm, axis=-1)
    return float(image.values[box][distance <= max(SEED_RADIUS_MM, distance.min())].mean())


def _graph(cost, spacing_mm):
    """(graph as a sparse matrix, flat indices (n,) of its cells) over the voxels of finite cost.

    The graph joins each voxel to its 26 neighbours. An edge's weight is its length in mm times the mean cost of its two
    voxels.
    """
    number = np.full(cost.shape, -1)
    cells = np.flatnonzero(np.isfinite(cost))
    number.flat[cells] = np.arange(len(cells))
    rows, columns, weights = [], [], []
    for dx, dy, dz in np.ndindex(3, 3, 3):
        step = np.array([dx, dy, dz]) - 1
        if tuple(step) <= (0, 0, 0):
            continue
        lower = tuple(slice(max(-d, 0), n - max(d, 0)) for d, n in zip(step, cost.shape))
        upper = tuple(slice(max(d, 0), n - max(-d, 0)) for d, n in zip(step, cost.shape))
        both = (number[lower] >= 0) & (number[upper] >= 0)
        rows.append(number[lower][both])
        columns.append(number[upper][both])
        weights.append(np.linalg.norm(step * spacing_mm) * 0.5 * (cost[lower][both] + cost[upper][both]))
    rows, columns = np.concatenate(rows), np.concatenate(columns)
    return csr_matrix((np.concatenate(weights), (rows, columns)), shape=(len(cells),) * 2), cells


def find_branches(image, ends):
    """[Line] of all branches, the main vessel first. ends: [(name, centre (3,) mm)] within the image, the inlet first.

    A path should keep to the middle of the vessel. So where the CT number is above half the blood's, its cost per mm is
    about 1 / (distance from the lumen's edge)^2. The cost is high in darker voxels and in calcium. Voxels below a fifth
    of the blood's CT number cannot be crossed. Raises InputError for an end point that is not in a vessel, and
    ComputationError if an end cannot be reached.
    """
    blood = blood_hu(image, ends[0][1])
    top = min(max(blood_hu(image, centre) for _, centre in ends), LARGEST_BLOOD_RISE * blood)
    smooth = gaussian_filter(image.values.astype(np.float32), 0.25 / image.spacing_mm)
    lumen = (smooth > LUMEN_SHARE * blood) & (smooth < BRIGHT_RATIO * top)
    depth = distance_transform_edt(lumen, sampling=image.spacing_mm)
    cost = np.where(lumen, 1 / (0.1 + depth) ** 2, 100.0 * (LUMEN_SHARE * blood / np.maximum(smooth, 1.0)) ** 2)
    cost[smooth > BRIGHT_RATIO * top] = 400.0
    cost[smooth < PASSABLE_SHARE * blood] = np.inf
    seeds = [_seed(image, smooth, name, centre, blood) for name, centre in ends]
    parts, _ = label(np.isfinite(cost), np.ones((3, 3, 3)))
    for (name, _), seed in zip(ends, seeds):
        if parts[seed] != parts[seeds[0]]:
            value = f"nowhere more than {PASSABLE_SHARE:g} of the blood's {blood:.0f} HU all the way"
            remedy = (
                "check that the point lies in the inlet's vessel; end an occluded one before its occlusion, or give"
            )
            remedy += " a centreline (ct: centreline, --centreline)" + _about_thick_slices(image)
            raise ComputationError("no way through the contrast from the inlet", name, value, remedy)
    cost[parts != parts[seeds[0]]] = np.inf
    graph, cells = _graph(cost, image.spacing_mm)
    place = {cell: number for number, cell in enumerate(cells)}
    nodes = [place[np.ravel_multi_index(seed, cost.shape)] for seed in seeds]
    _, before = dijkstra(graph, directed=False, indices=nodes[0], return_predecessors=True)
    chains = []
    for node in nodes[1:]:
        chain = [node]
        while chain[-1] != nodes[0]:
            chain.append(before[chain[-1]])
        index = np.stack(np.unravel_index(cells[chain[::-1]], cost.shape), axis=1)
        chains.append(image.origin_mm + image.spacing_mm * index)
    return _branches(chains, [np.asarray(centre, float) for _, centre in ends])


def _about_thick_slices(image):
    """What to add to a remedy if the voxels are too large for a coronary artery; nothing if they are not."""
    spacing_mm = image.spacing_mm.max()
    return f"; slices are {spacing_mm:.2g} mm apart: give those of 1 mm or less" if spacing_mm > THICK_MM else ""


def _seed(image, smooth, name, centre, blood):
    """Index (3,) of the brightest voxel next to an end point. Raises InputError if it is darker than the lumen."""
    index, _ = image.index(np.asarray(centre, float))
    box = tuple(slice(max(i - 1, 0), i + 2) for i in index)
    best = np.unravel_index(np.argmax(smooth[box]), smooth[box].shape)
    seed = tuple(int(s.start + b) for s, b in zip(box, best))
    if smooth[seed] < LUMEN_SHARE * blood:
        value = f"{smooth[seed]:.0f} HU where blood is {blood:.0f}"
        remedy = f"put it on the vessel's axis, where at least {LUMEN_SHARE:g} of the blood's HU are; the inlet's too"
        remedy += "; mm in the volume's own coordinates, not voxel numbers" + _about_thick_slices(image)
        raise InputError("the end point is not in a contrast-filled vessel", name, value, remedy)
    return seed


def _length(points):
    """Length in mm of a line of points (n, 3)."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def smooth_curve(points, spread_mm=SMOOTHING_MM):
    """Curve by a smoothing spline whose rms distance from points (n, 3) is about spread_mm per coordinate."""
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    keep = np.concatenate([[True], np.diff(s) > 1e-6])
    points, s = points[keep], s[keep]
    if len(s) < 2 or not np.isfinite(points).all():
        remedy = (
            "check that the volume is in CT numbers, and that the end points lie in the vessel; or give a centreline"
        )
        raise ComputationError("an axis has no length", "CT volume", f"{len(s)} points that differ", remedy)
    weights = np.ones(len(s))
    weights[[0, -1]] = 20.0
    spline, _ = splprep(points.T, u=s, w=weights, k=min(5, len(s) - 1), s=3 * len(s) * spread_mm**2)
    fine = np.linspace(0, s[-1], max(int(s[-1] / 0.1), 12) + 1)
    return Curve(np.stack(splev(fine, spline), axis=1))


def _branches(chains, centres):
    """[Line] from chains of voxel centres, which all begin at the inlet. The longest one becomes the main vessel.

    Each other chain becomes a branch that begins on its parent's axis. centres: the end points, the inlet first.
    """
    order = np.argsort([-_length(chain) for chain in chains], kind="stable")
    lines, raw = [], []
    for rank, number in enumerate(order):
        chain = chains[number].copy()
        chain[0], chain[-1] = centres[0], centres[number + 1]
        if rank == 0:
            lines.append(Line(smooth_curve(chain), -1, int(number) + 1))
            raw.append(chain)
            continue
        # The parent is the branch that shares the longest stretch with the chain.
        shared = [_shared_count(chain, other) for other in raw]
        parent = int(np.argmax(shared))
        leaves = max(shared[parent] - 1, 0)
        axis = lines[parent].axis
        start = axis.point(axis.nearest(chain[leaves : leaves + 1]))[0]
        lines.append(Line(smooth_curve(np.concatenate([start[None], chain[leaves + 2 :]])), parent, int(number) + 1))
        raw.append(chain)
    return lines


def _shared_count(chain, other):
    """Number of points that two chains share from the inlet on."""
    count = min(len(chain), len(other)) - 1
    same = np.all(np.abs(chain[1:count] - other[1:count]) < 1e-9, axis=1)
    return int(np.argmin(same)) + 1 if not same.all() else count
