"""The shipped bifurcation bench, a culotte.

A stent lies across a side branch, a second stent goes through its side into the branch, and kissing balloons follow.
"""

import json
import subprocess

import numpy as np
import pytest
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp

pytestmark = pytest.mark.slow

EDGES_MM = [0.4, 0.6]  # the study's edge is 0.4 mm
DEEPEST_MM = 0.05  # limit of the penetration in hard cases


@pytest.fixture(scope="module", params=EDGES_MM)
def culotte(request, binary, run_module, repo_root, tmp_path_factory):
    """Folder of the results of config/cases/culotte_bench.yaml, with the lumen remeshed to an edge of EDGES_MM."""
    edge = request.param
    folder = tmp_path_factory.mktemp("culotte")
    case, anatomy, plan = (
        repo_root / "config/cases/culotte_bench.yaml",
        folder / "anatomy",
        folder / "vci" / "plan.json",
    )

    def call(command):
        result = subprocess.run([str(c) for c in command], text=True, capture_output=True, timeout=400)
        assert result.returncode == 0, result.stderr

    generated = run_module("data_synthetic", "generate", case, "--out", folder / "source", timeout=200)
    assert generated.returncode == 0, generated.stderr
    call([binary("lumen"), "process", folder / "source/lumen.vtp", "--units", "mm", "--edge", edge, "--out", anatomy])
    devices = repo_root / "config" / "devices"
    planned = run_module("anatomy", "plan", case, "--anatomy", anatomy, "--devices", devices, "--out", plan, timeout=60)
    assert planned.returncode == 0, planned.stderr
    call([binary("vci"), "deploy", plan, "--out", folder / "out", "--frames", folder / "out" / "frames"])
    return folder / "out"


def close_ends(surface):
    """A device's tube with its ends closed and its normals outwards."""
    holes, normals = vtk.vtkFillHolesFilter(), vtk.vtkPolyDataNormals()
    holes.SetInputData(surface)
    holes.SetHoleSize(1e3)
    normals.SetInputConnection(holes.GetOutputPort())
    normals.AutoOrientNormalsOn()
    normals.SplittingOff()
    normals.Update()
    return normals.GetOutput()


def signed_distances(points, surface):
    """Signed distances (mm) of the points of one surface from another surface, positive outside."""
    field = vtk.vtkImplicitPolyDataDistance()
    field.SetInput(surface)
    return np.array([field.EvaluateFunction(p) for p in vtk_to_numpy(points.GetPoints().GetData())])


def test_every_stage_balances(culotte):
    stages = json.loads((culotte / "deployment.json").read_text())["stages"]
    assert len(stages) == 15
    assert max(s["residual"] for s in stages) <= 3e-3
    assert max(s["mean_penetration_mm"] for s in stages) <= 0.05 * 0.0125  # a twentieth of the contact distance


def test_nothing_is_pierced(culotte):
    stages = json.loads((culotte / "deployment.json").read_text())["stages"]
    assert max(s["max_penetration_mm"] for s in stages) <= DEEPEST_MM


def test_no_device_leaves_the_lumen_in_any_stage(culotte):
    """Checks all vertices of balloons and stents at the end of each stage, from the frames."""
    stages = json.loads((culotte / "deployment.json").read_text())["stages"]
    furthest, seen = {}, 0
    for n in range(len(stages)):
        lumen = vtp.read(culotte / "frames" / f"frame_lumen_{n:04d}.vtp", "")
        for device in sorted((culotte / "frames").glob(f"frame_device*_{n:04d}.vtp")):
            distance = signed_distances(vtp.read(device, ""), lumen)
            furthest[f"{stages[n]['step']} / {stages[n]['stage']}, {device.stem}"] = distance.max()
            seen += 1
            assert distance.min() < -0.5, "the sign says which side is out"
    assert seen > len(stages), "balloons with stents"
    worst = max(furthest, key=furthest.get)
    assert furthest[worst] < 0.05, f"{furthest[worst]:.3f} mm outside: {worst}"


def test_kissing_balloons_press_on_one_another_without_overlapping(culotte):
    one, other = (vtp.read(culotte / "devices" / f"kissing_balloon{k}.vtp", "") for k in (1, 2))
    distance = np.concatenate([signed_distances(one, close_ends(other)), signed_distances(other, close_ends(one))])
    assert distance.min() > -0.03, "mm; contact begins at 0.0125"
    assert (distance < 0.05).sum() > 10, "they touch"


def test_both_stents_lie_in_the_lumen_and_the_second_begins_in_the_first(culotte):
    lumen = vtp.read(culotte / "lumen.vtp", "")
    first, second = (vtp.read(culotte / "devices" / f"stent{k}.vtp", "") for k in (1, 2))
    for stent in (first, second):
        assert signed_distances(stent, lumen).max() < 0.05
    inside = signed_distances(second, close_ends(first)) < 0.1
    assert 0.15 < inside.mean() < 0.85, "part of it lies in the main branch's stent, part has left it"
