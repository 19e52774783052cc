"""A forked vessel at a Reynolds number of 170, meshed and solved once.

The tests check the files of the answer against one another, and that Newton's method converges quadratically.
"""

import json
import pathlib
import sys

import numpy as np
import pandas as pd
import pytest
import vtk
from vtk.util.numpy_support import vtk_to_numpy

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[2] / "unit" / "flow")]

import tubes  # noqa: E402
from flow import __main__ as command_line  # noqa: E402
from flow import settings  # noqa: E402
from flow.discretisation import spaces  # noqa: E402
from flow.physics import outlets  # noqa: E402
from flow.solvers import newton, nonlinear  # noqa: E402

pytestmark = pytest.mark.slow

MAP, VENOUS, DENSITY, VISCOSITY = 12000.0, 600.0, 1060.0, 0.004
RESISTANCES = (1e10, 3e10)  # Pa s/m3: 90 mL/min, a Reynolds number of 170
MAIN, AT, SIDE = 16.0, 7.0, 7.0  # mm: length of the main branch, where the side branch leaves, its length
PROBE = 12.0  # mm


def _document(branches):
    flows = [(MAP - VENOUS) / resistance for resistance in RESISTANCES]
    return tubes.boundary_document(branches, flows, RESISTANCES, PROBE, VISCOSITY, (MAP, VENOUS), DENSITY)


def _solve(folder, surface, branches, parents=None, mesh_options=()):
    tubes.write_case(folder, surface, branches, parents)
    (folder / "boundary.json").write_text(json.dumps(_document(branches)))
    line = ["--centreline", str(folder / "centreline.vtp")]
    mesh = str(folder / "mesh.msh")
    command_line.main(["mesh", str(folder / "lumen.vtp"), *line, "--out", mesh, *mesh_options])
    command_line.main(["solve", mesh, *line, "--boundary", str(folder / "boundary.json"), "--out", str(folder)])
    return json.loads((folder / "ffr.json").read_text())


@pytest.fixture(scope="module")
def fork(tmp_path_factory):
    """(folder, document of ffr.json) of the solved fork."""
    folder = tmp_path_factory.mktemp("fork")
    surface, branches = tubes.fork(length=MAIN, at=AT, side_length=SIDE, edge_mm=0.5)
    options = ["--cells-per-radius", "1.5", "--rings", "3"]
    return folder, _solve(folder, surface, branches, {"side1": ("main", AT)}, options)


def test_mass_energy_and_outlets_are_in_balance(fork):
    _, answer = fork
    flows = np.array([outlet["flow_m3_per_s"] for outlet in answer["outlets"]])
    assert abs(flows.sum() / answer["inlet_flow_m3_per_s"] - 1) < 1e-8
    assert answer["mass_imbalance"] < 1e-8
    assert answer["energy"]["imbalance"] < 1e-6
    assert answer["energy"]["friction_w"] > 0 and answer["energy"]["artificial_w"] == 0
    for outlet, resistance in zip(answer["outlets"], RESISTANCES):
        assert outlet["pressure_pa"] == pytest.approx(VENOUS + resistance * outlet["flow_m3_per_s"], rel=1e-12)


def test_the_solve_says_what_it_took(fork):
    _, answer = fork
    assert answer["status"] == "converged" and answer["artificial_viscosity"] == 0
    assert 0 < answer["residual_absolute"] <= 1e-8 and 0 < answer["residual_relative"] <= 1e-5
    assert 1 <= answer["iterations"] <= 6  # 6 is today's number
    assert answer["cpu_seconds"] > 0 and answer["seconds"] > 0
    assert 50 < answer["peak_memory_mib"] < 4096


