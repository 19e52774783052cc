"""The baseline `numerics.integration: textbook`, mass-spring walls, and the frames of a run."""

import json
import subprocess
import xml.etree.ElementTree

import numpy as np
import pytest
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from vci.benchmarks import scenes

TUBE = scenes.Tube(length=24, edge=0.5, lesion_length=8)


def deploy(program, folder, *options, steps=1, numerics=None, wall=None):
    """deployment.json of a small tube with a predilatation and, for two steps, a stent; options go to the program."""
    # Textbook integration moves the whole vessel and refuses a region margin.
    numerics = numerics or {"region_margin_mm": 2}
    scene = scenes.write_scene(folder, TUBE, numerics=numerics, wall=wall)
    document = json.loads(scene.read_text())
    document["procedure"] = document["procedure"][:steps]
    scene.write_text(json.dumps(document))
    command = [str(program), "deploy", str(scene), "--out", str(folder / "out"), *map(str, options)]
    result = subprocess.run(command, text=True, capture_output=True, timeout=300)
    assert result.returncode == 0, result.stderr
    return json.loads((folder / "out" / "deployment.json").read_text())


def mean_area(result):
    return np.mean([row["area_mm2"] for row in result["csa_profile"]])


@pytest.fixture(scope="module")
def adaptive(binary, tmp_path_factory):
    folder = tmp_path_factory.mktemp("adaptive")
    return deploy(binary("vci"), folder, "--frames", folder / "frames", "--frames-every", 20), folder


def test_textbook_takes_the_whole_vessel_and_many_more_steps(binary, tmp_path, adaptive):
    usual, _ = adaptive
    numerics = {"integration": "textbook", "maximal_steps_per_stage": 5000}
    baseline = deploy(binary("vci"), tmp_path, numerics=numerics)
    assert baseline["wall_vertices"] > usual["wall_vertices"]
    steps, usual_steps = (sum(s["steps"] for s in r["stages"]) for r in (baseline, usual))
    assert steps > 2 * usual_steps
    assert mean_area(baseline) == pytest.approx(mean_area(usual), rel=0.08)
    assert all(s["residual"] < 1 for s in baseline["stages"]), "reported beside the velocity stop"


def test_textbook_that_does_not_come_to_rest_is_refused(binary, tmp_path):
    scene = scenes.write_scene(tmp_path, TUBE, numerics={"integration": "textbook", "maximal_steps_per_stage": 5})
    command = [str(binary("vci")), "deploy", str(scene), "--out", str(tmp_path / "out")]
    result = subprocess.run(command, text=True, capture_output=True, timeout=100)
    assert result.returncode == 3 and "predilatation / deployment-to-contact" in result.stderr


@pytest.mark.parametrize("mapping", ["lame", "van_gelder"])
def test_springs_carry_a_whole_deployment(binary, tmp_path, mapping):
    usual = deploy(binary("vci"), tmp_path / "membrane", steps=2)
    springs = deploy(
        binary("vci"), tmp_path / "springs", steps=2, wall={"model": "mass-spring", "spring_mapping": mapping}
    )
    assert all(s["residual"] <= 3e-3 for s in springs["stages"])
    assert mean_area(springs) == pytest.approx(mean_area(usual), rel=0.08)
    assert mean_area(springs) != mean_area(usual)


def test_frames_show_each_stage_and_every_nth_step(adaptive):
    result, folder = adaptive
    listed = xml.etree.ElementTree.parse(folder / "frames" / "frames.pvd").getroot().findall(".//DataSet")
    frames = {float(entry.get("timestep")) for entry in listed}
    expected = sum(1 + s["steps"] // 20 for s in result["stages"])
    assert len(frames) == expected
    lumens = [entry.get("file") for entry in listed if entry.get("name") == "lumen"]
    assert len(lumens) == expected
    first, last = (vtp.read(folder / "frames" / lumens[k], "") for k in (0, -1))
    final = vtp.read(folder / "out" / "lumen.vtp", "")
    assert last.GetPoint(last.GetNumberOfPoints() // 2) == final.GetPoint(final.GetNumberOfPoints() // 2)
    assert first.GetPoint(first.GetNumberOfPoints() // 2) != last.GetPoint(last.GetNumberOfPoints() // 2)
    assert any(entry.get("name") == "device1" for entry in listed)


def area_vectors(surface):
    """(n, 3): for each vertex a third of the sum of the area vectors (mm2) of the triangles round it."""
    points = vtk_to_numpy(surface.GetPoints().GetData())
    triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    areas = np.zeros_like(points)
    for k in range(3):
        np.add.at(areas, triangles[:, k], np.cross(b - a, c - a) / 6)
    return areas


def test_frames_have_the_forces_of_their_states(adaptive):
    """The forces of each frame belong to the shape of this frame.

    A balloon's pressure forces are proportional to its area vectors. Contact forces sum to zero. At the end of a stage
    the residual of the forces is the reported one. The forces of the last frame are those of the result.
    """
    result, folder = adaptive
    listed = xml.etree.ElementTree.parse(folder / "frames" / "frames.pvd").getroot().findall(".//DataSet")
    states = {}
    for entry in listed:
        surface = vtp.read(folder / "frames" / entry.get("file"), "")
        names = ("pressure_n", "contact_n", "foundation_n", "residual_n")
        forces = {name: vtk_to_numpy(surface.GetPointData().GetArray(name)) for name in names}
        if entry.get("name") == "device1":
            area = area_vectors(surface)
            pressure = (forces["pressure_n"] * area).sum() / (area * area).sum()
            assert pressure > 0.1 and np.allclose(forces["pressure_n"], pressure * area, atol=1e-9)
        states.setdefault(int(entry.get("timestep")), {})[entry.get("name")] = forces
    final = vtp.read(folder / "out" / "lumen.vtp", "").GetPointData()
    last = states[max(states)]["lumen"]
    for name, values in last.items():
        assert np.array_equal(values, vtk_to_numpy(final.GetArray(name)))
    unbalanced = []
    for state in states.values():
        total = {name: np.concatenate([forces[name] for forces in state.values()]) for name in last}
        applied = np.linalg.norm(total["pressure_n"] + total["contact_n"] + total["foundation_n"])
        unbalanced.append(np.linalg.norm(total["residual_n"]) / applied)
        assert np.linalg.norm(total["contact_n"].sum(axis=0)) <= 1e-6 * np.abs(total["contact_n"]).sum()
    ends = np.cumsum([1 + s["steps"] // 20 for s in result["stages"]]) - 1
    assert all(unbalanced[k] == pytest.approx(s["residual"], rel=1e-3) for k, s in zip(ends, result["stages"]))
    assert max(unbalanced) > 3e-3, "amid a stage forces do not balance yet"
    assert sum(np.abs(state["lumen"]["contact_n"]).sum() > 0 for state in states.values()) >= 2
