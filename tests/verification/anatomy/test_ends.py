"""Ends of every kind: rounded ends cut flat, ends given as points or cap files, cuts on request, flow extensions."""

import csv
import subprocess

import lofts
import numpy as np
import pytest
import surfaces

TREE = [
    ((0, 0, 0), (30, 0, 0), 1.7, 1.4),
    ((12, 0, 0), (12 + 9 * np.cos(0.9), 9 * np.sin(0.9), 0), 1.0, 0.9),
]


@pytest.fixture
def summary_of(process, tmp_path):
    """summary_of(surface, *options) -> anatomy.json of the lumen, written to tmp_path / "out"."""
    return lambda surface, *options: process(surface, tmp_path / "out", *options)[0]


@pytest.fixture(scope="module")
def rounded(tmp_path_factory):
    """File of the tree as a closed surface with half balls as ends."""
    folder = tmp_path_factory.mktemp("rounded")
    return surfaces.write(folder / "tree.vtp", *surfaces.tree(TREE, rounded=True))


@pytest.mark.parametrize("corners, spacing", [(24, 0.5), (12, 0.8)])
def test_coarse_lofts_with_rounded_ends(summary_of, tmp_path, corners, spacing):
    """At the seams of coarse lofts the inscribed spheres of the vertices alone do not connect."""
    pieces = []
    for a, b, r0, r1 in ((TREE[0]), ((16, 0, 0), (16 + 14 * np.cos(0.9), 14 * np.sin(0.9), 0.3), 0.8, 0.7)):
        length = float(np.linalg.norm(np.subtract(b, a)))
        along = np.subtract(b, a) / length
        axis = lambda s, a=a, along=along: np.asarray(a, float) + np.asarray(s, float)[:, None] * along  # noqa: E731
        radius = lambda s, r0=r0, r1=r1, length=length: np.interp(s, [0, length], [r0, r1])  # noqa: E731
        pieces.append(lofts.loft(axis, radius, length, corners, spacing, "round"))
    summary = summary_of(surfaces.write(tmp_path / "loft.stl", *lofts.fused(pieces)))
    assert reported(summary, "rounded end cut flat") == 3 and reported(summary, "rounded end left closed") == 0
    assert len(summary["branches"]) == 2


def reported(summary, what):
    return sum(repair["what"] == what for repair in summary["repairs"])


