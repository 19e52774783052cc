"""One span (a swept stretch of a branch) as tetrahedra.

The template disc (meshing.sweep.disc) is laid into the section at every station. The prisms between two stations are
split into tetrahedra. A point (rho, angle) of the disc lies at the distance m(rho) r(angle) from the section's centre,
where r is the radius of the smooth surface. m makes the rings narrow at the edge of the jet behind a narrowing
(`ring_radii`). In the throat, and without a jet, this edge is put at LARGEST_JET_SHARE of the radius.

For the middle points of edges the disc is also laid into sections halfway between stations. These points make the edges
at the wall curved. The nearer an edge is to the axis, the nearer its middle point is put to the middle of a straight
edge.
"""

import dataclasses

import numpy as np

from flow.geometry import tet10
from flow.geometry.vectors import cosines_and_sines
from flow.meshing.sweep import axis as axis_module

REACH_RADII = 2.5  # a section is cut only from wall facets within this many branch radii of its plane's origin
LARGEST_ASPECT = 3.0  # largest ratio of largest to smallest radius in a section that is swept
# Constants of ring_radii. LARGEST_JET_SHARE limits the jet's radius over the vessel's. GRADING says how much the rings
# within the jet narrow towards its edge. LAST_RING is where the last ring but one ends, as a share of the way from the
# jet's edge to the wall. The last two have a value for up to three rings and one for four. They were fitted to the
# error of FFR at a stenosis of 62 %. It is -.0002 with three rings (-.0005 with the second values), and +.0007 with
# four (+.0010 with a LAST_RING of 1 / 3).
LARGEST_JET_SHARE = 0.82
GRADING, LAST_RING = (0.3, 0.5), (1 / 3, 1 / 2)
# With more than FITTED_RINGS rings the share SHARE_IN_JET of them lies within the jet, so that more rings make a mesh
# finer everywhere. FINE_GRADING then replaces GRADING. It was also tried to leave as few rings outside the jet as with
# 4 rings. Then 6 rings had an error of FFR of +.0003 instead of +.0001, and 10 rings left every tenth curved edge
# straight.
FITTED_RINGS, SHARE_IN_JET, FINE_GRADING = 4, 2 / 3, 0.3
CURVING_EXPONENT = (
    3  # the middle of an edge is moved from its straight to its curved place by the share rho^CURVING_EXPONENT
)


@dataclasses.dataclass
class Lattice:
    """A span's linear tetrahedra with the middles of all their edges; vertices are numbered within the span, from 0.

    points (n, 3) in mm; tetrahedra (t, 4); edges (e, 2) and their middles (e, 3) in mm; wall: outward triangles (f, 3);
    discs: outward triangles (d, 3) of the first and of the last end; rims: wall vertices (r,) of the two ends in order
    of angle; normals (n, 3): unit normals of the smooth surface at the rims, zero elsewhere; wall_facets: numbers of
    the surface's facets on which the wall points lie, without those of the two ends.
    """

    points: np.ndarray
    tetrahedra: np.ndarray
    edges: np.ndarray
    middles: np.ndarray
    wall: np.ndarray
    discs: tuple
    rims: tuple
    normals: np.ndarray
    wall_facets: np.ndarray


