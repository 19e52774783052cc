"""The quicker ones of the hard cases: each must end in force balance, with bounded penetration."""

import csv
import json
import subprocess

import numpy as np
import pytest

from vci.benchmarks.hard_cases import CASE_NAMES, CASES, MEAN_LIMIT_MM, WORST_LIMIT_MM
from vci.benchmarks.scenes import Tube, write_scene

TOLERANCE = 3e-3
# In these cases few vertices carry the contact load. The one-sided law lets a vertex penetrate according to its load.
# The mean penetration is therefore above its limit.
ABOVE_MEAN_LIMIT = {
    "stenosis 90 %",
    "calcium x1000, concentric, 0.5 mm",
    "90 %, eccentric, calcium x1000",
    "90 %, eccentric, calcium x1000, 0.4 mm",
    "80 %, eccentric, calcium x30",
    "curvature 0.3 /mm",
}


@pytest.fixture(scope="module")
def table(binary, run_module, tmp_path_factory):
    """table(names) -> rows of hard_cases.csv by case; computed once."""
    computed = {}

    def rows(names):
        missing = [n for n in names if n not in computed]
        if missing:
            out = tmp_path_factory.mktemp("hard")
            build = binary("vci").parent
            result = run_module(
                "vci.benchmarks.hard_cases", "--out", out, "--build", build, "--only", *missing, timeout=600
            )
            assert result.returncode == 0, result.stderr
            with (out / "hard_cases.csv").open() as file:
                computed.update({row["case"]: row for row in csv.DictReader(file)})
        return {n: computed[n] for n in names}

    return rows


# Cases with edges of 0.25 mm take three times as long. The culotte has its own tests.
QUICK_CASES = [case for case in CASE_NAMES if "0.25 mm" not in case and case != "culotte"]


def deploy_in_calcium(binary, folder, bar):
    """The finished `vci deploy` of a stent in calcium round 270 degrees that never yields, all inflations at `bar`."""
    scene = write_scene(
        folder,
        Tube(stenosis=0.7, eccentricity=0.5, calcium_deg=270),
        wall={"plaque": {"calcified": {"youngs_modulus_mpa": 30, "yield_strain": None}}},
        pressures=(bar, bar, bar),
    )
    command = [binary("vci"), "deploy", scene, "--out", folder / "out"]
    return subprocess.run(command, capture_output=True, text=True)


@pytest.mark.slow
def test_calcium_round_270_degrees_opens_more_at_each_pressure(binary, tmp_path):
    """Earlier engines refused 14, 15 or 16 bar between pressures that balance."""
    areas = []
    for bar in (12, 13, 14, 15, 16):
        result = deploy_in_calcium(binary, tmp_path / f"{bar}", bar)
        assert result.returncode == 0, result.stderr
        areas.append(
            json.loads((tmp_path / f"{bar}" / "out" / "deployment.json").read_text())["minimal_lumen_area_mm2"]
        )
    assert np.all(np.diff(areas) > 0.05)


@pytest.mark.slow
@pytest.mark.parametrize("case", QUICK_CASES)
def test_case_balances(table, case):
    row = table([case])[case]
    assert row["outcome"] == "balanced", row["reason"]
    assert 0 < float(row["residual"]) <= TOLERANCE


@pytest.mark.parametrize("case", QUICK_CASES)
def test_no_vertex_is_deep(table, case):
    assert float(table([case])[case]["worst_penetration_mm"]) <= WORST_LIMIT_MM


