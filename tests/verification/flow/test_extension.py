"""FFR of a vessel that is cut off two diameters behind a lesion.

By default the outlet is extended. FFR must then be that of the vessel before it was cut off.
"""

import json
import pathlib
import sys

import pytest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[2] / "unit" / "flow"), str(pathlib.Path(__file__).parent)]

import hard_cases  # noqa: E402

NAME = "outlet_2d_behind_62"


@pytest.mark.long
def test_ffr_is_that_of_the_long_vessel(tmp_path, run_module):
    hard_cases.write(NAME, tmp_path)
    line = ["--centreline", tmp_path / "centreline.vtp"]
    meshes = [tmp_path / "mesh.msh", "--coarse", *(tmp_path / name for name in hard_cases.COARSE_MESHES)]
    for command in (
        ["mesh", tmp_path / "lumen.vtp", *line, "--out", *meshes],
        ["solve", *meshes, *line, "--boundary", tmp_path / "boundary.json", "--out", tmp_path],
    ):
        done = run_module("flow", *command)
        assert done.returncode == 0, done.stderr
    answer = json.loads((tmp_path / "ffr.json").read_text())
    expected = hard_cases.STRAIGHT[NAME].reference(answer["inlet_flow_m3_per_s"])
    print("FFR", answer["ffr"], "long vessel", expected, answer["extensions"])
    assert answer["ffr"] == pytest.approx(expected, abs=0.002)
    assert answer["models"]["axisymmetric"]["ffr"] == pytest.approx(expected, abs=0.002)
    (outlet,) = answer["extensions"]["ends"]
    assert outlet["name"] == "outlet1" and outlet["length_mm"] + outlet["narrowing_mm"] == pytest.approx(25.6, rel=0.01)
    pullback = (tmp_path / "pullback.csv").read_text().splitlines()
    assert float(pullback[-1].split(",")[2]) <= hard_cases.STRAIGHT[NAME].length + 1e-6