class Sections:
    """Cross-sections at the arc lengths s_mm (m,) of an axis (meshing.sweep.axis.Axis).

    `sections` are section.Section, or None where the plane does not cut the wall in a single loop. caps: region ids of
    the caps whose rims are the first and the last section, or None.
    """

    def __init__(self, slicer, axis, s_mm, caps=(None, None)):
        origins, normals = axis.planes(s_mm)
        e1, e2 = axis_module.frames(origins, normals)
        self.s_mm, self.normals, self.e1, self.e2 = s_mm, normals, e1, e2
        self.sections = []
        for k, (origin, normal) in enumerate(zip(origins, normals)):
            cap = caps[0] if k == 0 else caps[1] if k == len(s_mm) - 1 else None
            if cap is not None:
                found = slicer.rim_section(cap, origin, e1[k], e2[k])
            else:
                found = slicer.cut_section(origin, normal, e1[k], e2[k], REACH_RADII * axis.radius(s_mm[k]))
            self.sections.append(found)

    def radii(self, angles):
        """(radius (m, k) in mm, ok (m,) bool, facets (m, k), unit normals (m, k, 3)) at angles (k,) in rad.

        ok: whether the section is star-shaped about its centre, with an aspect of at most LARGEST_ASPECT. facets: the
        surface's facets at these places, -1 where the section is not star-shaped; radius and normals are 0 there.
        """
        shape = (len(self.sections), len(angles))
        radius, facets, normals = np.zeros(shape), np.full(shape, -1), np.zeros(shape + (3,))
        ok = np.zeros(shape[0], bool)
        for k, section in enumerate(self.sections):
            found = section.radii(angles) if section is not None else None
            if found is not None:
                radius[k], facets[k], normals[k] = found
                ok[k] = radius[k].max() <= LARGEST_ASPECT * radius[k].min()
        return radius, ok, facets, normals

    @property
    def centres(self):
        """Centres (m, 3) in mm of the sections."""
        return np.array([section.centre for section in self.sections])


def ring_radii(rho, rings, jet_share):
    """Distances from the centre over the section's radius, (m, n), for points of the disc at rho (n,).

    jet_share (m,): the jet's radius over the vessel's at each level; it is limited to LARGEST_JET_SHARE. With up to
    FITTED_RINGS rings all but the outer one and a half lie within the jet. There they get narrower towards the jet's
    edge by GRADING. The last ring but one ends at the share LAST_RING of the way from the jet's edge to the wall. With
    more rings two thirds of them lie within the jet; the others are equally wide.
    """
    if rings > FITTED_RINGS:
        inner, grading = np.floor(SHARE_IN_JET * rings) / rings, FINE_GRADING
        outside = np.clip((rho - inner) / (1.0 - inner), 0.0, 1.0)
    else:
        inner = (rings - 1.5) / rings
        grading, last = (pair[int(rings > 3)] for pair in (GRADING, LAST_RING))
        outside = np.interp(rho, [inner, 1.0 - 1.0 / rings, 1.0], [0.0, last, 1.0])
    jet_share = np.minimum(jet_share, LARGEST_JET_SHARE)[:, None]
    x = np.minimum(rho / inner, 1.0)
    return jet_share * x * (1.0 + grading * (1.0 - x)) + (1.0 - jet_share) * outside


def build(sections, disc, jet_share):
    """Lattice of `disc` in `sections` at 2 K + 1 levels, of which every second one is a station.

    jet_share (2 K + 1,): radius of the jet over the vessel's at each level, 1 without a jet. Returns None if a section
    is not ok (`Sections.radii`).
    """
    rays = len(disc.rim)
    angles = np.pi * np.arange(2 * rays) / rays
    radius, ok, facets, normals_at_wall = sections.radii(angles)
    if not ok.all():
        return None
    place = _DiscPlacement(sections, radius, angles, disc.rings, jet_share)
    vertices = place(disc.vertices)
    middles = place(disc.middles)
    per_level, stations = len(disc.vertices), (len(radius) + 1) // 2
    points = vertices[::2].reshape(-1, 3)
    edges, middle = _edges(disc, vertices, middles, points)
    level = per_level * np.arange(stations - 1)[:, None, None]
    i, j, k = np.sort(disc.triangles, axis=1).T
    up = per_level
    # The diagonal of a prism's side runs from the smaller vertex number at the lower station to the larger one at the
    # upper station. So neighbouring prisms cut their common side in the same way.
    split = [[i, j, k, k + up], [i, j, j + up, k + up], [i, i + up, j + up, k + up]]
    tetrahedra = np.concatenate([(level + np.stack(four, axis=1)).reshape(-1, 4) for four in split])
    a, b = disc.rim, np.roll(disc.rim, -1)
    low, high = np.minimum(a, b), np.maximum(a, b)
    ordered = a < b
    wall = [
        np.where(ordered[:, None], np.stack([low, high, high + up], 1), np.stack([high, low, high + up], 1)),
        np.where(ordered[:, None], np.stack([low, high + up, low + up], 1), np.stack([high + up, low, low + up], 1)),
    ]
    wall = np.concatenate([(level + side).reshape(-1, 3) for side in wall])
    last = per_level * (stations - 1)
    normals = np.zeros_like(points)
    normals[disc.rim], normals[last + disc.rim] = normals_at_wall[0, ::2], normals_at_wall[-1, ::2]
    return Lattice(
        points,
        tetrahedra,
        edges,
        middle,
        wall,
        (disc.triangles[:, ::-1], last + disc.triangles),
        (disc.rim, last + disc.rim),
        normals,
        np.unique(facets[1:-1]),
    )


