"""Swept meshes: volume, conformity, tags and smooth wall of tubes, and the junctions of a tree."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

import tubes
from common.errors import ComputationError
from flow import settings
from flow.geometry import centreline, curving, tet10
from flow.meshing import hybrid, mesh, volume_mesh
from flow.meshing.sweep import disc, lattice, section, spans, stations, stitch


def _volume(quadratic):
    """Volume in mm3. det J is cubic in a cell, so the mean of its Bezier coefficients is the exact mean of det J."""
    jacobian = np.einsum("tnx,pnr->tpxr", quadratic.points[quadratic.tetrahedra], tet10.gradients(tet10._POINTS))
    return (np.linalg.det(jacobian) @ tet10._TO_BEZIER.T).mean(axis=1).sum() / 6.0


def _faces(tetrahedra):
    """(faces by their corners, number of cells that share each) of all cells."""
    sides = np.concatenate([tetrahedra[:, k] for k in ([0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3])])
    return np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)


def _assert_conforming(quadratic):
    faces, shared = _faces(quadratic.tetrahedra[:, :4])
    assert shared.max() == 2
    border = {tuple(face) for face in faces[shared == 1]}
    assert border == {tuple(face) for face in np.sort(quadratic.triangles[:, :3], axis=1)}
    # Each middle node belongs to one edge, and each edge has one middle node. So neighbours agree on their curved face.
    edges = quadratic.tetrahedra[:, :4][:, tet10.EDGES].reshape(-1, 2)
    middles = quadratic.tetrahedra[:, 4:].ravel()
    pairs = np.unique(np.column_stack([np.sort(edges, axis=1), middles]), axis=0)
    assert len(pairs) == len(np.unique(middles)) == len(np.unique(pairs[:, :2], axis=0))


UNEXTENDED_SETTINGS = settings.make(**tubes.NO_EXTENSIONS)
# (radius, axis, length, tolerance of the volume). The surface has edges of 0.4 mm, a third of the narrowest diameter.
CASES = {
    "straight": (lambda s: 1.6 + 0 * np.asarray(s, float), None, 12, 2e-5),
    "lesion": (tubes.lesion(1.5, 0.6, 8, 8), None, 16, 3e-4),
    "bent": (tubes.lesion(1.5, 0.4, 8, 8), tubes.arc(0.15), 16, 3e-4),
}


@pytest.mark.parametrize("name", CASES)
def test_a_tube_is_one_span_of_exact_volume(name):
    radius, axis, length, tolerance = CASES[name]
    tree = centreline.Tree([tubes.centre_branch(length, radius, axis)])
    quadratic, report = mesh.build(tubes.tube(length, radius, 0.4, axis), tree, 2.0, UNEXTENDED_SETTINGS)
    assert [(span["from_mm"], span["branch"]) for span in report["swept"]["spans"]] == [(0.0, "main")]
    assert report["swept"]["cells"] == report["cells"] and report["quality"]["gamma_min"] is None
    s = np.linspace(0, length, 4001)
    assert _volume(quadratic) == pytest.approx(trapezoid(np.pi * radius(s) ** 2, s), rel=tolerance)
    assert report["quality"]["jacobian_ratio_min_swept"] > 0.4 and report["quality"]["straightened_edges"] == 0
    _assert_conforming(quadratic)


def test_stations_come_closer_where_cells_would_be_turned_over():
    """The wall has a pouch on one side, as in lumens from CT, shorter than a plain vessel's gap between stations."""

    def pouched(depth):
        def axis(s, e1, e2):
            out = depth * np.exp(-(((s - 8) / 1.2) ** 2)) * (np.maximum(e1, 0) / 1.5) ** 2
            return np.stack([s, e1 + out, e2], axis=-1)

        return tubes.tube(16, lambda s: 1.5 + 0 * np.asarray(s, float), 0.3, axis)

    tree = centreline.Tree([tubes.centre_branch(16, lambda s: 1.5)])
    gentle, deep = (mesh.build(pouched(depth), tree, 2.0, UNEXTENDED_SETTINGS) for depth in (0.3, 1.4))
    (before,), (after,) = (report["swept"]["spans"] for _, report in (gentle, deep))
    assert before["stations"] < after["stations"] <= before["stations"] + 4
    assert tet10.count_overlapping(deep[0].tetrahedra[:, :4]) == 0
    _assert_conforming(deep[0])