@pytest.mark.parametrize("edge, noise, seed", [(0.15, 0.04, 3), (0.2, 0.06, 3), (0.2, 0.05, 1)])
def test_rough_flat_ends(summary_of, tmp_path, edge, noise, seed):
    """A part of a rough cap is no end. Its farthest vertex lies on the rim, in a corner that no inscribed sphere
    touches."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: np.interp(s, [2, 10], [1.8, 0.8]), 12, edge)
    summary = summary_of(surfaces.write(tmp_path / "t.stl", lofts.noised(points, noise, seed), triangles))
    inlet, outlet = summary["ends"]
    for end, centre, radius in ((inlet, 0, 1.8), (outlet, 12, 0.8)):
        assert np.abs(end["centre_mm"][0] - centre) < 1.5 * radius
        assert np.hypot(*end["centre_mm"][1:]) < 0.1
        diameter = 2 * np.interp(end["centre_mm"][0], [2, 10], [1.8, 0.8])
        assert end["diameter_mm"] == pytest.approx(diameter, rel=0.03)


def test_a_vertex_that_stands_out_of_a_cap_is_of_the_cap(summary_of, tmp_path):
    """The vertex' triangles lie in no plane. As a piece of wall within the flattened cap they would fold."""
    fine = surfaces.vtk.vtkLinearSubdivisionFilter()
    fine.SetInputData(surfaces.polydata(*surfaces.tube(surfaces.straight, lambda s: 2 + 0 * s, 12, 0.6)))
    fine.SetNumberOfSubdivisions(2)
    fine.Update()
    points, triangles = surfaces.arrays(fine.GetOutput())
    from_axis = np.hypot(*points[:, 1:].T)
    inside = np.flatnonzero((points[:, 0] < 1e-9) & (from_axis > 0.8) & (from_axis < 1.2))
    points[inside[len(inside) // 2], 0] = -0.2
    summary = summary_of(surfaces.write(tmp_path / "t.stl", points, triangles))
    ends = sorted(summary["ends"], key=lambda end: end["centre_mm"][0])
    assert [end["centre_mm"][0] for end in ends] == pytest.approx([0, 12], abs=0.05)
    assert ends[0]["diameter_mm"] == pytest.approx(ends[1]["diameter_mm"], rel=0.002)


def test_rounded_ends_are_cut_across_the_axis(summary_of, rounded):
    summary = summary_of(rounded)
    assert reported(summary, "rounded end cut flat") == 3
    assert [end["name"] for end in summary["ends"]] == ["inlet", "outlet1", "outlet2"]
    for end, (a, b, r0, r1) in zip(summary["ends"], [(TREE[0][1], TREE[0][0], 1.4, 1.7), *TREE]):
        axis = np.subtract(b, a) / np.linalg.norm(np.subtract(b, a))
        from_tip = axis @ np.subtract(b, end["centre_mm"])
        assert np.degrees(np.arccos(axis @ end["normal"])) < 3
        assert 0 < from_tip < 0.7 * r1  # no more of the vessel is cut off
        assert np.linalg.norm(np.subtract(b, end["centre_mm"]) - from_tip * axis) < 0.05
        assert end["diameter_mm"] == pytest.approx(2 * r1, rel=0.03)


@pytest.mark.parametrize("seed", [1, 4])  # with 4 a tip's vertex stands out so far that no sphere touches it
def test_noisy_rounded_ends(summary_of, tmp_path, seed):
    points, triangles = surfaces.tree(TREE, rounded=True)
    points = points + 0.05 * np.random.default_rng(seed).standard_normal(points.shape)
    summary = summary_of(surfaces.write(tmp_path / "tree.stl", points, triangles))
    assert reported(summary, "rounded end cut flat") == 3
    assert [round(end["diameter_mm"], 1) for end in summary["ends"]] == [
        pytest.approx(2 * r, abs=0.15) for r in (1.7, 1.4, 0.9)
    ]


def stub_tree():
    """[(points, triangles)] of two pieces: a vessel with flat ends, and the rounded end of its side branch."""
    a, b = surfaces.tree(TREE), surfaces.tree(TREE, rounded=True)
    # the tree with flat ends up to y = 4, the rounded one above that
    return [(p, t[(p[t].mean(axis=1)[:, 1] > 4) == above]) for (p, t), above in ((a, False), (b, True))]


@pytest.mark.slow
def test_a_vessel_that_ends_rounded_beside_flat_ends_is_an_outlet_unless_the_points_leave_it_out(summary_of, tmp_path):
    (p, t), (q, u) = stub_tree()
    surface = surfaces.write(tmp_path / "stub.vtp", np.vstack([p, q]), np.vstack([t, u + len(p)]))
    summary = summary_of(surface)
    assert len(summary["ends"]) == 3 and reported(summary, "rounded end cut flat") == 1
    assert summary["ends"][2]["branch"] == "side1"
    summary = summary_of(surface, "--outlet", "30,0,0")
    assert len(summary["ends"]) == 2 and reported(summary, "end without a point left closed") == 1
    summary = summary_of(surface, "--outlet", "30,0,0", "--outlet", ",".join(map(str, TREE[1][1])))
    assert len(summary["ends"]) == 3 and reported(summary, "rounded end cut flat") == 1


def test_an_opening_that_no_point_names_is_refused_unless_the_user_closes_it(lumen, summary_of, tmp_path):
    surface = surfaces.write(tmp_path / "tree.vtp", *surfaces.tree(TREE))
    done = lumen(surface, tmp_path / "out", "--inlet", "0,0,0", "--outlet", "30,0,0")
    assert done.returncode == 2 and "not named" in done.stderr and "--close-others" in done.stderr
    assert "(17.59, 7.05" in done.stderr  # the message names this opening, which no point names, and the other two
    assert done.stderr.count("open, diameter") == 3
    summary = summary_of(surface, "--inlet", "0,0,0", "--outlet", "30,0,0", "--close-others")
    assert len(summary["ends"]) == 2 and len(summary["branches"]) == 1


LOFTS = [(corners, spacing, bend) for corners in (8, 12, 16, 24) for spacing in (0.3, 0.8, 2.0) for bend in (0, 0.05)]


@pytest.mark.parametrize("corners, spacing, bend", LOFTS)
def test_the_facets_of_a_loft_are_wall(summary_of, tmp_path, corners, spacing, bend):
    axis = surfaces.arc(bend) if bend else surfaces.straight
    points, triangles = lofts.loft(axis, lofts.narrowed(2.0, 70, 15, 8), 30, corners, spacing)
    summary = summary_of(surfaces.write(tmp_path / "loft.stl", points, triangles))
    centres = [end["centre_mm"] for end in summary["ends"]]
    assert len(centres) == 2 and len(summary["branches"]) == 1
    for middle in points[-2:]:
        assert np.linalg.norm(np.subtract(centres, middle), axis=1).min() < 0.01


@pytest.mark.parametrize("corners, spacing", [(24, 0.2), (10, 0.2)])
def test_a_regular_loft_of_short_triangles_is_remeshed(summary_of, tmp_path, corners, spacing):
    """Its long edges have the wanted length, and collapses of short ones spoil them. It must be remeshed anyway."""
    points, triangles = lofts.loft(surfaces.arc(0.02), lambda s: 1.5 + 0 * s, 25, corners, spacing)
    summary = summary_of(surfaces.write(tmp_path / "loft.stl", points, triangles))
    assert summary["mesh"]["min_angle_deg"] > 30


@pytest.mark.parametrize("slant", [15, 40])
def test_slanted_ends_stay_as_they_are(summary_of, tmp_path, slant):
    points, triangles = lofts.loft(surfaces.straight, lambda s: 1.5 + 0 * s, 25, 24, 0.4, slant=slant)
    summary = summary_of(surfaces.write(tmp_path / "loft.stl", points, triangles))
    assert len(summary["ends"]) == 2 and reported(summary, "rounded end cut flat") == 0
    for end in summary["ends"]:
        assert np.degrees(np.arccos(abs(end["normal"][0]))) == pytest.approx(slant, abs=1)
        # diameter_mm splits the flow, so it is the vessel's width; the cap is 14 % wider at 40 degrees
        assert end["diameter_mm"] == pytest.approx(3.0, abs=0.06)
        assert end["area_mm2"] == pytest.approx(np.pi * 1.5**2 / np.cos(np.radians(slant)), rel=0.03)


def test_flat_ends_with_chamfered_rims(summary_of, tmp_path):
    """A surface contoured on a grid has a chamfer one cell wide round each flat end. Its outline is a zigzag."""
    low, field = surfaces.tree_field(TREE)
    grid = low + 0.2 * np.moveaxis(np.indices(field.shape), 0, -1)
    flat = [(-1.0, 0, 0), *(np.subtract(b, a) / np.linalg.norm(np.subtract(b, a)) for a, b, _, _ in TREE)]
    for end, normal in zip([TREE[0][0], TREE[0][1], TREE[1][1]], flat):
        field = np.where(
            np.linalg.norm(grid - end, axis=-1) < 2.5, np.maximum(field, (grid - end) @ np.array(normal)), field
        )
    surface = surfaces.level_surface(low, field, 0.2)
    surface.Update()
    summary = summary_of(surfaces.write(tmp_path / "tree.stl", *surfaces.arrays(surface.GetOutput())))
    assert reported(summary, "rounded end cut flat") == 0 and len(summary["ends"]) == 3
    for end, r, centre in zip(summary["ends"], (1.7, 1.4, 0.9), [TREE[0][0], TREE[0][1], TREE[1][1]]):
        assert -0.09 < end["diameter_mm"] - 2 * r < 0.01  # the chamfer is cut off
        assert np.linalg.norm(np.subtract(end["centre_mm"], centre)) < 0.25


@pytest.mark.parametrize("edge", [0.25, 0.3])
def test_a_flat_end_whose_rim_was_smoothed_is_as_wide_as_its_vessel(summary_of, tmp_path, edge):
    """The flat part of such an end has only half of the vessel's section, so it must not give the end's diameter."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: np.interp(s, [0, 25], [1.7, 1.4]), 25, 0.3)
    summary = summary_of(surfaces.write(tmp_path / "t.stl", *lofts.contoured(points, triangles, edge)))
    inlet, outlet = summary["ends"]
    assert reported(summary, "rounded rim of a flat end cut off") > 0
    for end, at, diameter in ((inlet, 0, 3.4), (outlet, 25, 2.8)):
        assert abs(end["centre_mm"][0] - at) < 1.3 and end["diameter_mm"] == pytest.approx(diameter, rel=0.07)


@pytest.mark.parametrize("curvature", [0.15, 0.3, 0.36])
def test_a_flat_end_of_a_bent_vessel_has_no_rounded_rim(summary_of, tmp_path, curvature):
    """Parallel planes behind such an end cut the bend obliquely, so their sections grow. Nothing may be cut off."""
    points, triangles = surfaces.tube(surfaces.arc(curvature), lambda s: np.full_like(s, 2.5), 14, 0.3)
    summary = summary_of(surfaces.write(tmp_path / "t.stl", points, triangles))
    assert reported(summary, "rounded rim of a flat end cut off") == 0
    for end in summary["ends"]:
        assert end["area_mm2"] == pytest.approx(np.pi * 2.5**2, rel=0.01)


def test_an_end_of_a_vessel_that_bends_back_is_not_cut_through_the_bend(summary_of, tmp_path):
    """Planes behind the end soon meet the vessel where it comes back, and there it is wider. That is no rounded rim."""
    points, triangles = surfaces.tube(surfaces.arc(0.3), lambda s: 2.4 + 0.3 * np.sin(np.pi * s / 12) ** 2, 12, 0.3)
    summary = summary_of(surfaces.write(tmp_path / "t.stl", points, triangles))
    assert reported(summary, "rounded rim of a flat end cut off") == 0
    assert [end["area_mm2"] for end in summary["ends"]] == pytest.approx([np.pi * 2.4**2] * 2, rel=0.01)


@pytest.mark.parametrize("lobes", [3, 6])
def test_an_end_of_which_only_a_star_is_flat_is_as_wide_as_its_vessel(summary_of, tmp_path, lobes):
    """The flat part of a rough cap may reach the rim in several places, and be only half of the vessel's section."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: np.full_like(s, 1.5), 20, 0.15, capped=False)
    around = round(2 * np.pi * 1.5 / 0.15)
    capped = lofts.with_ring_cap(points, triangles, around, rings=10)
    radius, angle = (f(capped[0][:, 1], capped[0][:, 2]) for f in (np.hypot, lambda y, z: np.arctan2(z, y)))
    star = (np.abs(capped[0][:, 0]) < 1e-9) & ((radius < 0.6) | (np.cos(lobes * angle) > 0))
    capped[0][star, 0] -= 0.3
    ends = summary_of(surfaces.write(tmp_path / "t.stl", *capped))["ends"]
    assert [end["area_mm2"] for end in ends] == pytest.approx([np.pi * 1.5**2] * 2, rel=0.03)


@pytest.mark.parametrize("angle, told", [(0.9, False), (np.pi - 0.9, True), (np.radians(112), False)])
def test_side_branches_that_lean_back_speak_against_the_inlet(summary_of, tmp_path, angle, told):
    """One branch may leave at 112 degrees, as a conus branch does. At 128 degrees the inlet is doubted."""
    side = ((15, 0, 0), (15 + 9 * np.cos(angle), 9 * np.sin(angle), 0), 0.8, 0.7)
    summary = summary_of(surfaces.write(tmp_path / "t.stl", *surfaces.tree([((0, 0, 0), (30, 0, 0), 1.9, 1.6), side])))
    assert (reported(summary, "inlet chosen by its width alone") > 0) == told


def test_one_cap_of_two_ends_is_refused(lumen, tmp_path):
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 20, 0.4)
    flat = np.abs(points[triangles][:, :, 0]).max(axis=1) < 1e-9
    cap = surfaces.write(tmp_path / "cap.stl", points, triangles[flat])
    done = lumen(surfaces.write(tmp_path / "t.stl", points, triangles), tmp_path / "out", "--cap", cap)
    assert done.returncode == 2 and "give the cap of every end" in done.stderr


def test_cut_on_request(summary_of, tmp_path):
    surface = surfaces.write(tmp_path / "tree.vtp", *surfaces.tree(TREE))
    summary = summary_of(surface, "--cut", "25,0.5,0")
    assert reported(summary, "vessel cut across") == 1
    outlet = next(end for end in summary["ends"] if end["branch"] == "main" and end["kind"] == "outlet")
    assert outlet["centre_mm"] == pytest.approx([25, 0, 0], abs=0.1)
    assert outlet["diameter_mm"] == pytest.approx(2 * 1.45, rel=0.02)
    assert sorted(round(end["diameter_mm"], 1) for end in summary["ends"]) == [1.8, 2.9, 3.4]


def test_a_cut_away_from_the_vessel_is_refused(lumen, tmp_path):
    surface = surfaces.write(tmp_path / "tube.vtp", *surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 15))
    done = lumen(surface, tmp_path / "out", "--cut", "8,40,0")
    assert done.returncode == 2 and "no vessel near" in done.stderr and not (tmp_path / "out").exists()