def inverted_gaps(lattice, disc):
    """Numbers (k,) of the gaps between stations in which a tetrahedron is inverted and overlaps its neighbours.

    A tetrahedron is inverted if its volume has another sign than in the lattice of a straight tube.
    """
    rho, angle = disc.vertices.T
    per_level, stations = len(rho), len(lattice.points) // len(rho)
    plane = rho[:, None] * np.stack(cosines_and_sines(angle), axis=1)
    height = np.repeat(np.arange(stations, dtype=float), per_level)[:, None]
    straight = np.concatenate([np.tile(plane, (stations, 1)), height], axis=1)
    signs = [np.sign(tet10.six_volumes(points, lattice.tetrahedra)) for points in (straight, lattice.points)]
    wrong = lattice.tetrahedra[signs[0] != signs[1]]
    return np.unique(wrong.min(axis=1) // per_level)


class _DiscPlacement:
    """Places points of the disc in all sections: (rho, angle) (n, 2) -> points (m, n, 3) in mm."""

    def __init__(self, sections, radius, angles, rings, jet_share):
        self.rings, self.jet_share = rings, np.asarray(jet_share)
        self.centres, self.e1, self.e2 = sections.centres, sections.e1, sections.e2
        self.radius, self.step = radius, angles[1]

    def __call__(self, polar):
        rho, angle = polar[:, 0], polar[:, 1] % (2 * np.pi)
        place = angle / self.step
        low = np.floor(place + 1e-9).astype(int)
        share = np.maximum(place - low, 0.0)
        count = self.radius.shape[1]
        radius = (1 - share) * self.radius[:, low % count] + share * self.radius[:, (low + 1) % count]
        rho = ring_radii(rho, self.rings, self.jet_share)
        x, y = (rho * radius * part for part in cosines_and_sines(angle))
        return self.centres[:, None] + x[..., None] * self.e1[:, None] + y[..., None] * self.e2[:, None]


def _edges(disc, vertices, middles, points):
    """(edges (e, 2), middle points (e, 3) in mm) of the lattice: in the discs, along the axis, and diagonal.

    vertices, middles: the disc's vertices and edge middles placed at all levels; points (n, 3): vertices at stations.
    """
    per_level, stations = len(disc.vertices), len(vertices[::2])
    all_levels = per_level * np.arange(stations)[:, None]
    lower = all_levels[:-1]
    a, b = disc.edges[:, 0], disc.edges[:, 1]
    n = np.arange(per_level)
    rho_vertex, rho_edge = disc.vertices[:, 0], disc.middles[:, 0]
    groups = [
        (all_levels + a, all_levels + b, middles[::2], rho_edge),
        (lower + n, lower + n + per_level, vertices[1::2], rho_vertex),
        (lower + a, lower + b + per_level, middles[1::2], rho_edge),
    ]
    edges, found = [], []
    for start, end, lattice, rho in groups:
        straight = 0.5 * (points[start] + points[end])
        share = np.prod([rho] * CURVING_EXPONENT, axis=0)[None, :, None]
        edges.append(np.stack([start, end], axis=-1).reshape(-1, 2))
        found.append((straight + share * (lattice - straight)).reshape(-1, 3))
    return np.concatenate(edges), np.concatenate(found)
