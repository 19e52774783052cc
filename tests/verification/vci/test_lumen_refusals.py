"""Lumens and centrelines that belong to no vessel are refused by `vci deploy` before any work, with one clear error."""

import json
import subprocess

import numpy as np
import pytest
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from vci.benchmarks import scenes

TUBE = scenes.Tube(length=24, edge=0.8, lesion_length=6)


@pytest.fixture
def scene(tmp_path):
    """Path of scene.json beside lumen.vtp and centreline.vtp."""
    return scenes.write_scene(tmp_path / "case", TUBE, length=8.0, numerics={"device_edge_mm": 1.0})


def refusal(binary, scene, command="deploy"):
    out = scene.parent / "out"
    run = [str(binary("vci")), command, str(scene), "--out", str(out)]
    result = subprocess.run(run, text=True, capture_output=True, timeout=100)
    assert result.returncode == 2, (result.returncode, result.stderr[-500:])
    lines = result.stderr.splitlines()
    starts = ["error: ", "  where:  ", "  value:  ", "  remedy: "]
    assert len(lines) == 4 and all(line.startswith(s) for line, s in zip(lines, starts)), result.stderr
    assert list(out.rglob("*")) == [], "nothing is written"
    return result.stderr


def rewrite_lumen(scene, change):
    """Replaces lumen.vtp by change(points, triangles, arrays of the points) -> (points, triangles)."""
    path = scene.parent / "lumen.vtp"
    before = vtp.read(path, "")
    arrays = {
        name: vtk_to_numpy(before.GetPointData().GetArray(name)).copy()
        for name in ("radius_mm", "plaque_thickness_mm", "plaque_type")
    }
    triangles = vtk_to_numpy(before.GetPolys().GetConnectivityArray()).reshape(-1, 3).copy()
    points, triangles = change(vtp.points(before).copy(), triangles, arrays)
    after = scenes.polydata(points, triangles)
    vtp.add_array(after.GetCellData(), "region_id", np.zeros(len(triangles), dtype=np.int32))
    for name, values in arrays.items():
        vtp.add_array(after.GetPointData(), name, values)
    vtp.write(path, after)


def all_flipped(points, triangles, arrays):
    return points, triangles[:, ::-1]


def one_flipped(points, triangles, arrays):
    triangles[500] = triangles[500, ::-1]
    return points, triangles


def triangle_soup(points, triangles, arrays):
    for name in arrays:
        arrays[name] = arrays[name][triangles].ravel()
    return points[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)


def with_hole(points, triangles, arrays):
    centres = points[triangles].mean(1)
    return points, triangles[(abs(centres[:, 2] - 18) > 0.8) | (centres[:, 0] < 0.3)]


def triangles_repeated(points, triangles, arrays):
    return points, np.concatenate([triangles, triangles[300:310]])


def in_metres(points, triangles, arrays):
    return points / 1000, triangles


def radius_five_times(points, triangles, arrays):
    arrays["radius_mm"] *= 5
    return points, triangles


def shifted_aside(points, triangles, arrays):
    return points + [1.0, 0, 0], triangles


def cut_short(points, triangles, arrays):
    return points, triangles[points[triangles].mean(1)[:, 2] < 14]


@pytest.mark.parametrize(
    "change, words",
    [
        (all_flipped, "face its axis"),
        (one_flipped, "triangle 500 at"),
        (triangle_soup, "in one place"),
        (with_hole, "has a hole"),
        (triangles_repeated, "given twice"),
        (in_metres, "does not fit its radius_mm"),
        (radius_five_times, "does not fit its radius_mm"),
        (shifted_aside, "does not fit its radius_mm"),
        (cut_short, "past the end of the lumen"),
    ],
)
def test_a_lumen_that_no_vessel_has(binary, scene, change, words):
    rewrite_lumen(scene, change)
    for command in ("deploy", "radius-correct"):
        assert words in refusal(binary, scene, command)


def assert_accepted(binary, scene):
    run = [str(binary("vci")), "radius-correct", str(scene), "--out", str(scene.parent / "out")]
    result = subprocess.run(run, text=True, capture_output=True, timeout=100)
    assert result.returncode == 0, result.stderr
    assert json.loads((scene.parent / "out" / "deployment.json").read_text())["csa_profile"]


def test_a_scene_of_the_sound_lumen_runs(binary, scene):
    """The refusals above are not due to the scene or to rewriting: a lumen rewritten without a change passes."""
    rewrite_lumen(scene, lambda points, triangles, arrays: (points, triangles))
    assert_accepted(binary, scene)