@pytest.mark.parametrize("option", ["--inlet", "--outlet", "--cut"])
@pytest.mark.parametrize("point", ["nan,0,0", "0,inf,0"])
def test_a_point_of_no_numbers_is_refused(lumen, tmp_path, option, point):
    """No distance to such a point compares as larger, so it would be taken for the first end."""
    surface = surfaces.write(tmp_path / "tube.vtp", *surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 15))
    done = lumen(surface, tmp_path / "out", option, point)
    assert done.returncode == 2 and option in done.stderr and "no number" in done.stderr


def test_a_folder_that_cannot_be_made_is_refused(lumen, binary, tmp_path):
    surface = surfaces.write(tmp_path / "tube.vtp", *surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 15))
    (tmp_path / "file").write_text("")
    done = lumen(surface, tmp_path / "file")
    assert done.returncode == 2 and done.stderr.count("error:") == 1 and "defect" not in done.stderr
    command = [str(binary("lumen")), "remesh", str(surface), "--out"]
    done = subprocess.run([*command, str(tmp_path / "file" / "tube.vtp")], text=True, capture_output=True, timeout=60)
    assert done.returncode == 2 and done.stderr.count("error:") == 1 and "lumen: read" not in done.stderr
    made = tmp_path / "absent" / "tube.vtp"
    done = subprocess.run([*command, str(made)], text=True, capture_output=True, timeout=60)
    assert done.returncode == 0 and made.is_file(), "a folder that does not exist is made, as by `process`"


