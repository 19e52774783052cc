"""FFR of a 62 % cosine lesion in a straight tube against an axisymmetric solution of high order.

D 3.2 mm, L 50 mm, lesion 25-35 mm, MAP 93 mmHg, P_v 5 mmHg, Q_hyp 200 mL/min, 0.004 Pa s, 1060 kg/m3. The reference,
0.768512 +- 1e-5 at 45 mm, is that of Q3-Q2 elements on the meridian plane with 51k and 200k unknowns.
"""

import json
import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "unit" / "flow"))

import tubes  # noqa: E402

REFERENCE = 0.768512
PA_PER_MMHG = 133.322


@pytest.mark.xfail(
    run=False,
    reason="not reached: isotropic cells of affordable number leave the jet of a straight tube without a steady flow"
    " (best .7895 with jet mixing .27 on 100k unknowns); run by hand until the mesh is elongated along the jet",
)
def test_62_percent_lesion(tmp_path, run_module):
    radius = tubes.lesion(1.6, 0.62, 30, 10)
    tubes.write_case(tmp_path, tubes.tube(50, radius, 0.4), [tubes.line(50, radius)])
    map_pa, venous, flow = 93 * PA_PER_MMHG, 5 * PA_PER_MMHG, 200e-6 / 60
    outlet = {"name": "outlet1", "region_id": 2, "branch": "main", "flow_m3_per_s": flow}
    outlet["resistance_pa_s_per_m3"] = (map_pa - venous) / flow
    document = {"map_pa": map_pa, "venous_pressure_pa": venous, "density_kg_per_m3": 1060, "viscosity_pa_s": 0.004}
    document["outlets"] = [outlet]
    document["probes"] = [{"name": "distal", "branch": "main", "s_mm": 45.0, "point_mm": [45.0, 0, 0]}]
    (tmp_path / "boundary.json").write_text(json.dumps(document))
    line = ["--centreline", tmp_path / "centreline.vtp"]
    meshes = [tmp_path / "mesh.msh", "--coarse", tmp_path / "mesh_coarse.msh"]
    done = run_module("flow", "mesh", tmp_path / "lumen.vtp", *line, "--out", *meshes)
    assert done.returncode == 0, done.stderr
    done = run_module(
        "flow", "solve", *meshes, "--boundary", tmp_path / "boundary.json", *line, "--out", tmp_path / "out"
    )
    assert done.returncode == 0, done.stderr
    answer = json.loads((tmp_path / "out" / "ffr.json").read_text())
    print(json.dumps(answer, indent=1))
    assert answer["ffr"] == pytest.approx(REFERENCE, abs=0.01)
    assert answer["reduced_model"]["ffr"] == pytest.approx(REFERENCE, abs=0.02)
    assert answer["mass_imbalance"] < 1e-8
