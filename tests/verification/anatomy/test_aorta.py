"""One patient's aorta with both coronary trees: the trees are found, named, cut off at their ostia and measured."""

import json
import subprocess

import aorta
import numpy as np
import pytest
import surfaces

pytestmark = pytest.mark.slow

OUTLETS = {"left": 5, "right": 4}
SPACING = 0.4


@pytest.fixture(scope="module")
def folder(shared_data):
    return [shared_data(f"multimoda/{name}") for name in aorta.FILES.values()][0].parent


@pytest.fixture(scope="module")
def model(folder):
    """The aorta with both trees, all ends cut flat; its surface is in .made, (points, triangles)."""
    found = aorta.Model()
    found.add_aorta(folder)
    for tree in OUTLETS:
        found.add_tree(folder, tree)
    found.made = found.surface(SPACING)
    return found


@pytest.fixture(scope="module")
def whole(model, tmp_path_factory):
    return surfaces.write(tmp_path_factory.mktemp("aorta") / "whole.stl", *model.made)


@pytest.fixture(scope="module")
def check(binary):
    """check(surface, *options) -> CompletedProcess of `lumen check`."""
    return lambda surface, *options: subprocess.run(
        [str(binary("lumen")), "check", str(surface), *map(str, options)], text=True, capture_output=True, timeout=240
    )


def trees_of(done):
    """{name: (ostium, diameter, outlets)} of the table that `lumen check` prints; None without an aorta."""
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    start = [k for k, line in enumerate(lines) if line.startswith("tree    ostium")]
    if not start:
        return None
    rows = [line.split() for line in lines[start[0] + 1 :] if not line.startswith("choose")]
    return {r[0]: (np.array(r[1:4], float), float(r[4]), int(r[6])) for r in rows}


def moved(model, matrix, shift=(0, 0, 0)):
    """The model's surface by a linear map and a shift."""
    points, triangles = model.made
    return points @ np.asarray(matrix).T + shift, triangles


def point(p):
    return ",".join(f"{x:.3f}" for x in p)


def test_both_trees_are_found_with_their_outlets(check, whole, tmp_path):
    trees = trees_of(done := check(whole, "--ends", tmp_path / "ends.json"))
    assert {name: outlets for name, (_, _, outlets) in trees.items()} == OUTLETS
    assert trees["left"][0] == pytest.approx([15.4, -189.4, 1750.4], abs=1.0)
    assert trees["right"][0] == pytest.approx([13.1, -207.7, 1750.3], abs=1.0)
    assert 3.8 < trees["left"][1] < 4.8 and 2.5 < trees["right"][1] < 3.5
    assert "--tree left or --tree right" in done.stdout
    listed = json.loads((tmp_path / "ends.json").read_text())["trees"]
    assert {tree["name"]: tree["outlets"] for tree in listed} == OUTLETS


def test_without_a_choice_both_are_listed_and_nothing_is_written(lumen, whole, tmp_path):
    done = lumen(whole, tmp_path / "out")
    assert done.returncode == 2 and not (tmp_path / "out").exists()
    for words in ("left: ostium at (15.", "right: ostium at (1", "choose one by --tree left or --tree right"):
        assert words in done.stderr, done.stderr


TURNED = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
TURNED = TURNED * np.sign(np.linalg.det(TURNED))


@pytest.mark.parametrize("matrix", [np.diag([-1, -1, 1]), TURNED], ids=["ras", "turned"])
def test_names_hold_in_any_frame(check, model, tmp_path, matrix):
    """The names are the same in left-posterior-superior, right-anterior-superior and any other coordinates, since the
    order round the aorta is."""
    surface = surfaces.write(tmp_path / "moved.stl", *moved(model, matrix, (50, -20, 300)))
    trees = trees_of(check(surface))
    assert {name: outlets for name, (_, _, outlets) in trees.items()} == OUTLETS
    assert matrix.T @ (trees["left"][0] - (50, -20, 300)) == pytest.approx([15.4, -189.4, 1750.4], abs=1.0)


