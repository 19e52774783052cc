"""Each defect is made on purpose in a good tube. It must be repaired and reported, or refused with its place."""

import json

import numpy as np
import pytest
import surfaces


@pytest.fixture(scope="module")
def tube():
    return surfaces.tube(surfaces.arc(0.1), lambda s: 1.6 - 0.01 * s, 20)


def volume(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def wall_triangle(points, triangles):
    """Number of a triangle half way along the tube."""
    middle = surfaces.arc(0.1)(np.array([10.0]))[0]
    return int(np.linalg.norm(points[triangles].mean(axis=1) - middle, axis=1).argmin())


def flipped(points, triangles):
    triangles = triangles.copy()
    triangles[::4] = triangles[::4, ::-1]
    return points, triangles


def inward(points, triangles):
    return points, triangles[:, ::-1]


def shuffled_soup(points, triangles):
    order = np.random.default_rng(1).permutation(len(triangles))
    return points[triangles[order]].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)


def gaps(points, triangles):
    points, triangles = shuffled_soup(points, triangles)
    return points + 1e-6 * np.random.default_rng(1).uniform(-1, 1, points.shape), triangles


def duplicates(points, triangles):
    return points, np.vstack([triangles, triangles[10:40]])


def fin(points, triangles):
    t = wall_triangle(points, triangles)
    tip = points[triangles[t]].mean(axis=0) + [0, 0, 1.0]
    return np.vstack([points, tip]), np.vstack([triangles, [*triangles[t][:2], len(points)]])


def hole(points, triangles):
    t = wall_triangle(points, triangles)
    return points, np.delete(triangles, [t, t + 1, t - 1], axis=0)


def open_ends(points, triangles):
    around = np.count_nonzero(triangles[:, 0] == len(points) - 1)
    return points, triangles[: -2 * around]


def second_component(points, triangles):
    small = 0.2 * points + [0, 0, 9]
    return np.vstack([points, small]), np.vstack([triangles, triangles + len(points)])


def self_intersection(points, triangles):
    points = points.copy()
    v = triangles[wall_triangle(points, triangles)][0]
    s = np.linspace(0, 20, 2000)
    centre = surfaces.arc(0.1)(s)
    nearest = centre[np.linalg.norm(centre - points[v], axis=1).argmin()]
    points[v] = nearest - 1.3 * (points[v] - nearest)
    return points, triangles


def degenerate(points, triangles):
    return points, np.vstack([triangles, [[5, 5, 9], [7, 8, 7]]])


def t_junctions(points, triangles):
    """Edges are divided on one side only, by points exactly on them, since coordinates are multiples of 2^-16."""
    points = np.round(points * 2**16) / 2**16
    added, pieces, whole = [], [], np.ones(len(triangles), dtype=bool)
    for t in range(0, len(triangles), 17):
        a, b, c = triangles[t]
        m, q = len(points) + len(added), len(points) + len(added) + 1
        added += [(points[a] + points[b]) / 2, (3 * points[a] + points[b]) / 4]
        pieces += [[a, q, c], [q, m, c], [m, b, c]]
        whole[t] = False
    return np.vstack([points, added]), np.vstack([triangles[whole], pieces])


DEFECTS = {
    degenerate: "degenerate triangles dropped",
    flipped: "triangles turned",
    inward: "normals turned outward",
    shuffled_soup: "points welded",
    gaps: "points welded",
    duplicates: "duplicate triangles dropped",
    fin: "fins dropped",
    hole: "hole filled",
    open_ends: "open end capped",
    second_component: "components dropped",
    self_intersection: "self-intersections removed",
    t_junctions: "edges divided",
}


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda d: d.__name__)
def test_repaired_and_reported(lumen, tube, tmp_path, defect):
    surface = surfaces.write(tmp_path / "tube.vtp", *defect(*tube))
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "out" / "anatomy.json").read_text())
    assert DEFECTS[defect] in [repair["what"] for repair in summary["repairs"]]
    assert len(summary["ends"]) == 2 and len(summary["branches"]) == 1
    points, triangles = surfaces.arrays(surfaces.read(tmp_path / "out" / "lumen.vtp"))
    assert volume(points, triangles) == pytest.approx(volume(*tube), rel=0.01)
    edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".obj"])
