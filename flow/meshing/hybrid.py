"""Conforming volume mesh of a tree: swept lattices along its vessels, Delaunay tetrahedra in its junctions.

A span is a swept stretch of a branch (meshing.sweep.span_sweep), a junction the lumen between spans. The spans are
swept first. The wall between them is then joined to their end rings (meshing.sweep.stitch). This wall and the spans'
end discs enclose the junctions, which gmsh fills. Where a junction cannot be closed, filled, or filled without slivers,
the ends of its spans move into the spans, so that the junction gets larger.
"""

import dataclasses
import sys

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from common.errors import ComputationError
from flow.geometry import smooth_surface, tet10
from flow.meshing import volume_mesh
from flow.geometry.surface import WALL, Surface
from flow.meshing.sweep import disc as disc_module
from flow.meshing.sweep import section, span_sweep, stitch

MOVE_RADII = 0.25  # radii by which the ends of spans move in if their junction cannot be filled
MOST_TRIES = 12  # most attempts to fill all junctions; between attempts, ends of spans move
FIRST_DISC_REGION = 1000  # region ids of the spans' end discs start here while a junction is filled


@dataclasses.dataclass
class LinearMesh:
    """A conforming mesh of linear tetrahedra of positive volume.

    points (n, 3) in mm; tetrahedra (t, 4); swept (t,) bool: whether a tetrahedron belongs to a span; boundary (f, 3):
    triangles of wall and caps with the region ids region (f,); edges (e, 2) with known middle points middles (e, 3) in
    mm; spans [{branch, from_mm, to_mm, stations}]; moved_ends [str]: which ends of spans moved, and why.
    """

    points: np.ndarray
    tetrahedra: np.ndarray
    swept: np.ndarray
    boundary: np.ndarray
    region: np.ndarray
    edges: np.ndarray
    middles: np.ndarray
    spans: list
    moved_ends: list


class NoSpans(Exception):
    """No stretch of the tree can be swept, or the junctions between the swept stretches cannot be filled."""


def build(surface, tree, sizes, settings, rings, coarsening=1.0):
    """LinearMesh of a Surface with its Tree.

    sizes: size_field.SizeField of the junctions; rings: number of rings of the swept disc; coarsening: factor of the
    distance between stations. Raises NoSpans if no span is found, or if after MOST_TRIES attempts a junction still
    cannot be filled.
    """
    slicer = section.Slicer(surface)
    disc = disc_module.make(rings, settings.wall_layers)
    spans = span_sweep.find_spans(surface, tree, slicer, disc)
    moved_ends = []
    for _ in range(MOST_TRIES):
        for span in spans:
            if span.lattice is None:
                span_sweep.sweep_span(span, slicer, disc, settings, coarsening)
        spans = [span for span in spans if span.lattice is not None]
        if not spans:
            raise NoSpans("no stretch between branches is long, round and even enough")
        try:
            return _assemble(surface, slicer, spans, sizes, moved_ends)
        except stitch.StitchError as error:
            places = ", ".join(
                f"{spans[n].axis.branch.name} {spans[n].s_at_end(k):.1f} mm" for n, k in sorted(error.ends)
            )
            moved_ends.append(f"{places}: {error}")
            print(f"ends of swept stretches move: {moved_ends[-1]}", file=sys.stderr, flush=True)
            spans = span_sweep.shorten_spans(spans, error.ends, MOVE_RADII)
    raise NoSpans(f"junctions could not be filled wherever the swept stretches end: {moved_ends[-1]}")


def _assemble(surface, slicer, spans, sizes, moved_ends):
    """LinearMesh of the spans and the junctions between them. Raises StitchError."""
    parts = _MeshBuilder(surface, slicer.normals)
    ends, cuts = [], []
    for number, span in enumerate(spans):
        offset = parts.add_span(span)
        span_ends = []
        for which in (0, 1):
            if span.caps[which] is None:
                span_ends.append(_span_end(number, which, span, offset))
        ends += span_ends
        cuts.append(SpanCut(span_ends, [cap for cap in span.caps if cap is not None], span.lattice.wall_facets))
    replaced = stitch.replaced_facets(surface, slicer.side, cuts)
    swept_caps = [cap for cut in cuts for cap in cut.caps]
    replaced |= np.isin(surface.region, swept_caps)
    replaced = stitch.trim_ears(surface, replaced, surface.region == WALL)
    kept = np.flatnonzero(~replaced)
    if ends:
        parts.add_junctions(kept, ends, spans, sizes)
    elif len(kept):
        raise stitch.StitchError("wall is left over", [])
    return parts.to_linear_mesh(spans, moved_ends)


@dataclasses.dataclass
class SpanCut:
    """The part of the surface that a span replaces.

    ends: [stitch.SpanEnd] of the span; caps: region ids of its caps; wall_facets: numbers of the facets on which the
    span's wall points lie.
    """

    ends: list
    caps: list
    wall_facets: np.ndarray


def _span_end(number, which, span, offset):
    """stitch.SpanEnd at the first (which = 0) or last (1) end of a span.

    number: the span's number; offset: number of the span's first point in the whole mesh.
    """
    rim, level, along = span.lattice.rims[which], -which, (-1, 1)[which]
    centre, outwards = span.sections.sections[level].centre, along * span.sections.normals[level]
    radius = float(np.linalg.norm(span.lattice.points[rim] - centre, axis=1).max())
    return stitch.SpanEnd((number, which), centre, outwards, radius, offset + rim)


