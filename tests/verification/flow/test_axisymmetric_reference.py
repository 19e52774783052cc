"""FFR of cosine lesions in a straight tube against the axisymmetric solution of the same problem (axisymmetric.py).

D 3.2 mm, L 50 mm, lesion 25-35 mm, MAP 93 mmHg, P_v 5 mmHg, Q_hyp 200 mL/min, 0.004 Pa s, 1060 kg/m3; FFR at 45 mm.
"""

import functools
import json
import pathlib
import sys

import numpy as np
import pytest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[2] / "unit" / "flow"), str(pathlib.Path(__file__).parent)]

import axisymmetric  # noqa: E402
import tubes  # noqa: E402
from flow import reduced  # noqa: E402

PA_PER_MMHG = 133.322
GUESS = {0.62: 150e-6 / 60, 0.75: 92e-6 / 60, 0.8: 64e-6 / 60}  # inflow, m3/s


def _document():
    map_pa, venous, flow = 93 * PA_PER_MMHG, 5 * PA_PER_MMHG, 200e-6 / 60
    outlet = {"name": "outlet1", "region_id": 2, "branch": "main", "flow_m3_per_s": flow}
    outlet["resistance_pa_s_per_m3"] = (map_pa - venous) / flow
    document = {"map_pa": map_pa, "venous_pressure_pa": venous, "density_kg_per_m3": 1060, "viscosity_pa_s": 0.004}
    document["outlets"] = [outlet]
    document["probes"] = [{"name": "distal", "branch": "main", "s_mm": 45.0, "point_mm": [45.0, 0, 0]}]
    return document


@functools.lru_cache
def _reference(reduction):
    radius = tubes.lesion(1.6, reduction, 30, 10)
    return axisymmetric.Tube(radius, 50, 30, _document(), (220, 24)).ffr(GUESS[reduction], 45.0)


def _write(folder, reduction):
    radius = tubes.lesion(1.6, reduction, 30, 10)
    tubes.write_case(folder, tubes.tube(50, radius, 0.4), [tubes.line(50, radius)])


@pytest.mark.parametrize(("reduction", "tolerance"), [(0.62, 0.003), (0.75, 0.005), (0.8, 0.005)])
def test_lesion(tmp_path, run_module, reduction, tolerance):
    _write(tmp_path, reduction)
    (tmp_path / "boundary.json").write_text(json.dumps(_document()))
    line = ["--centreline", tmp_path / "centreline.vtp"]
    meshes = [tmp_path / "mesh.msh", "--coarse", tmp_path / "mesh_coarse.msh"]
    done = run_module("flow", "mesh", tmp_path / "lumen.vtp", *line, "--out", *meshes)
    assert done.returncode == 0, done.stderr
    done = run_module(
        "flow", "solve", *meshes, "--boundary", tmp_path / "boundary.json", *line, "--out", tmp_path / "out"
    )
    assert done.returncode == 0, done.stderr
    answer = json.loads((tmp_path / "out" / "ffr.json").read_text())
    print(json.dumps(answer, indent=1), "reference", _reference(reduction))
    assert answer["jet_mixing"] == 0
    assert answer["ffr"] == pytest.approx(_reference(reduction), abs=tolerance)
    assert answer["mass_imbalance"] < 1e-8


HIGH = pytest.mark.xfail(strict=True, reason="the 1D network is .0203 high: its loss behind the throat is too small")


@pytest.mark.parametrize("reduction", [pytest.param(0.62, marks=HIGH), 0.75, 0.8])
def test_reduced_model(tmp_path, reduction):
    _write(tmp_path, reduction)
    anatomy = json.loads((tmp_path / "anatomy.json").read_text())
    network = reduced.Network(anatomy, reduced.read_sections(tmp_path / "sections.csv"), _document(), 1.14)
    s, pressure = network.pressures(network.solve())["main"]
    found = np.interp(0.045, s, pressure) / _document()["map_pa"]
    assert found == pytest.approx(_reference(reduction), abs=0.02)
