"""One span as tetrahedra: the disc on every station and halfway between, prisms split by the smallest vertex.

The disc's point (rho, angle) goes to centre + m(rho) r(angle) in the plane of each section, where r is the radius of
the smooth surface. m makes the rings narrow at the edge of the jet behind a narrowing (`rings_at`). In the throat, and
without a jet, this edge is the wall. Middle points of edges lie on the same lattice at twice the resolution. Towards
the axis they approach the straight edges' middles, so that the wall is curved and the core is not.
"""

import dataclasses

import numpy as np

from flow.geometry import tet10
from flow.geometry.vectors import circle
from flow.meshing.sweep import axis as axis_module

REACH = 2.5  # radii of the branch within which a section's wall is looked for
LARGEST_ASPECT = 3.0  # largest over smallest radius of a section
# The next three are for rings_at. LARGEST_EDGE limits the jet's radius over the vessel's. GRADING and LAST have one
# value for up to three rings and one for four. They were fitted to the error of FFR at a stenosis of 62 %: -.0002 with
# three rings (-.0005 with the second values), +.0007 with four (+.0010 with a LAST of 1 / 3).
LARGEST_EDGE = 0.82
GRADING, LAST = (0.3, 0.5), (1 / 3, 1 / 2)
# More than 4 are laid alike, so that meshes become finer everywhere: with as many outside the jet as 4 rings have, 6
# had +.0003 instead of +.0001 and 10 left every tenth curved edge straight.
FITTED, INSIDE, FINE_GRADING = 4, 2 / 3, 0.3
FULLNESS = 3  # power of rho with which edges follow the lattice


@dataclasses.dataclass
class Lattice:
    """A span's linear tetrahedra with the middles of all its edges; vertex numbers are the span's own.

    points (n, 3); tetrahedra (t, 4); edges (e, 2), middles (e, 3); wall (f, 3) triangles outwards; discs: triangles
    (d, 3) outwards of the first end and of the last; rims: vertices (r,) of these in order of angle;
    normals (n, 3): of the smooth surface at the wall's vertices of the two end discs, else zero; owners: facets hit.
    """

    points: np.ndarray
    tetrahedra: np.ndarray
    edges: np.ndarray
    middles: np.ndarray
    wall: np.ndarray
    discs: tuple
    rims: tuple
    normals: np.ndarray
    owners: np.ndarray


class Sections:
    """Sections at levels s_mm (m,) of an axis: centres (m, 3), frames, and radius by angle."""

    def __init__(self, slicer, axis, s_mm, caps=(None, None)):
        origins, normals = axis.planes(s_mm)
        e1, e2 = axis_module.frames(origins, normals)
        self.s_mm, self.normals, self.e1, self.e2 = s_mm, normals, e1, e2
        self.sections = []
        for k, (origin, normal) in enumerate(zip(origins, normals)):
            cap = caps[0] if k == 0 else caps[1] if k == len(s_mm) - 1 else None
            if cap is not None:
                found = slicer.rim(cap, origin, normal, e1[k], e2[k])
            else:
                found = slicer.cut(origin, normal, e1[k], e2[k], REACH * axis.radius(s_mm[k]))
            self.sections.append(found)

    def radii(self, angles):
        """(radius (m, k), ok (m,) bool, facets (m, k), normals (m, k, 3)); rows that are not ok are zero."""
        shape = (len(self.sections), len(angles))
        radius, facets, facing = np.zeros(shape), np.full(shape, -1), np.zeros(shape + (3,))
        ok = np.zeros(shape[0], bool)
        for k, section in enumerate(self.sections):
            found = section.radii(angles) if section is not None else None
            if found is not None:
                radius[k], facets[k], facing[k] = found
                ok[k] = radius[k].max() <= LARGEST_ASPECT * radius[k].min()
        return radius, ok, facets, facing

    @property
    def centres(self):
        return np.array([section.centre for section in self.sections])


