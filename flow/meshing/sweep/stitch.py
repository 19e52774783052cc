"""The lumen's wall between the spans: the part that no span replaces, joined to the spans' end rings.

The wall facets that a span replaces are cut away. A strip of triangles then joins the border of the remaining facets to
the ring of wall vertices at the span's end.
"""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from flow.geometry.surface import WALL, facets_at_edges, border_edges
from flow.geometry.vectors import dot

CLEARANCE_EDGES = 0.5  # least distance of a remaining facet from a span's end plane, in mean edge lengths of the facet
NEAR_RADII = 2.5  # only facets within this many radii of the centre of a span's end can stop the cut there
LEAST_COSINE = 0.5  # a triangle folds if the cosine of the angle between its normal and the smooth surface's is less
FOLD_PENALTY = 1e4  # badness (see _badness) added to a triangle that folds; an equilateral triangle has a badness of 1


class StitchError(Exception):
    """A junction cannot be closed or filled. ends: keys (span number, 0 or 1) of the spans' ends that should move."""

    def __init__(self, what, ends):
        self.ends = ends
        super().__init__(what)


def replaced_facets(surface, side, spans):
    """Which facets (m,) bool of the surface the spans replace. side: `surface.edges()[1]`; spans: [hybrid.SpanCut].

    A span replaces the facets of its wall points and all facets connected with them, up to the planes of its ends.
    Where such a plane grazes the wall of the parent, no facet lies clear beyond it. Then nothing stops the cut, and it
    runs on along this wall to other spans. Raises StitchError with the ends of such spans, which have to move.
    """
    replaced = np.zeros(len(surface.triangles), bool)
    pairs = facets_at_edges(side)
    runaway = []
    for span in spans:
        barrier = np.zeros(len(replaced), bool)
        for end in span.ends:
            barrier |= end.facets_beyond(surface)
        barrier |= (surface.region != WALL) & ~np.isin(surface.region, span.caps)
        open_pairs = pairs[~barrier[pairs].any(axis=1)]
        graph = coo_matrix((np.ones(len(open_pairs)), open_pairs.T), (len(replaced),) * 2)
        _, label = connected_components(graph, directed=False)
        seeds = span.wall_facets[~barrier[span.wall_facets]]
        cut = np.isin(label, np.unique(label[seeds])) & ~barrier
        others = np.concatenate([other.wall_facets for other in spans if other is not span] or [seeds[:0]])
        if cut[others].any():
            runaway += [end.key for end in span.ends]
        replaced |= cut
    if runaway:
        raise StitchError("a cut runs on beyond the end's plane", runaway)
    return replaced


class SpanEnd:
    """One end of a span, without a cap.

    key: (span number, 0 for its first or 1 for its last end); centre (3,) and radius in mm; outwards: unit vector (3,)
    along the axis, out of the span; ring: wall vertices in order of angle about the axis, numbered in the whole mesh.
    """

    def __init__(self, key, centre, outwards, radius, ring):
        self.key, self.centre, self.outwards, self.radius, self.ring = key, centre, outwards, radius, ring

    def facets_beyond(self, surface):
        """Which facets (m,) bool near this end lie outside the span, clear of the end's plane."""
        height = dot(surface.points - self.centre, self.outwards)
        corners = surface.points[surface.triangles]
        edge = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean(axis=1)
        distance = np.linalg.norm(corners.mean(axis=1) - self.centre, axis=1)
        return (height[surface.triangles].min(axis=1) > CLEARANCE_EDGES * edge) & (distance < NEAR_RADII * self.radius)


def trim_ears(surface, replaced, wall):
    """`replaced` (m,) bool with all ears added: wall facets left with two or three sides on the border.

    Ears are added until there is none. wall (m,) bool: facets of the wall.
    """
    _, side = surface.edges()
    replaced = replaced.copy()
    while True:
        loose = np.bincount(side[~replaced].ravel(), minlength=side.max() + 1) == 1
        ears = ~replaced & wall & (loose[side].sum(axis=1) >= 2)
        if not ears.any():
            return replaced
        replaced |= ears


def border_loops(triangles):
    """Border loops of triangles (m, 3), each an array of vertices in the triangles' direction.

    None where a loop touches itself or another one.
    """
    edges = border_edges(triangles)
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


def strip_between(points, normals, loop, ring):
    """Triangles (l + r, 3) of the strip between two closed chains of vertices, loop (l,) and ring (r,).

    Both chains run the same way round. An edge a -> b of the loop gets a triangle (b, a, ring vertex). The strip starts
    at the closest pair of vertices. Of all strips from there, it is the one with the least sum of `_badness`.
    """
    gap = np.linalg.norm(points[loop][:, None] - points[ring][None], axis=2)
    i, j = np.unravel_index(np.argmin(gap), gap.shape)
    loop, ring = np.roll(loop, -i), np.roll(ring, -j)
    rows, columns = len(loop), len(ring)
    # on_loop[a, b] and on_ring[a, b]: the triangles on an edge of loop and ring that end at loop[a], ring[b]
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

    normals (n, 3): normals of the smooth surface at the points (n, 3). The badness is 1 for an equilateral triangle and
    grows as a triangle gets flatter. FOLD_PENALTY is added where the cosine is below LEAST_COSINE.
    """
    a, b, c = (points[triangles[..., k]] for k in range(3))
    area = np.cross(b - a, c - a)
    twice = np.linalg.norm(area, axis=-1)
    sides = sum(((one - other) ** 2).sum(axis=-1) for one, other in ((a, b), (b, c), (c, a)))
    facing = normals[triangles].sum(axis=-2)
    cosine = (area * facing).sum(axis=-1) / np.maximum(twice * np.linalg.norm(facing, axis=-1), 1e-300)
    return sides / np.maximum(2.0 * np.sqrt(3.0) * twice, 1e-300) + FOLD_PENALTY * (cosine < LEAST_COSINE), cosine


def build_strips(points, normals, kept, ends):
    """{end key: triangles (k, 3)} of the strips that join the remaining facets to the rings of the ends.

    kept (m, 3): the remaining facets; ends: [SpanEnd]. Raises StitchError.
    """
    keys = [end.key for end in ends]
    borders = border_loops(kept)
    if borders is None:
        raise StitchError("a loop touches itself", keys)
    centres = np.array([points[loop].mean(axis=0) for loop in borders])
    # if the cuts took all of the wall (see replaced_facets), there is no loop
    nearest = [int(np.argmin(np.linalg.norm(centres - end.centre, axis=1))) for end in ends if borders]
    shared = [key for key, loop in zip(keys, nearest) if nearest.count(loop) > 1]
    if shared or len(borders) != len(ends):
        raise StitchError(f"{len(borders)} loops for {len(ends)} ends", shared or keys)
    result = {}
    for end, place in zip(ends, nearest):
        loop = borders[place]
        # strip_between needs both to run the same way round about the axis
        ring = (
            end.ring
            if _runs_counterclockwise(points[loop], end) == _runs_counterclockwise(points[end.ring], end)
            else end.ring[::-1]
        )
        strip = strip_between(points, normals, loop, ring)
        least = _badness(points, normals, strip)[1].min()
        if least < LEAST_COSINE:
            raise StitchError(f"a strip folds (cosine {least:.2f})", [end.key])
        result[end.key] = strip
    return result


def _runs_counterclockwise(chain, end):
    """Whether a closed chain of points runs counter-clockwise about the end's outward axis."""
    flat = chain - end.centre
    return float(dot(np.cross(flat, np.roll(flat, -1, axis=0)).sum(axis=0), end.outwards)) > 0