class _MeshBuilder:
    """Collects points, tetrahedra and boundary of the mesh, span by span and junction by junction.

    The surface's vertices are the first points. Those that no tetrahedron uses are dropped at the end. normals: unit
    normals of the smooth surface at the points, zero where they are not needed.
    """

    def __init__(self, surface, normals):
        self.surface, self.points, self.normals = surface, [surface.points], [normals]
        self.count = len(surface.points)
        self.tetrahedra, self.swept, self.boundary, self.region = [], [], [], []
        self.edges, self.middles = [], []

    def add_points(self, points, normals=None):
        """Adds points (n, 3) and returns the number of the first."""
        first = self.count
        self.points.append(points)
        self.normals.append(np.zeros_like(points) if normals is None else normals)
        self.count += len(points)
        return first

    def add_boundary(self, triangles, region):
        """Adds boundary triangles (m, 3) with their region id, or ids (m,)."""
        self.boundary.append(triangles)
        self.region.append(np.broadcast_to(region, len(triangles)))

    def add_span(self, span):
        """Adds a span's lattice and returns the number of its first point."""
        lat = span.lattice
        offset = self.add_points(lat.points, lat.normals)
        self.tetrahedra.append(offset + lat.tetrahedra)
        self.swept.append(np.ones(len(lat.tetrahedra), bool))
        self.edges.append(offset + lat.edges)
        self.middles.append(lat.middles)
        self.add_boundary(offset + lat.wall, WALL)
        for cap, faces in zip(span.caps, lat.discs):
            if cap is not None:
                self.add_boundary(offset + faces, cap)
        span.offset = offset
        return offset

    def add_junctions(self, kept, ends, spans, sizes):
        """Closes and fills every junction, each one a connected piece of the remaining wall. Raises StitchError.

        kept: numbers of the remaining facets; ends: [stitch.SpanEnd]; spans: [Span]; sizes: size_field.SizeField.
        """
        triangles, region = self.surface.triangles[kept], self.surface.region[kept]
        points, normals = np.concatenate(self.points), np.concatenate(self.normals)
        strip_of = stitch.build_strips(points, normals, triangles, ends)
        faces, tags = [triangles], [region]
        for key, strip in strip_of.items():
            span, which = spans[key[0]], key[1]
            disc_faces = span.lattice.discs[which][:, ::-1]
            faces += [strip, span.offset + disc_faces]
            number = FIRST_DISC_REGION + 2 * key[0] + which
            tags += [np.full(len(strip), WALL), np.full(len(disc_faces), number)]
        faces, tags = np.concatenate(faces), np.concatenate(tags)
        failed = []
        for piece in _connected_pieces(faces):
            try:
                self._fill_junction(points, normals, faces[piece], tags[piece], sizes)
            except stitch.StitchError as error:  # the other pieces are tried before any end moves
                failed.append(error)
        if failed:
            raise stitch.StitchError("; ".join(map(str, failed)), [key for error in failed for key in error.ends])

    def _fill_junction(self, points, normals, faces, tags, sizes):
        """Fills one junction, enclosed by triangles `faces` (m, 3) with region ids `tags` (m,). Raises StitchError."""
        used, local = np.unique(faces, return_inverse=True)
        closed = Surface(points[used], local.reshape(-1, 3), tags)
        edges, side = closed.edges()
        keys = [
            (int(tag - FIRST_DISC_REGION) // 2, int(tag - FIRST_DISC_REGION) % 2)
            for tag in closed.caps
            if tag >= FIRST_DISC_REGION
        ]
        if np.any(np.bincount(side.ravel()) != 2):
            raise stitch.StitchError("a junction is not closed", keys)
        if closed.volume_mm3() <= 0:
            raise stitch.StitchError("a junction is inside out", keys)
        try:
            filled, tetrahedra = volume_mesh.fill(closed, sizes)
        except ComputationError as error:
            raise stitch.StitchError(f"{error.what}, {error.value}", keys) from error
        first = self.add_points(filled[len(used) :])
        number = np.concatenate([used, first + np.arange(len(filled) - len(used))])
        self.tetrahedra.append(number[tetrahedra])
        self.swept.append(np.zeros(len(tetrahedra), bool))
        outer = tags < FIRST_DISC_REGION
        self.add_boundary(faces[outer], tags[outer])
        # the middles of the end discs' edges, rims included, are known from the lattice
        on_wall, _ = smooth_surface.edge_kinds(closed, edges, side)
        shared = np.zeros(len(edges), bool)
        shared[side[~outer].ravel()] = True
        chosen = on_wall & ~shared
        self.edges.append(used[edges[chosen]])
        self.middles.append(smooth_surface.edge_middles(closed, edges, side, normals[used])[chosen])

    def to_linear_mesh(self, spans, moved_ends):
        """The LinearMesh of all that was added, without unused points."""
        points, tetrahedra = np.concatenate(self.points), np.concatenate(self.tetrahedra)
        used, local = np.unique(tetrahedra, return_inverse=True)
        number = np.full(len(points), -1)
        number[used] = np.arange(len(used))
        spans_report = [
            {
                "branch": span.axis.branch.name,
                "from_mm": span.start_mm,
                "to_mm": span.end_mm,
                "stations": span.stations,
            }
            for span in spans
        ]
        return LinearMesh(
            points[used],
            tet10.orient_positive(points[used], local.reshape(-1, 4)),
            np.concatenate(self.swept),
            number[np.concatenate(self.boundary)],
            np.concatenate(self.region),
            number[np.concatenate(self.edges)],
            np.concatenate(self.middles),
            spans_report,
            moved_ends,
        )


def _connected_pieces(faces):
    """[numbers of the faces] for each connected piece of the triangles `faces` (m, 3)."""
    size = int(faces.max()) + 1
    links = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    _, label = connected_components(coo_matrix((np.ones(len(links)), links.T), (size, size)), directed=False)
    of_face = label[faces[:, 0]]
    return [np.flatnonzero(of_face == piece) for piece in np.unique(of_face)]
