"""Warnings of a run, refusals at its end, and the records of its stages."""

import json
import subprocess

import numpy as np
import pytest
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from vci.benchmarks import scenes

COARSE_NUMERICS = {"device_edge_mm": 0.6}
HEALTHY = scenes.Tube(stenosis=0.0, edge=0.6)


@pytest.fixture
def deploy(binary, tmp_path):
    """deploy(tube, change, command, **scene_options) -> (folder of results, process) of a generated scene, changed."""

    def run(tube, change=lambda document: None, command="deploy", **scene_options):
        path = scenes.write_scene(tmp_path / "case", tube, **({"numerics": COARSE_NUMERICS} | scene_options))
        document = json.loads(path.read_text())
        change(document)
        path.write_text(json.dumps(document))
        out = path.parent / "out"
        program = [str(binary("vci")), command, str(path), "--out", str(out)]
        return out, subprocess.run(program, text=True, capture_output=True, timeout=300)

    return run


def summary(out, result):
    assert result.returncode == 0, result.stderr
    return json.loads((out / "deployment.json").read_text())


def small_stent(*steps, post=1.8):
    """change(document): a stent of 1.8 mm and a postdilatation of `post` mm, with only these steps of the procedure."""

    def change(document):
        devices = document["devices"]
        devices["delivery"], devices["post"] = scenes.balloon(1.8, 12), scenes.balloon(post, 10)
        devices["stent"] = scenes.stent(1.8, 12, "delivery") | {"maximal_diameter_mm": 3.6}
        document["procedure"] = [document["procedure"][k] for k in steps]

    return change


@pytest.mark.parametrize("steps", [(1,), (1, 2)])
def test_a_stent_that_touches_nothing_is_refused(deploy, steps):
    """The stent is alone, or followed by a postdilatation that leaves it free. The message names both diameters."""
    out, result = deploy(HEALTHY, small_stent(*steps))
    assert result.returncode == 3 and "touches nothing" in result.stderr
    words = next(line for line in result.stderr.splitlines() if "the stent's diameter" in line).split()
    own, lumen = (float(words[k]) for k, word in enumerate(words) if word.replace(".", "").isdigit())
    assert 1.7 < own < 1.9
    assert lumen == pytest.approx(3.0, rel=0.005)
    assert not (out / "deployment.json").exists()


def test_a_stent_that_a_later_balloon_brings_to_the_wall_is_none_of_them(deploy):
    result = summary(*deploy(HEALTHY, small_stent(1, 2, post=3.1)))
    assert result["stents"][0]["final_diameter_mm"] > 2.9  # the balloon's 3.1 mm, less the recoil of a stent in a wall
    assert [s["contacts"] for s in result["stages"]][2] == 0, "it hung free in between"


def test_kissing_beyond_a_stents_maximal_diameter_is_warned_of(deploy):
    """Each balloon alone is within the limit. Side by side they open an oval, whose perimeter decides."""

    def change(document):
        document["devices"]["stent"]["maximal_diameter_mm"] = 3.3

    out, result = deploy(scenes.Tube(edge=0.6), change, kissing=0.8, pressures=(10, 9, 12))
    warnings = summary(out, result)["warnings"]
    assert len(warnings) == 1 and "kissing: stent is opened to" in warnings[0]
    assert f"warning: {warnings[0]}" in result.stderr
    assert 3.3 < float(warnings[0].split("opened to ")[1].split()[0]) < 4.5


def test_a_pressure_above_rated_burst_is_warned_of(deploy):
    """Of the three balloons, all rated 20 bar, only the last is inflated beyond that. The baseline warns too."""
    for command in ("deploy", "radius-correct"):
        warnings = summary(*deploy(scenes.Tube(edge=0.6), command=command, pressures=(10, 11, 22)))["warnings"]
        assert len(warnings) == 1 and warnings[0].startswith("postdilatation: post is inflated to 22 bar")
    assert summary(*deploy(scenes.Tube(edge=0.6), pressures=(10, 11, 20)))["warnings"] == []