@pytest.mark.long
@pytest.mark.parametrize("tree", OUTLETS)
def test_a_tree_measures_as_the_same_tree_without_an_aorta(process, check, folder, whole, tmp_path, tree):
    summary, rows = process(whole, tmp_path / "cut", "--tree", tree)
    alone = aorta.Model()
    alone.add_tree(folder, tree, most_radius=4.5)
    ostium = np.array(summary["ends"][0]["centre_mm"])
    axis = aorta.smoothed(aorta.lines(folder, tree)[0][0])
    at = int(np.argmin(np.linalg.norm(axis - ostium, axis=1)))
    alone.ends.append((ostium, np.array(summary["ends"][0]["normal"]), 2.0, 3.0))
    assert np.dot(axis[at + 5] - axis[at], summary["ends"][0]["normal"]) < 0  # outwards: into the aorta
    surface = surfaces.write(tmp_path / "alone.stl", *alone.surface(SPACING))
    expected, expected_rows = process(surface, tmp_path / "alone")
    assert len(summary["ends"]) == len(expected["ends"]) == OUTLETS[tree] + 1
    for found, wanted in zip(summary["branches"], expected["branches"]):
        assert found["name"] == wanted["name"] and found["length_mm"] == pytest.approx(wanted["length_mm"], abs=1.0)
    worst = max(expected["lesions"], key=lambda lesion: lesion["diameter_stenosis_percent"])
    same = max(summary["lesions"], key=lambda lesion: lesion["diameter_stenosis_percent"])
    assert same["branch"] == worst["branch"] and same["s_mla_mm"] == pytest.approx(worst["s_mla_mm"], abs=1.0)
    assert same["mla_mm2"] == pytest.approx(worst["mla_mm2"], rel=0.03)
    assert same["diameter_stenosis_percent"] == pytest.approx(worst["diameter_stenosis_percent"], abs=3)
    areas, wanted = (
        {(r["branch"], round(float(r["s_mm"]))): float(r["area_mm2"]) for r in table if r["flag"] == "ok"}
        for table in (rows, expected_rows)
    )
    shared = sorted(set(areas) & set(wanted))
    ratio = np.array([areas[k] / wanted[k] for k in shared])
    assert len(shared) > 100 and np.median(np.abs(ratio - 1)) < 0.03


def test_cm_are_read_where_declared_and_asked_for_where_not(check, model, tmp_path):
    surface = surfaces.write(tmp_path / "cm.stl", *moved(model, 0.1 * np.eye(3)))
    trees = trees_of(check(surface, "--units", "cm"))
    assert {name: outlets for name, (_, _, outlets) in trees.items()} == OUTLETS
    done = check(surface)
    assert done.returncode == 2 and "declare units cm" in done.stderr


def test_a_point_at_the_ostium_chooses_and_cuts(check, folder, whole):
    axis, radii = aorta.lines(folder, "right")[0]
    place = axis[np.searchsorted(aorta.arc_lengths(axis), 60.0)]
    done = check(whole, "--ostium", point(place))
    ((name, (ostium, _, outlets)),) = trees_of(done).items()
    assert name == "right" and outlets == OUTLETS["right"]
    inlet = [line.split() for line in done.stdout.splitlines() if "  open  " in line][0]
    assert np.linalg.norm(np.array(inlet[:3], float) - place) < 1.0
    far = check(whole, "--ostium", "100,-100,1700")
    assert far.returncode == 2 and "no coronary tree near the given ostium" in far.stderr


@pytest.mark.long
def test_outlets_choose_the_tree_and_what_they_leave_out_is_said(lumen, model, whole, tmp_path):
    points = [option for p in model.outlets["left"][:3] for option in ("--outlet", point(p))]
    done = lumen(whole, tmp_path / "out", *points)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("warning: end without a point left closed") == 2, done.stderr
    summary = json.loads((tmp_path / "out" / "anatomy.json").read_text())
    assert len(summary["ends"]) == 4
    both = [option for t in OUTLETS for option in ("--outlet", point(model.outlets[t][0]))]
    done = lumen(whole, tmp_path / "both", *both)
    assert done.returncode == 2 and "several coronary trees" in done.stderr