@pytest.mark.parametrize(
    "tube",
    [
        {"length": 12, "radius": 2.5, "stenosis": 0.95, "lesion_length": 4, "eccentricity": 1, "edge": 1.2},
        {"length": 24, "stenosis": 0.9, "eccentricity": 1, "edge": 0.8, "curvature": 0.12},
        {"length": 24, "curvature": 0.4, "edge": 0.5, "jitter": 0.35},
        {"length": 24, "radius": 0.8, "stenosis": 0.7, "edge": 0.4, "sliver": 0.9},
    ],
)
def test_severe_lesions_bends_and_poor_meshes_pass(binary, tmp_path, tube):
    assert_accepted(binary, scenes.write_scene(tmp_path, scenes.Tube(**tube), length=8.0))


SIDE = np.array([[0, 0, 8.0], [2, 0, 9], [5, 0, 11], [9, 0, 14]])


def centreline(scene, *lines):
    """Replaces centreline.vtp by (name, points) of branches."""
    starts = np.cumsum([0] + [len(points) for _, points in lines])
    cells = [range(a, b) for a, b in zip(starts, starts[1:])]
    line = scenes.polydata(np.concatenate([points for _, points in lines]), cells, lines=True)
    names = vtk.vtkStringArray()
    names.SetName("branch_name")
    for name, _ in lines:
        names.InsertNextValue(name)
    line.GetCellData().AddArray(names)
    vtp.write(scene.parent / "centreline.vtp", line)


def axis():
    return TUBE.centre(np.linspace(0, TUBE.length, 97))


def test_two_branches_of_one_name(binary, scene):
    centreline(scene, ("main", axis()), ("main", axis()[:40]))
    assert "two branches of the centreline have one name" in refusal(binary, scene)
    centreline(scene, ("main", axis()), ("side1", SIDE), ("side1", SIDE))
    message = refusal(binary, scene)
    assert "two branches of the centreline have one name" in message and "side1" in message


def test_a_side_branch_that_ends_at_its_parent(binary, scene):
    centreline(scene, ("main", axis()), ("side1", SIDE[::-1]))
    assert "does not start at its parent" in refusal(binary, scene)
    centreline(scene, ("main", axis()), ("side1", SIDE))
    assert "branch side1" in refusal(binary, scene), "the lumen has no such branch"


def test_a_line_whose_points_are_out_of_order(binary, scene):
    points = axis()
    points[40:50] = points[40:50][::-1].copy()
    centreline(scene, ("main", points))
    assert "turns back on itself" in refusal(binary, scene)


@pytest.mark.parametrize("key", ["lumen", "centreline"])
@pytest.mark.parametrize("name, words", [(".", "a folder"), ("", "a folder"), ("scene.json", "PolyData")])
def test_a_path_that_is_no_polydata(binary, scene, key, name, words):
    scene.write_text(json.dumps(json.loads(scene.read_text()) | {key: name}))
    message = refusal(binary, scene)
    assert words in message and f"the {key}" in message


def test_a_file_cut_short_is_one_error(binary, scene):
    content = (scene.parent / "lumen.vtp").read_bytes()
    (scene.parent / "lumen.vtp").write_bytes(content[: len(content) * 2 // 3])
    assert "the lumen cannot be read" in refusal(binary, scene)


@pytest.mark.parametrize("name", ["region_id", "branch_id"])
@pytest.mark.parametrize("value", [np.nan, 0.5, 1e300, [0.0, 0.0, 0.0]])
def test_arrays_of_cells_hold_whole_numbers(binary, scene, name, value):
    path = scene.parent / "lumen.vtp"
    lumen = vtp.read(path, "")
    vtp.add_array(lumen.GetCellData(), name, np.array([value] * lumen.GetNumberOfCells()))
    vtp.write(path, lumen)
    assert f"{name} of cell 0" in refusal(binary, scene)


def test_a_branch_of_whole_numbers_is_accepted_as_any_number(binary, scene):
    """The branch_id of a single branch may be any whole number, and may be stored as floating point."""
    path = scene.parent / "lumen.vtp"
    lumen = vtp.read(path, "")
    vtp.add_array(lumen.GetCellData(), "branch_id", np.full(lumen.GetNumberOfCells(), -3.0))
    vtp.write(path, lumen)
    run = [str(binary("vci")), "radius-correct", str(scene), "--out", str(scene.parent / "out")]
    assert subprocess.run(run, text=True, capture_output=True, timeout=100).returncode == 0