def test_wall_nodes_lie_on_the_smooth_wall():
    radius, length = CASES["lesion"][0], 16
    tree = centreline.Tree([tubes.centre_branch(length, radius)])
    surface = tubes.tube(length, radius, 0.4)
    quadratic, _ = mesh.build(surface, tree, 2.0, UNEXTENDED_SETTINGS)
    wall = quadratic.points[np.unique(quadratic.triangles[quadratic.region == 0])]
    off = np.hypot(wall[:, 1], wall[:, 2]) - radius(wall[:, 0])
    facets = surface.points[surface.triangles[surface.region == 0]].mean(axis=1)
    chord = np.hypot(facets[:, 1], facets[:, 2]) - radius(facets[:, 0])
    assert np.abs(off).max() < 2e-3 < 10e-3 < np.abs(chord).max()


@pytest.fixture(scope="module")
def forked(tmp_path_factory):
    """(surface, mesh, report) of a main tube with one side tube."""
    surface, branches = tubes.fork()
    quadratic, report = mesh.build(surface, centreline.Tree(branches), 2.0, settings.make())
    return surface, quadratic, report


def test_a_fork_is_swept_around_a_junction(forked):
    surface, quadratic, report = forked
    swept = report["swept"]
    assert sorted(span["branch"] for span in swept["spans"]) == ["main", "main", "side1"]
    assert 0 < swept["cells"] < report["cells"] and "reason" not in swept
    _assert_conforming(quadratic)
    assert sorted(set(quadratic.region.tolist())) == [0, 1, 2, 3]
    assert _volume(quadratic) == pytest.approx(surface.volume_mm3(), rel=0.03)
    assert report["quality"]["gamma_min"] > 0.05 and report["quality"]["jacobian_ratio_min"] > 0.05


def test_an_end_that_cannot_be_stitched_moves_or_the_mesh_is_of_one_size(monkeypatch, forked):
    surface, branches = tubes.fork()
    tree = centreline.Tree(branches)
    moved = []

    def fails_at_first(points, normals, kept, ends, real=stitch.build_strips):
        if not moved:
            moved.append(ends[0].key)
            raise stitch.StitchError("made to fail", [ends[0].key])
        return real(points, normals, kept, ends)

    with monkeypatch.context() as patch:
        patch.setattr(stitch, "build_strips", fails_at_first)
        _, report = mesh.build(surface, tree, 2.0, settings.make())
    first, second = (found["swept"]["spans"][0] for found in (forked[2], report))
    assert second["to_mm"] == pytest.approx(first["to_mm"] - hybrid.MOVE_RADII * 1.5, abs=0.02)
    assert len(report["swept"]["moved"]) == 1 and "made to fail" in report["swept"]["moved"][0]

    def always_fails(points, normals, kept, ends):
        raise stitch.StitchError("made to fail", [end.key for end in ends])

    with monkeypatch.context() as patch:
        patch.setattr(stitch, "build_strips", always_fails)
        _, report = mesh.build(surface, tree, 2.0, settings.make())
    assert report["swept"]["cells"] == 0 and report["swept"]["reason"]


def test_a_junction_that_cannot_be_filled_moves_its_ends(monkeypatch, forked):
    """Only the ends of its own spans move, after all junctions were tried. `mesh.json` says which and why."""
    surface, branches = tubes.fork()
    calls = []

    def fails_at_first(junction, sizes, real=volume_mesh.fill):
        calls.append(junction)
        if len(calls) == 1:
            raise ComputationError("gmsh left a sliver", "junction", "gamma 0.001", "made on purpose")
        return real(junction, sizes)

    monkeypatch.setattr(volume_mesh, "fill", fails_at_first)
    _, report = mesh.build(surface, centreline.Tree(branches), 2.0, settings.make())
    assert len(calls) == 2 and report["swept"]["way"] == "swept" and "reason" not in report["swept"]
    (moved,) = report["swept"]["moved"]
    assert "a sliver, gamma 0.001" in moved and moved.count("main") == 2 and moved.count("side1") == 1
    first, second = (found["swept"]["spans"][0] for found in (forked[2], report))
    assert second["to_mm"] == pytest.approx(first["to_mm"] - hybrid.MOVE_RADII * 1.5, abs=0.02)


@pytest.mark.parametrize(("layers", "triangles"), [(1, 96), (2, 144), (3, 192)])
def test_disc_is_triangulated_without_overlap(layers, triangles):
    found = disc.make(4, layers)
    x = found.vertices[:, 0] * np.array([np.cos(found.vertices[:, 1]), np.sin(found.vertices[:, 1])])
    a, b, c = (x[:, found.triangles[:, k]] for k in range(3))
    area = 0.5 * ((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0])
    assert len(found.rim) == 24 and len(found.triangles) == triangles and area.min() > 0
    assert area.sum() == pytest.approx(0.5 * 24 * np.sin(2 * np.pi / 24))


