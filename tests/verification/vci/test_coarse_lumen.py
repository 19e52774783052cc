"""A coarse lumen (`coarse_lumen` of a scene) carries the fine one: the engine computes on the coarse surface only.

The results must be those of the fine lumen within about a per cent. A coarse lumen of another vessel is refused.
"""

import json
import subprocess

import numpy as np
import pytest

from common import vtp
from vci.benchmarks import scenes

FINE = scenes.Tube(length=24, edge=0.4, lesion_length=8, curvature=0.06)
COARSE = scenes.Tube(length=24, edge=0.8, lesion_length=8, curvature=0.06)


def deploy(binary, scene, out):
    command = [str(binary("vci")), "deploy", str(scene), "--out", str(out)]
    return subprocess.run(command, text=True, capture_output=True, timeout=200)


def scene_with(folder, fine, coarse, name="scene.json", numerics=None):
    """A scene of the lumen `fine`. Unless `coarse` is None, the lumen of this tube is its `coarse_lumen`."""
    numerics = {"device_edge_mm": 0.8} | (numerics or {})
    path = scenes.write_scene(folder / "fine", fine, length=8.0, numerics=numerics)
    document = json.loads(path.read_text())
    if coarse:
        scenes.write_geometry(folder / "coarse", coarse)
        document["coarse_lumen"] = "../coarse/lumen.vtp"
    path = path.with_name(name)
    path.write_text(json.dumps(document))
    return path


@pytest.fixture(scope="module")
def runs(binary, tmp_path_factory):
    """Folders of two results: on the fine lumen alone, and on the fine lumen carried by the coarse one."""
    folder = tmp_path_factory.mktemp("coarse_lumen")
    for name, coarse in (("alone", None), ("carried", COARSE)):
        result = deploy(binary, scene_with(folder, FINE, coarse, f"{name}.json"), folder / name)
        assert result.returncode == 0, result.stderr[-500:]
    return folder / "alone", folder / "carried"


def outcome(folder):
    return json.loads((folder / "deployment.json").read_text())


def areas(folder):
    return np.array([row["area_mm2"] for row in outcome(folder)["csa_profile"]])


def test_areas_are_those_of_the_fine_lumen(binary, runs, tmp_path):
    """Means over three first steps of the solver: by them the smallest area of one run varies by 0.8 %."""
    found = [tuple(map(areas, runs))]
    for step in (0.28, 0.32):
        folders = [tmp_path / f"{name}_{step}" for name in ("alone", "carried")]
        for folder, coarse in zip(folders, (None, COARSE)):
            scene = scene_with(folder, FINE, coarse, numerics={"initial_step_ms": step})
            result = deploy(binary, scene, folder / "out")
            assert result.returncode == 0, result.stderr[-500:]
        found.append(tuple(areas(folder / "out") for folder in folders))
    alone, carried = (np.array([pair[k] for pair in found]) for k in (0, 1))
    assert carried.mean() == pytest.approx(alone.mean(), rel=0.01)
    assert carried.min(axis=1).mean() == pytest.approx(alone.min(axis=1).mean(), rel=0.01)


def test_the_fine_surface_is_written_and_the_coarse_one_beside_it(runs):
    """lumen.vtp keeps its triangles, and its points lie where the run on the fine lumen has them. The forces are in
    coarse_lumen.vtp, because they act on the coarse surface."""
    before = vtp.read_triangles(runs[0].parent / "fine" / "lumen.vtp", "")
    alone, carried = (vtp.read_triangles(folder / "lumen.vtp", "") for folder in runs)
    assert np.array_equal(vtp.triangles(carried), vtp.triangles(before))
    distances = np.linalg.norm(vtp.points(carried) - vtp.points(alone), axis=1)
    # Sideways only the soft tissue holds the vessel, so sections of the two runs lie a few hundredths of a mm apart.
    assert np.sqrt(np.mean(distances**2)) < 0.04
    names = {
        data.GetPointData().GetArrayName(k)
        for data in [carried]
        for k in range(data.GetPointData().GetNumberOfArrays())
    }
    assert {"displacement_mm", "wall_stretch", "malapposition_mm"} <= names and "contact_n" not in names
    computed = vtp.read_triangles(runs[1] / "coarse_lumen.vtp", "")
    assert (
        computed.GetPointData().GetArray("contact_n")
        and computed.GetNumberOfPoints() < 0.4 * carried.GetNumberOfPoints()
    )
    assert not (runs[0] / "coarse_lumen.vtp").exists()


def test_the_stent_is_read_out_as_on_the_fine_lumen(runs):
    alone, carried = (outcome(folder)["stents"][0] for folder in runs)
    assert carried["expansion_index"] == pytest.approx(alone["expansion_index"], rel=0.015)


class TubePart(scenes.Tube):
    """The tube COARSE between the arc lengths `begin` and `end` (mm)."""

    def __init__(self, begin, end):
        super().__init__(length=end - begin, edge=COARSE.edge)
        object.__setattr__(self, "begin", begin)

    def lumen_radius(self, s):
        return COARSE.lumen_radius(s + self.begin)

    def frames(self, s):
        return COARSE.frames(s + self.begin)


@pytest.mark.parametrize(
    "other", [scenes.Tube(length=24, edge=0.8, lesion_length=8), TubePart(0, 20)], ids=["straight", "shorter by 4 mm"]
)
def test_another_vessel_is_refused_before_any_stage(binary, tmp_path, other):
    """A point of the lumen is farther than a radius from the coarse wall, which therefore cannot carry this point. The
    exit code is 2, and there are no results."""
    result = deploy(binary, scene_with(tmp_path, FINE, other), tmp_path / "out")
    assert result.returncode == 2 and "residual" not in result.stderr
    assert "coarse_lumen is not this lumen on longer edges" in result.stderr, result.stderr[-500:]
    assert not (tmp_path / "out" / "deployment.json").exists()


def test_a_lumen_that_is_a_little_shorter_carries_it(binary, tmp_path, runs):
    """The coarse lumen ends 1 mm before the lumen at both ends. The areas of the segment must stay the same."""
    result = deploy(binary, scene_with(tmp_path, FINE, TubePart(1, 23)), tmp_path / "out")
    assert result.returncode == 0, result.stderr[-500:]
    assert areas(tmp_path / "out").mean() == pytest.approx(areas(runs[0]).mean(), rel=0.01)


def test_a_missing_file_is_named(binary, tmp_path):
    scene = scene_with(tmp_path, FINE, COARSE)
    (tmp_path / "coarse" / "lumen.vtp").unlink()
    result = deploy(binary, scene, tmp_path / "out")
    assert result.returncode == 2 and "coarse" in result.stderr and "lumen.vtp" in result.stderr