def test_the_baseline_claims_no_balance(deploy):
    result = summary(*deploy(scenes.Tube(edge=0.6), command="radius-correct"))
    assert result["status"] == "radius set"
    assert result["minimal_lumen_area_mm2"] == min(row["area_mm2"] for row in result["csa_profile"])


def test_a_stages_record_says_where_care_began(deploy):
    usual = summary(*deploy(scenes.Tube(edge=0.6)))
    assert {s["careful_from"] for s in usual["stages"]} == {None}
    careful = summary(*deploy(scenes.Tube(edge=0.6), numerics=COARSE_NUMERICS | {"stalled_steps_per_stage": 48}))
    found = [s["careful_from"] for s in careful["stages"] if s["careful_from"] is not None]
    assert found and min(found) >= 8, "a sixth of the stalled steps"


def test_a_wall_that_nothing_loads_has_no_residual(deploy):
    """A balloon that does not reach the wall leaves it as it was. The forces in the files are rounding errors, and the
    residual is reported as 0."""

    def change(document):
        document["devices"]["pre"] = scenes.balloon(1.8, 10)
        del document["procedure"][1:]

    out, result = deploy(HEALTHY, change)
    assert summary(out, result)["stages"][-1]["residual"] == 0
    forces = vtp.read(out / "lumen.vtp", "").GetPointData()
    assert np.linalg.norm(vtk_to_numpy(forces.GetArray("residual_n"))) <= 1e-9


def test_the_stents_own_area_and_the_lumens_within_it(deploy):
    """Both areas are computed again from the files: from the stent's rings, and from the lumen between the stent's
    ends. They nearly agree, since the lumen rests on the stent."""
    out, result = deploy(scenes.Tube(stenosis=0.6, edge=0.5))
    stent = summary(out, result)["stents"][0]
    points = vtk_to_numpy(vtp.read(out / "devices" / "stent1.vtp", "").GetPoints().GetData())
    around = np.flatnonzero(np.diff(points[:, 2]) > 0.2)[0] + 1  # the tube is straight: ring by ring along z
    rings = points.reshape(-1, around, 3)
    x, y = rings[..., 0], rings[..., 1]
    polygons = 0.5 * np.abs((x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1))
    circle = 2 * np.pi / (around * np.sin(2 * np.pi / around))
    assert stent["minimal_stent_area_mm2"] == pytest.approx(circle * polygons.min(), rel=0.002)
    profile = json.loads((out / "deployment.json").read_text())["csa_profile"]
    inside = [r["area_mm2"] for r in profile if rings[0, :, 2].mean() + 0.5 < r["s_mm"] < rings[-1, :, 2].mean() - 0.5]
    assert stent["minimal_lumen_area_in_stent_mm2"] == pytest.approx(min(inside), rel=0.01)
    assert 0.98 < stent["minimal_lumen_area_in_stent_mm2"] / stent["minimal_stent_area_mm2"] < 1.06


def test_a_stent_that_stands_off_the_wall_is_warned_of(deploy):
    """A stent of 1.8 mm in a narrowing of 1.5 mm of a vessel of 3.0 mm touches the narrowing and hangs free beside
    it."""
    out, result = deploy(scenes.Tube(stenosis=0.5, edge=0.6), small_stent(1))
    found, words = summary(out, result), "malapposition: a stent stands"
    assert found["maximal_malapposition_mm"] > 0.4
    assert [warning.startswith(words) for warning in found["warnings"]] == [True]
    assert result.stderr.count(f"warning: {words}") == 1


def test_a_stent_that_fits_has_no_warning(deploy):
    out, result = deploy(scenes.Tube(stenosis=0.3, edge=0.6))
    found = summary(out, result)
    assert found["maximal_malapposition_mm"] < 0.4 and found["warnings"] == []
    assert "warning" not in result.stderr