def test_boundary_layers_halve_towards_the_wall():
    found = disc.make(3, 3)
    radii = np.unique(found.vertices[:, 0].round(12))
    assert np.diff(radii[-4:]) == pytest.approx(np.array([4, 2, 1]) / 7 / 3)
    assert (found.vertices[found.rim, 0] == 1).all()
    assert found.vertices[found.rim, 1] == pytest.approx(disc.make(3).vertices[-18:, 1])  # the wall's vertices stay


def test_rings_gather_at_the_edge_of_the_jet():
    rho = np.linspace(0, 1, 41)
    wide, narrow = lattice.ring_radii(rho, 4, np.array([1.0, 0.4]))
    for found in (wide, narrow):
        assert found[0] == 0 and found[-1] == pytest.approx(1) and (np.diff(found) > 0).all()
    assert narrow[25] == pytest.approx(0.4)  # two and a half of the four rings lie within the jet
    assert narrow[30] == pytest.approx(0.4 + 0.5 * 0.6)  # the third ring ends halfway from there to the wall
    widths = np.diff(wide[::10])
    assert (widths[1:] / widths[:-1] < 0.7).all()  # rings are narrower towards the wall


@pytest.mark.parametrize("rings", [6, 8, 9])
def test_many_rings_become_narrower_everywhere(rings):
    """Two thirds of the rings lie in the jet. With twice as many rings all are about half as wide. The nodes between
    two rings lie about halfway."""
    edge = np.array([1.0, 0.4])
    found = lattice.ring_radii(np.linspace(0, 1, 2 * rings + 1), rings, edge)
    inside = int(np.floor(2 * rings / 3))
    assert found[:, 2 * inside] == pytest.approx(np.minimum(edge, lattice.LARGEST_JET_SHARE))
    widths = np.diff(found[:, ::2], axis=1)
    finer = np.diff(lattice.ring_radii(np.linspace(0, 1, 2 * rings + 1), 2 * rings, edge), axis=1)
    assert finer.max() < 0.55 * widths.max()
    shares = np.diff(found, axis=1)[:, ::2] / widths
    assert (np.abs(shares - 0.5) < 0.05).all()


def test_stations_are_close_at_the_throat_only():
    branch = tubes.centre_branch(50, tubes.lesion(1.6, 0.6, 25, 10))
    given = settings.make()
    gap = np.diff(stations.place_stations(branch, given, 0.0, 50.0))
    assert gap.min() == pytest.approx(given.stations_throat * 0.64, rel=0.1)
    assert gap[0] == pytest.approx(given.stations_plain * 1.6, rel=0.1)
    ratio = gap[1:] / gap[:-1]
    assert ratio.max() < 1.15
    plain = np.diff(stations.place_stations(tubes.centre_branch(50, lambda s: 1.6), given, 0.0, 50.0))
    assert len(plain) < 0.6 * len(gap)


def test_a_section_is_refused_where_it_is_not_star_shaped():
    tube = tubes.tube(10, lambda s: 1.5, 0.4)
    found = section.Slicer(tube).cut_section(np.array([5.0, 0, 0]), np.eye(3)[0], np.eye(3)[1], np.eye(3)[2], 4.0)
    radius, _, normals = found.radii(np.linspace(0.1, 6, 20))
    assert np.abs(radius - 1.5).max() < 1e-3 and np.abs(normals[:, 0]).max() < 0.05
    angles = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    chain = np.stack([np.cos(angles), np.sin(angles)], axis=1) * (1 + 2.5 * (np.abs(angles - 2) < 0.3))[:, None]
    chain[(np.abs(angles - 2.5) < 0.2)] *= 0.2
    chain[:, 0] += 0.9 * chain[:, 1] ** 3
    found.segments = np.stack([chain, np.roll(chain, -1, axis=0)], axis=1)
    assert found.radii(angles + 0.01) is None


def test_spans_keep_clear_of_a_side_branch():
    surface, branches = tubes.fork()
    tree = centreline.Tree(branches)
    axis = spans.branch_axes(surface, tree)["main"]
    s = np.linspace(0, axis.length_mm, 200)
    blocked = s[~spans.clear_of_others(axis, tree, s)]
    where = tree.main.project(branches[1].points[0])[0]
    assert blocked.min() < where < blocked.max() and blocked.max() - blocked.min() < 5.0
    assert axis.cap_ids == (1, 2) and spans.branch_axes(surface, tree)["side1"].cap_ids == (None, 3)


