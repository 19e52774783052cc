"""The whole reference on a small patient: results are plausible and repeatable, and unfit inputs are refused."""

import json
import pathlib

import numpy as np
import pytest

from common import vtp
from data_synthetic import __main__ as command
from data_synthetic import generate, truth

pytestmark = pytest.mark.slow

ROOT = pathlib.Path(__file__).resolve().parents[3]


def balloon(length, diameter, growth):
    """A balloon with `diameter` at 10 bar. 6 bar more or less change the diameter by the share `growth`."""
    chart = {"pressure_bar": [4, 10, 16], "diameter_mm": [diameter * (1 - growth), diameter, diameter * (1 + growth)]}
    return {"kind": "balloon", "length_mm": length, "shoulder_mm": 1.5, "chart": chart}


@pytest.fixture(scope="module")
def patient(tmp_path_factory):
    """Folder with source/ of the case severe_focal, a scene at its lesion, and coarse settings."""
    root = tmp_path_factory.mktemp("patient")
    document = generate.run(ROOT / "tests/verification/data_synthetic/cases/severe_focal.yaml", root / "source")
    centre = document["branches"][0]["lesions"][0]["true_s_mla_mm"]
    stent = {
        "kind": "stent",
        "balloon": "delivery",
        "length_mm": 12.0,
        "nominal_diameter_mm": 3.0,
        "crimped_diameter_mm": 1.0,
        "recoil_percent": 4.0,
        "radial_strength_mpa": 0.2,
        "bending_stiffness_n_mm2": 20.0,
    }

    def step(action, device, pressure):
        use = {"device": device, "branch": "main", "centre_s_mm": centre, "pressure_bar": pressure}
        return {"name": action, "action": action, "devices": [use]}

    scene = {
        "schema": "vci-scene-1",
        "case": "quick_focal",
        "devices": {"sc": balloon(12.0, 2.5, 0.06), "delivery": balloon(12.0, 3.25, 0.04), "des": stent},
        "procedure": [step("predilatation", "sc", 10), step("stent", "des", 12)],
    }
    (root / "scene.json").write_text(json.dumps(scene))
    (root / "settings.yaml").write_text(
        "{slice_spacing_mm: 1.5, elements_around: 12, elements_through: 3, radius_step_mm: 0.2, check_slices: 1}\n"
    )
    return root


def run(root, out, scene="scene.json"):
    arguments = ["reference", "--scene", root / scene, "--anatomy", root / "source", "--out", root / out]
    arguments += ["--truth", root / "source/truth.json", "--settings", root / "settings.yaml"]
    command.main([str(a) for a in arguments])
    return root / out


@pytest.fixture(scope="module")
def treated(patient):
    return run(patient, "reference")


def test_the_lesion_is_opened_as_in_patients(treated):
    found = json.loads((treated / "reference.json").read_text())
    held = [r for r in found["slices"] if r["stented"]]
    tightest = min(held, key=lambda r: r["radius_before_mm"])
    inflated = tightest["history"][-1]["inflated_radius_mm"]
    assert tightest["radius_before_mm"] < 0.6 < 1.2 < tightest["area_mm2"] ** 0.5 / np.pi**0.5 < inflated
    # Predilatation alone opens the lesion part of the way, and elastic tissue recoils.
    after_pre = tightest["history"][0]
    assert tightest["radius_before_mm"] < after_pre["radius_mm"] < after_pre["inflated_radius_mm"] < 1.25
    assert 2 < found["recoil_percent"] < 9
    # The stent has a waist at the plaque: its ends are wider than its middle.
    assert tightest["area_mm2"] < min(held[0]["area_mm2"], held[-1]["area_mm2"])
    own = found["error_estimate"]
    assert own["mesh_and_step_area_percent"] < 2
    (checked,) = own["slices"]
    both = (1 + checked["step_percent"] / 100) * (1 + checked["mesh_percent"] / 100)
    assert checked["mesh_and_step_percent"] == pytest.approx(100 * (both - 1), abs=1e-9)
    assert 0 < abs(checked["step_percent"]) < 1 and 0 < abs(checked["mesh_percent"]) < 2