@pytest.mark.parametrize("wall", ["open", "closed"])
def test_caps_given_as_files(summary_of, lumen, tmp_path, wall):
    points, triangles = surfaces.tube(surfaces.arc(0.1), lambda s: 1.6 - 0.01 * s, 20)
    first, last = ((triangles == len(points) - k).any(axis=1) for k in (2, 1))
    names = []
    for name, cells in (("out", last), ("in", first)):
        names.append(surfaces.write(tmp_path / f"{name}.stl", points, triangles[cells]))
    body = triangles[~(first | last)] if wall == "open" else triangles
    surface = surfaces.write(tmp_path / "wall.stl", points, body)
    summary = summary_of(surface, "--cap", names[0], "--cap", names[1])  # the first cap is the inlet
    assert summary["ends"][0]["kind"] == "inlet"
    assert summary["ends"][0]["centre_mm"] == pytest.approx(points[-1], abs=0.01)
    assert summary["ends"][0]["area_mm2"] == pytest.approx(np.pi * 1.4**2, rel=0.02)
    astray = surfaces.write(tmp_path / "astray.stl", points + [0, 0, 9], triangles[last])
    done = lumen(surface, tmp_path / "other", "--cap", astray, "--cap", names[1])
    assert done.returncode == 2 and ("at a given cap" in done.stderr or "near the given point" in done.stderr)