def test_open_ends_a_wide_aorta_and_an_aneurysm(check, folder, tmp_path):
    """The aorta is 34 mm wide and open at both ends. The left tree has an aneurysm of 11 mm."""
    found = aorta.Model()
    found.add_aorta(folder, scale=1.1)
    found.add_tree(folder, "left", change=lambda s, r: np.maximum(r, 5.5 * np.exp(-(((s - 165) / 7) ** 2)) * (s > 145)))
    found.add_tree(folder, "right")
    surface = surfaces.write(tmp_path / "open.stl", *found.surface(SPACING, capped=False))
    trees = trees_of(check(surface))
    assert {name: outlets for name, (_, _, outlets) in trees.items()} == OUTLETS


@pytest.mark.long
@pytest.mark.parametrize("lean", [-0.8, 0])
def test_a_closed_stub_is_refused_unless_all_outlets_are_named(check, folder, tmp_path, lean):
    """A side branch of 1 mm is cut off and closed 2.4 mm from its parent's wall. Such an outlet is not found as an end.

    If it leans towards one end of the tree, it stands out only in the distance from the other end.
    """
    found = aorta.Model()
    found.add_aorta(folder)
    found.add_tree(folder, "left")
    axis, radii = aorta.lines(folder, "left")[2]
    at = int(np.searchsorted(aorta.arc_lengths(axis), 120.0))
    along = axis[at + 5] - axis[at - 5]
    aside = np.cross(along, [0.3, 0.5, 0.8])
    aside = aside / np.linalg.norm(aside) + lean * along / np.linalg.norm(along)
    found.balls += [(axis[at] + x * aside, 0.5) for x in np.arange(0, radii[at] + 1.9, 0.1)]
    surface = surfaces.write(tmp_path / "stub.stl", *found.surface(0.3))
    tip = axis[at] + (radii[at] + 2.4) * aside
    done = check(surface)
    assert done.returncode == 2 and "a branch of the coronary tree without an end" in done.stderr, done.stderr
    place = [float(x) for x in done.stderr.split("where:")[1].split("(")[1].split(")")[0].split(",")]
    assert place == pytest.approx(tip, abs=0.6)
    points = [option for p in found.outlets["left"] for option in ("--outlet", point(p))]
    done = check(surface, *points)
    assert done.returncode == 0 and "left closed" in done.stderr, done.stderr


def test_the_only_tree_is_taken(check, folder, tmp_path):
    found = aorta.Model()
    found.add_aorta(folder)
    found.add_tree(folder, "right")
    done = check(surfaces.write(tmp_path / "one.stl", *found.surface(SPACING)))
    ((_, (ostium, _, outlets)),) = trees_of(done).items()
    assert outlets == OUTLETS["right"] and ostium == pytest.approx([13.1, -207.7, 1750.3], abs=1.0)


@pytest.mark.parametrize(
    "main, warned", [((5.0, 5.0), True), ((5.2, 2.0), False)], ids=["as wide at both ends", "narrowing"]
)
def test_an_ectatic_coronary_is_no_aorta(check, tmp_path, main, warned):
    segments = [((0, 0, 0), (60, 0, 0), *main), ((20, 0, 0), (35, 18, 0), 1.5, 1.2)]
    done = check(surfaces.write(tmp_path / "ectatic.stl", *surfaces.tree(segments, spacing=0.3)))
    assert trees_of(done) is None
    assert done.stdout.count("end: an opening") == 3
    assert ("wide vessel taken for a coronary artery" in done.stderr) == warned
    if warned:  # outlets that the user names decide
        assert list(trees_of(check(tmp_path / "ectatic.stl", "--tree", "left"))) == ["tree1"]
        assert "wide vessel" not in check(tmp_path / "ectatic.stl", "--tree", "whole").stderr


def test_a_trunk_without_coronaries_is_no_aorta(check, tmp_path):
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 12 + 0 * s, 80, edge=1.5)
    done = check(surfaces.write(tmp_path / "trunk.stl", points, triangles))
    assert done.returncode == 2 and "implausible scale" in done.stderr
    done = check(tmp_path / "trunk.stl", "--tree", "left")
    assert done.returncode == 2 and "no coronary tree found on the aorta" in done.stderr