def test_surface_is_closed_moved_in_the_stent_and_at_rest_at_the_ends(treated, patient):
    poly = vtp.read_triangles(treated / "lumen.vtp", "")
    points, triangles = vtp.points_and_triangles(poly)
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert set(map(tuple, directed)) == set(map(tuple, directed[:, ::-1]))
    main = truth.load(patient / "source/truth.json")[0][0]
    s = main.axis.nearest(points)
    ends = (s < 0.01) | (s > main.axis.length_mm - 0.01)
    before = vtp.points(vtp.read(patient / "source/lumen.vtp", ""))
    moved = np.linalg.norm(points[: len(before)] - before, axis=1)
    assert moved[ends[: len(before)]].max() < 1e-9 and moved.max() > 0.8
    names = {poly.GetPointData().GetArrayName(i) for i in range(poly.GetPointData().GetNumberOfArrays())}
    assert {"plaque_thickness_mm", "plaque_type", "displacement_mm"} <= names
    found = json.loads((treated / "reference.json").read_text())
    middle = min((r for r in found["slices"] if r["stented"]), key=lambda r: r["radius_before_mm"])
    near = np.abs(s - middle["s_mm"]) < 0.3
    centre = points[near].mean(axis=0)
    radius = np.linalg.norm(points[near] - centre, axis=1).mean()
    assert radius == pytest.approx(np.sqrt(middle["area_mm2"] / np.pi), rel=0.02)


def test_same_input_same_bits(treated, patient):
    again = run(patient, "again")
    assert (again / "lumen.vtp").read_bytes() == (treated / "lumen.vtp").read_bytes()
    one, two = (json.loads((folder / "reference.json").read_text()) for folder in (treated, again))
    one.pop("seconds"), two.pop("seconds")
    assert one == two


def test_a_device_beyond_the_vessel_is_refused_and_nothing_written(patient, capsys):
    scene = json.loads((patient / "scene.json").read_text())
    scene["procedure"][1]["devices"][0]["centre_s_mm"] = 36.0
    (patient / "bad.json").write_text(json.dumps(scene))
    with pytest.raises(SystemExit) as caught:
        run(patient, "bad", "bad.json")
    assert caught.value.code == 2 and "procedure[2].devices[1].centre_s_mm" in capsys.readouterr().err
    assert not (patient / "bad").exists()


def test_the_lumen_of_another_vessel_is_refused(patient, tmp_path, capsys):
    lumen = vtp.read(patient / "source/lumen.vtp", "")
    moved = vtp.surface(vtp.points(lumen) + [0, 0, 0.2], vtp.triangles(lumen))
    vtp.write(tmp_path / "lumen.vtp", moved)
    arguments = ["--scene", patient / "scene.json", "--anatomy", tmp_path, "--truth", patient / "source/truth.json"]
    with pytest.raises(SystemExit) as caught:
        command.main([str(a) for a in ["reference", *arguments, "--out", tmp_path / "out"]])
    assert caught.value.code == 2 and "lumen.vtp" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_slices_are_near_a_coarse_solid_in_three_dimensions(patient):
    """The command on a mesh that takes seconds. The differences on finer meshes are in measured.md."""
    arguments = ["reference-3d", "--scene", patient / "scene.json", "--truth", patient / "source/truth.json"]
    arguments += ["--settings", patient / "settings.yaml", "--meshes", "6x2x3", "--out", patient / "solid"]
    command.main([str(a) for a in arguments])
    found = json.loads((patient / "solid/slices_vs_3d.json").read_text())
    (solid,) = found["solids"]
    s, before, slices, area = (
        np.array(v) for v in (found["s_mm"], found["area_before_mm2"], found["slices"]["area_mm2"], solid["area_mm2"])
    )
    tightest = np.argmin(before)
    assert area[tightest] > 3.5 * before[tightest]
    assert slices[tightest] == pytest.approx(area[tightest], rel=0.02)
    assert abs(solid["slices_against_it"]["minimal_lumen_area_in_stent_percent"]) < 2
    assert solid["slices_against_it"]["stent_area_percent"]["rms"] < 3
    assert abs(solid["slices_against_it"]["resistance_percent"]) < 3


@pytest.mark.parametrize("mesh", ["8x3", "5x3x2", "8x3x0.1", "8x3x2x1", "axbxc"])
def test_a_mesh_that_is_none_is_refused(patient, mesh, capsys):
    arguments = ["reference-3d", "--scene", patient / "scene.json", "--truth", patient / "source/truth.json"]
    with pytest.raises(SystemExit) as caught:
        command.main([str(a) for a in [*arguments, "--meshes", mesh, "--out", patient / "none"]])
    assert caught.value.code == 2 and "--meshes" in capsys.readouterr().err
    assert not (patient / "none").exists()