def rings_at(rho, rings, edge):
    """m (m, n): radii at template radii rho (n,). edge (m,): the jet's radius over the vessel's.

    `edge` is limited to LARGEST_EDGE. Up to FITTED rings all but the outer one and a half lie within it, and get
    narrower towards it by GRADING. The last ring but one lies at the share LAST of the way from there to the wall. Of
    more rings two thirds lie within `edge`; the others are equally wide.
    """
    if rings > FITTED:
        inner, grading = np.floor(INSIDE * rings) / rings, FINE_GRADING
        outside = np.clip((rho - inner) / (1.0 - inner), 0.0, 1.0)
    else:
        inner = (rings - 1.5) / rings
        grading, last = (pair[int(rings > 3)] for pair in (GRADING, LAST))
        outside = np.interp(rho, [inner, 1.0 - 1.0 / rings, 1.0], [0.0, last, 1.0])
    edge = np.minimum(edge, LARGEST_EDGE)[:, None]
    x = np.minimum(rho / inner, 1.0)
    return edge * x * (1.0 + grading * (1.0 - x)) + (1.0 - edge) * outside


def build(sections, disc, edge):
    """Lattice from sections at 2 K + 1 levels (every second one a station), or None where one is not star-shaped.

    edge (2 K + 1,): radius of the jet over the vessel's at each level, 1 where there is none.
    """
    rays = len(disc.rim)
    angles = np.pi * np.arange(2 * rays) / rays
    radius, ok, facets, facing = sections.radii(angles)
    if not ok.all():
        return None
    around = _Positions(sections, radius, angles, disc.rings, edge)
    vertices = around(disc.vertices)
    middles = around(disc.middles)
    per_level, stations = len(disc.vertices), (len(radius) + 1) // 2
    points = vertices[::2].reshape(-1, 3)
    edges, middle = _edges(disc, vertices, middles, points)
    level = per_level * np.arange(stations - 1)[:, None, None]
    i, j, k = np.sort(disc.triangles, axis=1).T
    up = per_level
    # smallest vertex first: every quadrilateral side is cut from its smaller vertex below to the larger above
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
    normals[disc.rim], normals[last + disc.rim] = facing[0, ::2], facing[-1, ::2]
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


def turned_over(lattice, disc):
    """Numbers (k,) of the gaps between stations with a tetrahedron that is turned over against a straight tube's.

    Such a tetrahedron overlaps its neighbours.
    """
    rho, angle = disc.vertices.T
    per_level, stations = len(rho), len(lattice.points) // len(rho)
    plane = rho[:, None] * np.stack(circle(angle), axis=1)
    height = np.repeat(np.arange(stations, dtype=float), per_level)[:, None]
    straight = np.concatenate([np.tile(plane, (stations, 1)), height], axis=1)
    signs = [np.sign(tet10.six_volumes(points, lattice.tetrahedra)) for points in (straight, lattice.points)]
    wrong = lattice.tetrahedra[signs[0] != signs[1]]
    return np.unique(wrong.min(axis=1) // per_level)


class _Positions:
    """Points of the lattice at all levels: (rho, angle) (n, 2) -> (m, n, 3)."""

    def __init__(self, sections, radius, angles, rings, edge):
        self.rings, self.edge = rings, np.asarray(edge)
        self.centres, self.e1, self.e2 = sections.centres, sections.e1, sections.e2
        self.radius, self.step = radius, angles[1]

    def __call__(self, polar):
        rho, angle = polar[:, 0], polar[:, 1] % (2 * np.pi)
        place = angle / self.step
        low = np.floor(place + 1e-9).astype(int)
        share = np.maximum(place - low, 0.0)
        count = self.radius.shape[1]
        radius = (1 - share) * self.radius[:, low % count] + share * self.radius[:, (low + 1) % count]
        rho = rings_at(rho, self.rings, self.edge)
        x, y = (rho * radius * part for part in circle(angle))
        return self.centres[:, None] + x[..., None] * self.e1[:, None] + y[..., None] * self.e2[:, None]


def _edges(disc, vertices, middles, points):
    """All edges of the split lattice and their middle points: in the discs, along the axis, and diagonal."""
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
        share = np.prod([rho] * FULLNESS, axis=0)[None, :, None]
        edges.append(np.stack([start, end], axis=-1).reshape(-1, 2))
        found.append((straight + share * (lattice - straight)).reshape(-1, 3))
    return np.concatenate(edges), np.concatenate(found)