def cap_files(folder, points, triangles):
    """Files of a tube: (surface, cap of the first end, cap of the last end). The caps have the surface's triangles."""
    first, last = ((triangles == len(points) - k).any(axis=1) for k in (2, 1))
    caps = [surfaces.write(folder / f"{k}.stl", points, triangles[at]) for k, at in enumerate((first, last))]
    return surfaces.write(folder / "wall.stl", points, triangles), *caps


@pytest.mark.parametrize("height_mm", [1.2, 8.0])
@pytest.mark.parametrize("wall", ["open", "closed"])
def test_a_dome_as_cap_file_is_opened_at_its_rim(summary_of, tmp_path, wall, height_mm):
    """The cap file has the triangles of a rounded end, so the vessel ends where they begin. The middle of a tall dome
    is several radii from there."""
    points, triangles = surfaces.tube(surfaces.arc(0.1), lambda s: 1.6 - 0.01 * s, 20)
    flat = points[-2].copy()
    points[-2] -= [height_mm, 0, 0]
    surface, inlet, outlet = cap_files(tmp_path, points, triangles)
    if wall == "open":
        on_cap = (triangles >= len(points) - 2).any(axis=1)
        surface = surfaces.write(tmp_path / "open.stl", points, triangles[~on_cap])
    summary = summary_of(surface, "--cap", inlet, "--cap", outlet)
    assert len(summary["ends"]) == 2 and summary["ends"][0]["kind"] == "inlet"
    assert summary["ends"][0]["centre_mm"] == pytest.approx(flat, abs=0.02)
    assert summary["ends"][0]["area_mm2"] == pytest.approx(np.pi * 1.6**2, rel=0.02)