def test_formats_agree(lumen, tube, tmp_path, suffix):
    done = lumen(surfaces.write(tmp_path / f"tube{suffix}", *tube), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "out" / "anatomy.json").read_text())
    assert summary["branches"][0]["length_mm"] == pytest.approx(20, abs=0.05) and not summary["repairs"]


def write_text_stl(path, tube):
    """Writes a surface as STL in text."""
    writer = surfaces.vtk.vtkSTLWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(surfaces.polydata(*tube))
    writer.SetFileTypeToASCII()
    writer.Write()


def test_ascii_stl(lumen, tube, tmp_path):
    write_text_stl(tmp_path / "tube.stl", tube)
    assert (tmp_path / "tube.stl").read_bytes().startswith(b"solid")
    done = lumen(tmp_path / "tube.stl", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert not json.loads((tmp_path / "out" / "anatomy.json").read_text())["repairs"]


def test_a_ragged_open_end_is_refused_with_its_place(lumen, tube, tmp_path):
    points, triangles = open_ends(*tube)
    far = np.isclose(points, points[triangles[-1, 0]]).all(axis=1)  # a corner of the far rim
    points = points.copy()
    points[far] -= 2.0 * (surfaces.arc(0.1)(np.array([20.0])) - surfaces.arc(0.1)(np.array([19.0])))
    done = lumen(surfaces.write(tmp_path / "tube.vtp", points, triangles), tmp_path / "out")
    assert done.returncode == 2 and "not cut flat" in done.stderr and done.stderr.count("error:") == 1
    where = [float(x) for x in done.stderr.split("where:  (")[1].split(")")[0].split(", ")]
    assert np.linalg.norm(where - surfaces.arc(0.1)(np.array([20.0]))[0]) < 0.5


@pytest.mark.parametrize("scale, declared, likely", [(0.001, "mm", "m"), (1, "m", "mm"), (0.1, "mm", "cm")])
def test_implausible_scale_is_refused(lumen, tube, tmp_path, scale, declared, likely):
    surface = surfaces.write(tmp_path / "tube.vtp", scale * tube[0], tube[1])
    done = lumen(surface, tmp_path / "out", "--units", declared)
    assert done.returncode == 2 and f"declare units {likely}" in done.stderr
    assert not (tmp_path / "out").exists()
    assert lumen(surface, tmp_path / "out", "--units", likely).returncode == 0


def test_a_wide_vessel_in_centimetres_is_refused(lumen, tmp_path):
    """Its length is plausible in mm, but its radius would be below 0.3 mm throughout."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 2.9 + 0 * s, 60)
    surface = surfaces.write(tmp_path / "tube.vtp", 0.1 * points, triangles)
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 2 and "mean radius" in done.stderr and "declare units cm" in done.stderr
    assert lumen(surface, tmp_path / "out", "--units", "cm").returncode == 0


def test_a_ball_is_refused_with_a_remedy(lumen, tmp_path):
    sphere = surfaces.vtk.vtkSphereSource()
    sphere.SetRadius(3)
    sphere.SetThetaResolution(40)
    sphere.SetPhiResolution(40)
    sphere.Update()
    surface = surfaces.write(tmp_path / "ball.vtp", *surfaces.arrays(sphere.GetOutput()))
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 2 and "cut each end of the vessel flat, or leave it open" in done.stderr


@pytest.mark.parametrize("edge", [1.2, 1.6])
def test_facets_of_a_coarse_wall_are_no_ends(lumen, tmp_path, edge):
    """With eight or six facets round, only the two ends are ends. The lumen keeps the volume of the facets."""
    given = surfaces.tube(surfaces.arc(0.1), lambda s: 1.5 + 0 * s, 20, edge)
    done = lumen(surfaces.write(tmp_path / "tube.vtp", *given), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "out" / "anatomy.json").read_text())
    assert len(summary["ends"]) == 2 and summary["branches"][0]["length_mm"] == pytest.approx(20, abs=0.1)
    assert 0.98 * volume(*given) < summary["mesh"]["volume_mm3"] < np.pi * 1.5**2 * 20


def test_another_vessel_is_warned_of(lumen, tube, tmp_path):
    """A speck is dropped and reported. A vessel of comparable size gives a warning with both vessels' places."""
    points, triangles = tube
    for scale, offset, warns in ((1.0, 12.0, True), (0.55, 12.0, True), (0.2, 9.0, False)):
        both = np.vstack([points, scale * points + [0, 0, offset]]), np.vstack([triangles, triangles + len(points)])
        done = lumen(surfaces.write(tmp_path / "two.vtp", *both), tmp_path / "out")
        assert done.returncode == 0, done.stderr
        repairs = json.loads((tmp_path / "out" / "anatomy.json").read_text())["repairs"]
        assert "components dropped" in [repair["what"] for repair in repairs]
        said = [repair["detail"] for repair in repairs if repair["what"] == "another vessel left out"]
        assert len(said) == warns and ("warning: another vessel left out" in done.stderr) == warns
        if warns:
            places = [[float(x) for x in part.split(")")[0].split(", ")] for part in said[0].split("(")[1:3]]
            assert abs(places[0][2] - places[1][2]) == pytest.approx(offset, abs=0.1)


def test_the_two_sides_of_a_wall_are_no_lumen(lumen, tmp_path):
    """The outer side is larger: as a lumen it would have too wide ends and too mild lesions. The inlet chooses."""

    def side(thickness):
        return surfaces.tube(surfaces.arc(0.02), lambda s: 1.5 + thickness + 0 * s, 20, 0.3)

    (points, triangles), (outer, around) = side(0.0), side(0.7)
    both = np.vstack([points, outer]), np.vstack([triangles, around + len(points)])
    surface = surfaces.write(tmp_path / "wall.vtp", *both)
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 2 and "the two sides of a vessel's wall" in done.stderr and "--inlet" in done.stderr
    done = lumen(surface, tmp_path / "named", "--inlet", "0,0,0")
    assert done.returncode == 0, done.stderr
    ends = json.loads((tmp_path / "named" / "anatomy.json").read_text())["ends"]
    assert [end["diameter_mm"] for end in ends] == [pytest.approx(3.0, abs=0.1)] * 2


def test_a_shorter_vessel_beside_the_curve_of_another_is_no_wall(lumen, tmp_path):
    """Its bounding box lies within the other's and is 0.85 times as long."""
    points, triangles = surfaces.tube(surfaces.arc(0.06), lambda s: 1.5 + 0 * s, 30, 0.3)
    inner, around = surfaces.tube(surfaces.arc(0.06), lambda s: 1.0 + 0 * s, 25.5, 0.3)
    middle, other = (0.5 * (one.min(axis=0) + one.max(axis=0)) for one in (points, inner))
    inner = inner + middle - other
    length, shorter = (np.linalg.norm(np.ptp(one, axis=0)) for one in (points, inner))
    assert 0.8 * length < shorter < 0.9 * length
    assert (inner.min(axis=0) > points.min(axis=0)).all() and (inner.max(axis=0) < points.max(axis=0)).all()
    both = np.vstack([points, inner]), np.vstack([triangles, around + len(points)])
    done = lumen(surfaces.write(tmp_path / "two.vtp", *both), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "warning: another vessel left out" in done.stderr


def test_the_inlet_chooses_the_vessel_and_a_lost_piece_is_told(lumen, tube, tmp_path):
    """A piece of 6 mm is small beside the whole, but it may be a lost branch."""
    points, triangles = tube
    far = 0.3 * points + [0, 0, 9]
    length = np.linalg.norm(np.ptp(far, axis=0))
    both = np.vstack([points, 0.8 * points + [0, 0, 12], far]), np.vstack(
        [triangles, triangles + len(points), triangles + 2 * len(points)]
    )
    surface = surfaces.write(tmp_path / "two.vtp", *both)
    inlet = min(0.8 * points + [0, 0, 12], key=lambda p: p[0])
    done = lumen(surface, tmp_path / "out", "--inlet", ",".join(f"{x:.3f}" for x in inlet))
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("warning: another vessel left out") == 1 + (length > 5)
    summary = json.loads((tmp_path / "out" / "anatomy.json").read_text())
    assert all(abs(end["centre_mm"][2] - 12) < 3 for end in summary["ends"])


@pytest.mark.parametrize("change", [-400, -7, 1000])
def test_binary_stl_of_another_size_is_refused(lumen, tube, tmp_path, change):
    whole = surfaces.write(tmp_path / "tube.stl", *tube).read_bytes()
    (tmp_path / "tube.stl").write_bytes(whole[:change] if change < 0 else whole + bytes(change))
    done = lumen(tmp_path / "tube.stl", tmp_path / "out")
    assert done.returncode == 2 and not (tmp_path / "out").exists()
    assert f"{len(whole) + change} bytes; its header says {len(tube[1])} triangles, {len(whole)} bytes" in done.stderr


@pytest.mark.parametrize("count", [10, 10**6, 2**32 - 1])
def test_binary_stl_with_a_false_count_is_refused(lumen, tube, tmp_path, count):
    whole = bytearray(surfaces.write(tmp_path / "tube.stl", *tube).read_bytes())
    whole[80:84] = count.to_bytes(4, "little")
    (tmp_path / "tube.stl").write_bytes(whole)
    done = lumen(tmp_path / "tube.stl", tmp_path / "out")
    assert done.returncode == 2 and f"{len(whole)} bytes; its header says {count} triangles" in done.stderr


def test_binary_stl_that_calls_itself_solid_is_read(lumen, tube, tmp_path):
    whole = surfaces.write(tmp_path / "tube.stl", *tube).read_bytes()
    (tmp_path / "tube.stl").write_bytes(b"solid tube".ljust(80, b"\0") + whole[80:])
    done = lumen(tmp_path / "tube.stl", tmp_path / "out")
    assert done.returncode == 0, done.stderr


def test_cut_off_text_stl_is_refused(lumen, tube, tmp_path):
    write_text_stl(tmp_path / "tube.stl", tube)
    text = (tmp_path / "tube.stl").read_bytes()
    (tmp_path / "tube.stl").write_bytes(text[: len(text) * 2 // 3])
    done = lumen(tmp_path / "tube.stl", tmp_path / "out")
    assert done.returncode == 2 and "without a last line endsolid" in done.stderr


def test_truncated_file_is_refused(lumen, tube, tmp_path):
    whole = surfaces.write(tmp_path / "tube.vtp", *tube).read_bytes()
    (tmp_path / "half.vtp").write_bytes(whole[: len(whole) // 2])
    done = lumen(tmp_path / "half.vtp", tmp_path / "out")
    assert done.returncode == 2 and "half.vtp" in done.stderr and not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "options, said",
    [(["--label", "x"], "label"), (["--edge"], "edge"), (["--colour", "red"], "colour"), (["--inlet", "1,2"], "inlet")],
)
def test_command_line_that_is_not_understood(lumen, tube, tmp_path, options, said):
    done = lumen(surfaces.write(tmp_path / "tube.vtp", *tube), tmp_path / "out", *options)
    assert done.returncode == 2 and done.stderr.count("error:") == 1 and said in done.stderr
    assert "lumen process --help" in done.stderr and not (tmp_path / "out").exists()


def test_a_fold_at_the_highest_vertex_does_not_turn_the_surface(process, tmp_path):
    """The rim's two points beside the highest one have changed places, so that the triangles there face inward."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 16, edge=0.3)
    points = points[:, [1, 2, 0]]
    before, top, after = np.flatnonzero((points[:, 2] > 15.9) & (np.hypot(points[:, 0], points[:, 1]) > 1))[4:7]
    points[top, 2] += 0.05
    points[[before, after]] = points[[after, before]]
    summary, _ = process(surfaces.write(tmp_path / "fold.stl", points, triangles), tmp_path / "out")
    assert "normals turned outward" not in [one["what"] for one in summary["repairs"]]
    assert len(summary["ends"]) == 2 and summary["mesh"]["volume_mm3"] == pytest.approx(np.pi * 1.5**2 * 16, rel=0.02)
