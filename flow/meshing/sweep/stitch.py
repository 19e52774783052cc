"""The lumen's wall between the spans: the part that no span sweeps, zipped to the spans' end rings."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from flow.geometry.surface import WALL, beside, border
from flow.geometry.vectors import dot

CLEAR = 0.5  # local edges: least distance of a remaining facet from the plane of a span's end
NEAR = 2.5  # radii of an end within which its plane cuts the wall
LEAST_COSINE = 0.5  # between a strip's triangle and the smooth surface's normal at the ring
FOLDS = 1e4  # cost of a triangle that folds, in triangles of the best shape


class StitchError(Exception):
    """An end that cannot be joined to the wall: `ends` are the keys of the spans' ends that are to move."""

    def __init__(self, what, ends):
        self.ends = ends
        super().__init__(what)


def cut(surface, side, spans):
    """Facets (m,) bool that the spans take away. side: `surface.edges()[1]`; spans: [Cut]."""
    taken = np.zeros(len(surface.triangles), bool)
    pairs = beside(side)
    for span in spans:
        barrier = np.zeros(len(taken), bool)
        for end in span.ends:
            barrier |= end.beyond(surface)
        barrier |= (surface.region != WALL) & ~np.isin(surface.region, span.caps)
        open_pairs = pairs[~barrier[pairs].any(axis=1)]
        graph = coo_matrix((np.ones(len(open_pairs)), open_pairs.T), (len(taken),) * 2)
        _, label = connected_components(graph, directed=False)
        seeds = span.owners[~barrier[span.owners]]
        taken |= np.isin(label, np.unique(label[seeds])) & ~barrier
    return taken


class End:
    """One end of a span: key (span number, 0 or 1), plane, ring of global vertices in order of angle about the axis.

    outwards: unit vector along the axis, out of the span.
    """

    def __init__(self, key, centre, outwards, radius, ring):
        self.key, self.centre, self.outwards, self.radius, self.ring = key, centre, outwards, radius, ring

    def beyond(self, surface):
        """Facets near this end that lie clear of its plane, on the outer side."""
        height = dot(surface.points - self.centre, self.outwards)
        corners = surface.points[surface.triangles]
        edge = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean(axis=1)
        distance = np.linalg.norm(corners.mean(axis=1) - self.centre, axis=1)
        return (height[surface.triangles].min(axis=1) > CLEAR * edge) & (distance < NEAR * self.radius)


def trim_ears(surface, taken, wall):
    """Takes away remaining wall facets with two or three sides on the cut, until there is none."""
    _, side = surface.edges()
    taken = taken.copy()
    while True:
        loose = np.bincount(side[~taken].ravel(), minlength=side.max() + 1) == 1
        ears = ~taken & wall & (loose[side].sum(axis=1) >= 2)
        if not ears.any():
            return taken
        taken |= ears


def loops(triangles):
    """Boundary loops of facets, each an array of vertices in the facets' direction. None where one touches itself."""
    edges = border(triangles)
    if len(np.unique(edges[:, 0])) != len(edges):
        return None
    following = dict(edges.tolist())
    found = []
    while following:
        first, vertex = next(iter(following.items()))
        loop = [first]
        del following[first]
        while vertex != first:
            loop.append(vertex)
            vertex = following.pop(vertex)
        found.append(np.array(loop))
    return found


def zipper(points, normals, loop, ring):
    """Triangles (l + r, 3) between two closed chains of vertices that run the same way round; loop's edges a -> b get
    triangles (b, a, ring vertex).

    Of all ways to join them in order, from the closest pair on, the one whose triangles are best: `_badness` summed.
    """
    gap = np.linalg.norm(points[loop][:, None] - points[ring][None], axis=2)
    i, j = np.unravel_index(np.argmin(gap), gap.shape)
    loop, ring = np.roll(loop, -i), np.roll(ring, -j)
    rows, columns = len(loop), len(ring)
    # triangle (a, b) on an edge of the loop, and on one of the ring: both end at loop[a], ring[b]
    a, b = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    on_loop = np.stack([loop[a], loop[a - 1], ring[b]], axis=-1)
    on_ring = np.stack([loop[a], ring[b - 1], ring[b]], axis=-1)
    cost_loop, cost_ring = (_badness(points, normals, one)[0] for one in (on_loop, on_ring))
    cost = np.full((rows + 1, columns + 1), np.inf)
    cost[0, 0] = 0.0
    by_loop = np.zeros(cost.shape, bool)
    for a in range(rows + 1):
        for b in range(columns + 1):
            if a + b:
                along = cost[a - 1, b] + cost_loop[a % rows, b % columns] if a else np.inf
                across = cost[a, b - 1] + cost_ring[a % rows, b % columns] if b else np.inf
                by_loop[a, b], cost[a, b] = along <= across, min(along, across)
    a, b, found = rows, columns, []
    while a + b:
        if by_loop[a, b]:
            found.append(on_loop[a % rows, b % columns])
            a -= 1
        else:
            found.append(on_ring[a % rows, b % columns])
            b -= 1
    return np.array(found)


def _badness(points, normals, triangles):
    """(badness (...,), cosine with the surface's normal (...,)) of triangles (..., 3).

    The badness is 1 over the shape (1 of an equilateral triangle), FOLDS more where one does not face as the surface.
    """
    a, b, c = (points[triangles[..., k]] for k in range(3))
    area = np.cross(b - a, c - a)
    twice = np.linalg.norm(area, axis=-1)
    sides = sum(((one - other) ** 2).sum(axis=-1) for one, other in ((a, b), (b, c), (c, a)))
    facing = normals[triangles].sum(axis=-2)
    cosine = (area * facing).sum(axis=-1) / np.maximum(twice * np.linalg.norm(facing, axis=-1), 1e-300)
    return sides / np.maximum(2.0 * np.sqrt(3.0) * twice, 1e-300) + FOLDS * (cosine < LEAST_COSINE), cosine


def strips(points, normals, kept, ends):
    """{end key: strip triangles} that join the loops of the `kept` facets to the rings. Raises StitchError."""
    keys = [end.key for end in ends]
    borders = loops(kept)
    if borders is None:
        raise StitchError("a loop touches itself", keys)
    centres = np.array([points[loop].mean(axis=0) for loop in borders])
    nearest = [int(np.argmin(np.linalg.norm(centres - end.centre, axis=1))) for end in ends]
    shared = [key for key, loop in zip(keys, nearest) if nearest.count(loop) > 1]
    if shared or len(borders) != len(ends):
        raise StitchError(f"{len(borders)} loops for {len(ends)} ends", shared or keys)
    result = {}
    for end, place in zip(ends, nearest):
        loop = borders[place]
        # the ring runs counter-clockwise about the axis; seen from outside the span the loop may run either way
        ring = end.ring if _turns(points[loop], end) == _turns(points[end.ring], end) else end.ring[::-1]
        strip = zipper(points, normals, loop, ring)
        least = _badness(points, normals, strip)[1].min()
        if least < LEAST_COSINE:
            raise StitchError(f"a strip folds (cosine {least:.2f})", [end.key])
        result[end.key] = strip
    return result


def _turns(chain, end):
    """Whether a closed chain of points runs counter-clockwise about the end's outward axis."""
    flat = chain - end.centre
    return float(dot(np.cross(flat, np.roll(flat, -1, axis=0)).sum(axis=0), end.outwards)) > 0