@pytest.mark.parametrize("cut_at", [0.95, 0.8, 0.45])
@pytest.mark.parametrize("wall", ["open", "closed"])
def test_a_cap_file_of_a_shallow_tip_names_its_end(summary_of, tmp_path, wall, cut_at):
    """The first end is a half ball, cut where it has the share `cut_at` of the radius. Beside the rim the wall lies
    nearly in the rim's plane, as round a hole. The cap file keeps it open. A much too narrow end is reported."""
    radius = lambda s: np.where(s < 1.5, np.sqrt(np.maximum(1.5**2 - (s - 1.5) ** 2, 1e-6)), 1.5)  # noqa: E731
    start = 1.5 * (1 - np.sqrt(1 - cut_at**2))
    points, triangles = surfaces.tube(surfaces.straight, lambda s: radius(s + start), 20, 0.2)
    surface, inlet, outlet = cap_files(tmp_path, points, triangles)
    if wall == "open":
        on_cap = (triangles >= len(points) - 2).any(axis=1)
        surface = surfaces.write(tmp_path / "open.stl", points, triangles[~on_cap])
    summary = summary_of(surface, "--cap", inlet, "--cap", outlet)
    assert [end["kind"] for end in summary["ends"]] == ["inlet", "outlet"]
    assert summary["ends"][0]["centre_mm"] == pytest.approx([0, 0, 0], abs=0.05)
    assert summary["ends"][0]["diameter_mm"] == pytest.approx(2 * 1.5 * cut_at, rel=0.03)
    assert reported(summary, "end narrower than its vessel") == (cut_at < 0.6)


def test_the_mouth_of_a_funnel_is_an_end_where_a_point_says_so(summary_of, tmp_path):
    """The funnel's lip lies within 7 degrees of the rim's plane, like the wall round a hole."""
    radius = lambda s: np.interp(s, [0, 0.2, 0.3, 0.6], [3, 2, 1.7, 1.5])  # noqa: E731
    points, triangles = surfaces.tube(surfaces.straight, radius, 20, 0.1, capped=False)
    points[:, 0] = np.where(points[:, 0] < 0.2, 0.2 + (points[:, 0] - 0.2) * 0.6, points[:, 0])
    surface = surfaces.write(tmp_path / "funnel.stl", points, triangles)
    summary = summary_of(surface, "--inlet", "0,0,0", "--outlet", "20,0,0")
    assert [end["kind"] for end in summary["ends"]] == ["inlet", "outlet"]
    assert summary["ends"][0]["diameter_mm"] == pytest.approx(6, rel=0.03)
    assert reported(summary, "hole filled") == 0


def test_a_hole_in_a_given_cap_is_filled(summary_of, tmp_path):
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 20)
    fine = surfaces.vtk.vtkLinearSubdivisionFilter()
    fine.SetInputData(surfaces.polydata(points, triangles))
    fine.SetNumberOfSubdivisions(2)
    fine.Update()
    points, triangles = surfaces.arrays(fine.GetOutput())
    at = points[triangles].mean(axis=1)
    caps = [surfaces.write(tmp_path / f"{x}.stl", points, triangles[np.abs(at[:, 0] - x) < 1e-6]) for x in (0, 20)]
    hole = np.linalg.norm(at - [0, 0.7, 0], axis=1) < 0.25
    assert 1 < hole.sum() < 0.2 * (np.abs(at[:, 0]) < 1e-6).sum()
    surface = surfaces.write(tmp_path / "holed.stl", points, triangles[~hole])
    summary = summary_of(surface, "--cap", caps[0], "--cap", caps[1])
    assert summary["ends"][0]["area_mm2"] == pytest.approx(np.pi * 1.5**2, rel=0.02)
    assert reported(summary, "hole filled") >= 1