def test_ends_move_where_the_cuts_of_two_side_branches_leave_no_wall():
    """The parent is wider than its centreline says, as an oval lumen is. So the planes of the side branches' ends graze
    its wall, and each cut would run along this wall up to the other cut.
    """
    surface, branches = tubes.branched(1.5, 24.0, [(8.0, 0.6, 8.0, 70.0, 0.0), (16.0, 0.6, 8.0, 70.0, 180.0)], 0.4)
    branches[0].radius_mm *= 0.85
    tree = centreline.Tree(branches)
    quadratic, report = mesh.build(surface, tree, 2.0, UNEXTENDED_SETTINGS, rings=2, coarsening=2.0)
    swept = report["swept"]
    assert len(swept["spans"]) == 5 and "a cut runs on" in swept["moved"][0] and "reason" not in swept
    _assert_conforming(quadratic)
    assert _volume(quadratic) == pytest.approx(surface.volume_mm3(), rel=0.03)
    assert report["quality"]["gamma_min"] > 0.05 and report["quality"]["jacobian_ratio_min"] > 0.05


@pytest.mark.parametrize("left", ["nothing", "all"])
def test_wall_without_a_border_cannot_be_stitched(left):
    """All facets were replaced, or none: in both cases there is no border loop to join the spans' ends to."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    closed = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    ends = [stitch.SpanEnd((n, 0), points[n], np.eye(3)[n], 1.0, np.arange(3)) for n in range(2)]
    with pytest.raises(stitch.StitchError, match="0 loops for 2 ends") as caught:
        stitch.build_strips(points, points, closed[: len(closed) * (left == "all")], ends)
    assert caught.value.ends == [(0, 0), (1, 0)]


def test_zipper_joins_two_rings():
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    lower = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    fine = np.linspace(0, 2 * np.pi, 18, endpoint=False) + 0.05
    upper = np.stack([np.cos(fine), np.sin(fine), 0 * fine + 0.4], axis=1)
    points = np.concatenate([lower, upper])
    strip = stitch.strip_between(points, points * [1, 1, 0], np.arange(12), 12 + np.arange(18))
    assert len(strip) == 30
    a, b, c = (points[strip[:, k]] for k in range(3))
    facing = np.cross(b - a, c - a)
    middle = (a + b + c) / 3
    outward = np.einsum("ij,ij->i", facing[:, :2], middle[:, :2])
    assert (outward < 0).all() or (outward > 0).all()
    assert [len(loop) for loop in sorted(stitch.border_loops(strip), key=len)] == [12, 18]


def test_zipper_makes_no_flat_or_folded_triangles_between_a_coarse_ring_and_a_fine_ragged_rim():
    """If the rings were joined by shortest edges, some triangles would be 0.04 mm high and turned by 63 degrees. gmsh
    makes slivers at such triangles."""
    angles, fine = (np.linspace(0, 2 * np.pi, count, endpoint=False) for count in (10, 36))
    ring = np.stack([2 * np.cos(angles), 2 * np.sin(angles), 0 * angles], axis=1)
    ragged = 0.3 + 0.12 * np.random.default_rng(6).uniform(-1, 1, len(fine))
    rim = np.stack([2 * np.cos(fine + 0.1), 2 * np.sin(fine + 0.1), ragged], axis=1)
    points = np.concatenate([ring, rim])
    normals = points * [1, 1, 0]
    strip = stitch.strip_between(points, normals, 10 + np.arange(36), np.arange(10))
    a, b, c = (points[strip[:, k]] for k in range(3))
    area, outward = np.cross(b - a, c - a), normals[strip].sum(axis=1)
    longest = np.max([np.linalg.norm(edge, axis=1) for edge in (b - a, c - b, a - c)], axis=0)
    assert (np.linalg.norm(area, axis=1) / longest).min() > 0.08
    cosine = (area * outward).sum(axis=1) / np.linalg.norm(area, axis=1) / np.linalg.norm(outward, axis=1)
    assert cosine.min() > 0.8


def test_curving_keeps_given_middles():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    middle = np.array([[0.5, -0.05, 0.0]])
    found = curving.curve(faces, np.zeros(4, int), points, np.array([[0, 1, 2, 3]]), np.array([[1, 0]]), middle)
    assert found.points[found.tetrahedra[0, 4]] == pytest.approx(middle[0])
    assert found.curved_edges == 1