def test_pullback_follows_every_branch(fork):
    folder, answer = fork
    table = pd.read_csv(folder / "pullback.csv")
    flows = {outlet["name"]: outlet["flow_m3_per_s"] for outlet in answer["outlets"]}
    assert set(table["branch"]) == {"main", "side1"}
    for (name, line), length, end in zip(table.groupby("branch"), (MAIN, SIDE), ("outlet1", "outlet2")):
        assert line["s_mm"].iloc[0] == 0 and line["s_mm"].iloc[-1] == pytest.approx(length, abs=0.51)
        assert line["s_mm"].diff().max() < 0.6
        assert line["ffr"].to_numpy() == pytest.approx(line["pressure_pa"].to_numpy() / MAP, rel=1e-8)
        ends = {outlet["name"]: outlet["ffr"] for outlet in answer["outlets"]}
        assert line["ffr"].iloc[-1] == pytest.approx(ends[end], abs=1e-3)
        assert line["flow_m3_per_s"].iloc[-1] == pytest.approx(flows[end], rel=1e-8)
    main = table[table["branch"] == "main"]
    assert main["flow_m3_per_s"].iloc[0] == pytest.approx(sum(flows.values()), rel=1e-8)
    assert np.interp(PROBE, main["s_mm"], main["ffr"]) == pytest.approx(answer["ffr"], abs=1e-4)
    assert answer["probes"][0]["s_mm"] == pytest.approx(PROBE, abs=1e-6)


def test_fields_open_in_paraview_and_agree(fork):
    folder, _ = fork
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(folder / "solution.vtu"))
    reader.Update()
    data = reader.GetOutput().GetPointData()
    names = ("velocity_m_per_s", "pressure_pa", "ffr", "wall_shear_stress_pa")
    velocity, pressure, ffr, shear = (vtk_to_numpy(data.GetArray(name)) for name in names)
    assert ffr == pytest.approx(pressure / MAP, rel=1e-12)
    wall = np.linalg.norm(shear, axis=1) > 0
    assert wall.sum() > 500 and np.abs(velocity[wall]).max() == 0
    assert np.isfinite(shear).all() and np.isfinite(velocity).all()


def test_newton_converges_quadratically_with_inertia(fork, monkeypatch):
    monkeypatch.setattr(newton, "REUSE_FOR_STEPS", 0.0)  # no accelerated steps
    folder, answer = fork
    document = json.loads((folder / "boundary.json").read_text())
    space = spaces.read(folder / "mesh.msh")
    problem = nonlinear.FlowProblem(space, outlets.Boundaries(space, document), document, settings.make())
    found = newton.newton(problem, 1e-10, 8)  # from rest
    quotients = np.array(problem.residual_history[3:5]) / np.array(problem.residual_history[2:4]) ** 2
    print(
        "residuals", problem.residual_history, "over the squares before", quotients, "factorizations", found.iterations
    )
    assert problem.inflow == pytest.approx(answer["inlet_flow_m3_per_s"], rel=1e-6)
    problem.destroy()
    assert found.converged and found.iterations <= 5  # 5 is today's number
    # Under quadratic convergence this quotient is bounded. Under Picard's linear convergence it grows in every step, in
    # this one 5 times.
    assert quotients[1] < 3 * quotients[0]


def test_an_extended_outlet_leaves_the_reading_inside_the_anatomy(tmp_path):
    length, radius, diameters = 14.0, 1.2, 2.0
    options = ["--outlet-extension-diameters", str(diameters)]
    surface = tubes.tube(length, lambda s: radius, 0.3)
    answer = _solve(tmp_path, surface, [tubes.centre_branch(length, lambda s: radius)], mesh_options=options)
    slope = 8 * VISCOSITY / (np.pi * (radius * 1e-3) ** 4) * 1e-3  # Pa/mm of unit flow
    longer = length + diameters * 2 * radius
    flow = (MAP - VENOUS) / (RESISTANCES[0] + slope * longer)
    assert answer["inlet_flow_m3_per_s"] == pytest.approx(flow, rel=5e-4)
    assert answer["ffr"] == pytest.approx(1 - slope * PROBE * flow / MAP, abs=5e-5)
    table = pd.read_csv(tmp_path / "pullback.csv")
    assert table["s_mm"].iloc[-1] == pytest.approx(length)
    drop = MAP - answer["outlets"][0]["pressure_pa"]
    assert drop == pytest.approx(slope * longer * flow, rel=2e-3)