@pytest.mark.parametrize("off_mm", [0.13, 0.3, 0.5])
def test_a_cap_file_whose_rim_is_a_saddle_names_one_end(summary_of, tmp_path, off_mm):
    """The rim is off its plane by up to a third of the radius. If it would fold when flattened, it is cut off."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 20)
    rim = np.isclose(points[:, 0], 20) & (np.hypot(points[:, 1], points[:, 2]) > 1)
    angle = np.arctan2(points[rim, 2], points[rim, 1])
    points[rim, 0] += off_mm * np.sin(2 * angle)
    surface, inlet, outlet = cap_files(tmp_path, points, triangles)
    summary = summary_of(surface, "--cap", inlet, "--cap", outlet)
    assert [end["kind"] for end in summary["ends"]] == ["inlet", "outlet"]
    assert summary["ends"][1]["centre_mm"] == pytest.approx([20, 0, 0], abs=2 * off_mm)
    assert summary["ends"][1]["area_mm2"] == pytest.approx(np.pi * 1.5**2, rel=0.02)


def test_a_cap_file_of_a_band_of_wall_is_refused(lumen, tmp_path):
    """Without the band the surface has two more openings. A cap closes one end, so this is no cap."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 20)
    surface, inlet, _ = cap_files(tmp_path, points, triangles)
    band = np.abs(points[triangles][:, :, 0].mean(axis=1) - 10) < 2
    ring = surfaces.write(tmp_path / "band.stl", points, triangles[band])
    done = lumen(surface, tmp_path / "out", "--cap", inlet, "--cap", ring)
    assert done.returncode == 2 and "does not close one end" in done.stderr and "band.stl" in done.stderr


@pytest.mark.slow
def test_flow_extensions(summary_of, tmp_path):
    surface = surfaces.write(tmp_path / "tree.vtp", *surfaces.tree(TREE))
    plain = summary_of(surface)
    summary = summary_of(surface, "--extend-inlet", 4, "--extend-outlets", 3)
    for before, end in zip(plain["ends"], summary["ends"]):
        length = (4 if end["kind"] == "inlet" else 3) * before["diameter_mm"] / 2
        assert end["extension_mm"] == pytest.approx(length)
        moved = np.subtract(end["centre_mm"], before["centre_mm"])
        assert moved == pytest.approx(length * np.array(before["normal"]), abs=1e-6)
        assert end["area_mm2"] == pytest.approx(before["area_mm2"], rel=1e-6)
    added = sum(end["extension_mm"] * end["area_mm2"] for end in summary["ends"])
    assert summary["mesh"]["volume_mm3"] - plain["mesh"]["volume_mm3"] == pytest.approx(added, rel=0.02)
    with (tmp_path / "out" / "sections.csv").open() as file:
        main = [row for row in csv.DictReader(file) if row["branch"] == "main" and row["flag"] != "end"]
    # only the vessel's own sections are not flagged `end`, now up to the places where it was cut
    x = np.array([float(row["x_mm"]) for row in main])
    assert -0.01 < x.min() < 0.6 and 29.4 < x.max() < 30.01
    again = summary_of(tmp_path / "out" / "lumen.vtp", "--like", tmp_path / "out" / "anatomy.json")
    assert [e["extension_mm"] for e in again["ends"]] == [e["extension_mm"] for e in summary["ends"]]


def test_extensions_that_meet_are_refused(lumen, tmp_path):
    half_circle = surfaces.tube(surfaces.arc(0.3), lambda s: 1.2 + 0 * s, np.pi / 0.3 + 4)
    surface = surfaces.write(tmp_path / "u.vtp", *half_circle)
    done = lumen(surface, tmp_path / "out", "--extend-inlet", 8, "--extend-outlets", 8)
    assert done.returncode == 2 and "extension meets" in done.stderr