@pytest.mark.slow
def test_the_first_step_does_not_decide_the_areas(binary, run_module, tmp_path):
    options = ["--only", "ordinary", "--first-steps", 0.27, 0.34, "--build", binary("vci").parent, "--out", tmp_path]
    result = run_module("vci.benchmarks.hard_cases", *options, timeout=300)
    assert result.returncode == 0, result.stderr
    with (tmp_path / "first_steps.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert (row["runs"], row["refused"], row["folded"]) == ("2", "0", "0")
    assert 0 < float(row["mean_area_spread_percent"]) < 0.3, "another first step takes another path to the same end"


@pytest.mark.parametrize("limit", [0.03, 0.04])
def test_a_stage_ends_only_when_no_vertex_is_deeper_than_asked(binary, tmp_path, limit):
    """Without `maximal_penetration_mm` the deepest vertex of this case is 0.041 to 0.051 mm deep. The depth varies with
    the length of the first step and with the processor."""
    tube, scene_options = CASES["90 %, eccentric, calcium x1000"]
    scene = write_scene(tmp_path, tube, **(scene_options | {"numerics": {"maximal_penetration_mm": limit}}))
    command = [binary("vci"), "deploy", scene, "--out", tmp_path / "out"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr
    stages = json.loads((tmp_path / "out" / "deployment.json").read_text())["stages"]
    assert 0.02 < max(stage["max_penetration_mm"] for stage in stages) <= limit


def expected_failures(cases, failing):
    """Test parameters for the cases. Those in `failing` are expected to break their limit."""
    mark = pytest.mark.xfail(strict=True, reason="deeper than wanted: vci/measured.md")
    return [pytest.param(case, marks=mark if case in failing else ()) for case in cases]


@pytest.mark.parametrize("case", expected_failures(QUICK_CASES, ABOVE_MEAN_LIMIT))
def test_mean_penetration_is_small(table, case):
    row = table([case])[case]
    assert float(row["mean_penetration_mm"]) <= MEAN_LIMIT_MM
    assert row["within_limits"] == "yes"


def test_ordinary_contact_is_thinner_than_its_threshold(table):
    row = table(["ordinary"])["ordinary"]
    assert float(row["worst_penetration_mm"]) <= 0.0125


def test_a_refusal_is_a_row_with_its_reason(binary, run_module, tmp_path):
    """A scene that cannot balance in one step is refused. The table names the stage."""
    scene = write_scene(tmp_path / "scene", Tube(edge=0.8), numerics={"maximal_steps_per_stage": 1})
    arguments = ["--out", tmp_path / "out", "--build", binary("vci").parent, "--only", "slivers", "--scenes", scene]
    result = run_module("vci.benchmarks.hard_cases", *arguments, timeout=300)
    assert result.returncode == 0, result.stderr
    with (tmp_path / "out" / "hard_cases.csv").open() as file:
        row = list(csv.DictReader(file))[-1]
    assert row["outcome"] == "refused" and "predilatation / deployment-to-contact" in row["reason"]
    assert row["minimal_area_mm2"] == ""


@pytest.mark.parametrize("curvature", [0, 0.12, 0.3])
@pytest.mark.parametrize("eccentricity", [0, 0.8])
def test_generated_tube(curvature, eccentricity):
    """Triangles face outwards. The throat's radius, the thickest plaque and the axis's curvature are as asked for."""
    tube = Tube(curvature=curvature, eccentricity=eccentricity, edge=0.4)
    points, triangles, radius, plaque, kind = tube.mesh()
    around = round(2 * np.pi * tube.radius / tube.edge)
    first = points.reshape(-1, around, 3)
    centres = first.mean(axis=1)
    corners = [points[triangles[:, k]] for k in range(3)]
    normals = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    ring = triangles[:, 0] // around
    assert (np.einsum("ij,ij->i", normals, corners[0] - centres[ring]) > 0).all()
    middle = len(first) // 2
    assert np.linalg.norm(first[middle] - centres[middle], axis=1) == pytest.approx(radius.min(), rel=0.01)
    assert radius.min() == pytest.approx(tube.radius * (1 - tube.stenosis), rel=0.01)
    assert plaque.max() == pytest.approx((1 + eccentricity) * tube.radius * tube.stenosis, rel=0.02)
    assert set(kind) == {0, 1}
    s = np.linspace(0, tube.length, 2001)
    axis = tube.frames(s)[0]
    bend = np.gradient(np.gradient(axis, s, axis=0), s, axis=0)[2:-2]
    assert np.linalg.norm(bend, axis=1) == pytest.approx(curvature, abs=1e-4)


def test_every_case_has_its_own_folder():
    assert len({"".join(c if c.isalnum() else "_" for c in name) for name in CASE_NAMES}) == len(CASE_NAMES)
