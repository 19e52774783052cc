"""The solver on small tubes: Poiseuille's pressure drop, balances, quadratic convergence, choice of the mesh."""

import json
import subprocess
import sys
import types

import numpy as np
import pytest

import dual_solutions
import solved_tube
import tubes
import whole_tangent
from flow import solve
from flow.discretisation import spaces
from flow.geometry import centreline
from flow.physics import outlets
from flow.solvers import newton, nonlinear, solved_mesh
from flow import __main__ as command_line
from flow import settings as settings_module
from solved_tube import LENGTH, MU, RADIUS
from places import lone_environment


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """Folder of the straight tube."""
    return solved_tube.make(tmp_path_factory.mktemp("tube"))


@pytest.mark.slow
def test_poiseuille(case, tmp_path):
    answer = solved_tube.solve(case, tmp_path)
    flow = answer["inlet_flow_m3_per_s"]
    drop = 8 * MU * LENGTH * 1e-3 * flow / (np.pi * (RADIUS * 1e-3) ** 4)
    found = json.loads((case / "boundary.json").read_text())["map_pa"] - answer["outlets"][0]["pressure_pa"]
    assert found == pytest.approx(drop, rel=2.5e-3)
    assert answer["mass_imbalance"] < 1e-8
    assert answer["residual_absolute"] < 1e-8 and answer["residual_relative"] < 1e-5
    assert answer["reduced_model"]["ffr"] == pytest.approx(answer["ffr"], abs=2e-4)
    assert (tmp_path / "solution.vtu").is_file() and (tmp_path / "pullback.csv").is_file()


def test_energy_balance_of_poiseuille(case, tmp_path):
    answer = solved_tube.solve(case, tmp_path)
    energy, flow = answer["energy"], answer["inlet_flow_m3_per_s"]
    map_pa = json.loads((case / "boundary.json").read_text())["map_pa"]
    # The same parabola enters and leaves, so friction dissipates the pressure drop times the flow.
    assert energy["friction_w"] == pytest.approx((map_pa - answer["outlets"][0]["pressure_pa"]) * flow, rel=2e-3)
    # For a parabola the integral of u.u u.n / 2 is the square of the mean speed times the flow.
    mean = flow / (np.pi * (RADIUS * 1e-3) ** 2)
    assert energy["inlet_w"] == pytest.approx(map_pa * flow + 1060 * mean**2 * flow, rel=1e-4)
    assert energy["imbalance"] < 1e-6
    assert energy["artificial_w"] == 0


def test_wall_shear_stress_of_poiseuille(case, tmp_path):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    flow = solved_tube.solve(case, tmp_path)["inlet_flow_m3_per_s"]
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(tmp_path / "solution.vtu"))
    reader.Update()
    data = reader.GetOutput()
    points = vtk_to_numpy(data.GetPoints().GetData())
    stress = vtk_to_numpy(data.GetPointData().GetArray("wall_shear_stress_pa"))
    wall = np.hypot(points[:, 1], points[:, 2]) > 0.999 * RADIUS
    inner = wall & (np.abs(points[:, 0] - LENGTH / 2) < 2)
    expected = 4 * MU * flow / (np.pi * (RADIUS * 1e-3) ** 3)
    assert np.median(stress[inner, 0]) == pytest.approx(expected, rel=0.01)
    assert np.abs(stress[np.hypot(points[:, 1], points[:, 2]) < 0.5 * RADIUS]).max() == 0


def _problem(case, **values):
    document = json.loads((case / "boundary.json").read_text())
    space = spaces.read(case / "mesh.msh")
    bounds = outlets.Boundaries(space, document)
    return nonlinear.FlowProblem(space, bounds, document, settings_module.make(**values))


def test_newton_converges_quadratically(case, monkeypatch):
    monkeypatch.setattr(newton, "REUSE_FOR_STEPS", 0.0)  # no accelerated steps
    problem = _problem(case)
    found = newton.newton(problem, 1e-13, 8)
    history = np.array(problem.residual_history)
    assert found.converged and found.iterations <= 5
    steep = np.log(history[1:]) - np.log(history[0])
    assert steep[-1] < -15
    problem.destroy()


@pytest.mark.parametrize("eps", [0.0, 0.3])
def test_tangent_is_the_derivative_of_the_residual(case, eps):
    from dolfinx.fem import petsc as fem_petsc

    problem = _problem(case)
    problem.forms.artificial_viscosity.value = eps
    values, rng = problem.state.x.array, np.random.default_rng(0)
    values[:] = 0.1 * rng.normal(size=len(values))  # random: in- and outflow at the outlet, so the backflow term acts
    direction, base = rng.normal(size=len(values)), values.copy()
    matrix = fem_petsc.assemble_matrix(whole_tangent.compile_tangent(problem.forms))
    matrix.assemble()
    x, y = matrix.createVecs()
    x.array[:] = direction
    matrix.mult(x, y)
    difference = []
    for sign in (1, -1):
        values[:] = base + sign * 1e-6 * direction
        difference.append(fem_petsc.assemble_vector(problem.forms.residual).array.copy())
    numeric = (difference[0] - difference[1]) / 2e-6
    assert np.linalg.norm(numeric - y.array) < 1e-6 * np.linalg.norm(numeric)
    problem.destroy()


@pytest.fixture(scope="module")
def coarse_mesh(case):
    """A coarser mesh of the same tube, beside the case's."""
    settings = ["--rings", "3", "--coarse-rings", "2", "--cells-per-radius", "2"]
    command_line.main(
        ["mesh", str(case / "lumen.vtp"), "--centreline", str(case / "centreline.vtp"), *settings]
        + ["--coarse-cells-per-radius", "1.5", "--out", str(case / "middle.msh"), "--coarse", str(case / "coarse.msh")]
    )
    report = json.loads((case / "middle.json").read_text())
    (coarse,) = report.pop("coarse")
    (case / "coarse.json").write_text(json.dumps(report | coarse))  # as if it had been made on its own
    return case / "coarse.msh"


def test_coarse_and_fine_mesh_swapped_are_refused_before_anything_is_solved(case, coarse_mesh, tmp_path, capfd):
    for coarse in (case / "mesh.msh", coarse_mesh):  # first a finer mesh, then the same mesh
        arguments = ["solve", str(coarse_mesh), "--coarse", str(coarse), "--boundary", str(case / "boundary.json")]
        with pytest.raises(SystemExit) as ended:
            command_line.main(
                arguments + ["--centreline", str(case / "centreline.vtp"), "--out", str(tmp_path / "out")]
            )
        said = capfd.readouterr().err
        assert ended.value.code == 2 and "not fewer cells" in said and "dofs" not in said


def test_a_probe_outside_the_mesh_is_refused_before_anything_is_solved(case, tmp_path, capfd):
    beside = tubes.centre_branch(
        LENGTH, lambda s: RADIUS, lambda along, e1, e2: np.stack([along, e1 + 2.0, e2], axis=-1)
    )
    tubes.write_centreline(tmp_path / "centreline.vtp", [beside])
    files = ["--boundary", str(case / "boundary.json"), "--centreline", str(tmp_path / "centreline.vtp")]
    files += ["--anatomy", str(case / "anatomy.json"), "--sections", str(case / "sections.csv")]
    with pytest.raises(SystemExit) as ended:
        command_line.main(["solve", str(case / "mesh.msh"), *files, "--out", str(tmp_path / "out")])
    said = capfd.readouterr().err
    assert ended.value.code == 2 and "outside the mesh" in said and "distal" in said and "dofs" not in said


@pytest.mark.parametrize(("tolerance", "meshes"), [(0.05, ["coarse.msh"]), (0.0, ["coarse.msh", "mesh.msh"])])
def test_the_fine_mesh_is_solved_on_only_where_the_error_asks_for_it(
    case, coarse_mesh, tmp_path, tolerance, meshes, capfd
):
    (tmp_path / "left_out.msh").touch()  # `flow mesh` leaves an empty file for a mesh that would not be coarser
    arguments = ["solve", str(case / "mesh.msh"), "--coarse", str(tmp_path / "left_out.msh"), str(coarse_mesh)]
    arguments += ["--boundary"]
    arguments += [str(case / "boundary.json"), "--centreline", str(case / "centreline.vtp"), "--out", str(tmp_path)]
    command_line.main(arguments + ["--ffr-tolerance", str(tolerance)])
    answer = json.loads((tmp_path / "ffr.json").read_text())
    assert [mesh["mesh"] for mesh in answer["meshes"]] == meshes
    assert answer["tolerance_met"] == (tolerance > 0)
    assert answer["ffr"] == answer["meshes"][-1]["ffr"]
    assert answer["error_estimate"]["ffr"] == answer["meshes"][-1]["error_estimate"]
    assert answer["probes"][0]["error_estimate"] == answer["error_estimate"]["ffr"]
    said = capfd.readouterr()
    assert ("ffr_tolerance" in said.err) == (tolerance == 0)
    assert ("ffr_tolerance = 0" in "".join(answer["warnings"])) == (tolerance == 0)
    assert said.out == f"FFR {answer['ffr']:.4f} +- {answer['error_estimate']['ffr']:.4f}\n"


def _without_timings(value):
    """A JSON document without its times and its memory."""
    if isinstance(value, list):
        return [_without_timings(one) for one in value]
    if not isinstance(value, dict):
        return value
    measured = ("seconds", "cpu_seconds", "peak_memory_mib")
    return {key: _without_timings(one) for key, one in value.items() if key not in measured}


@pytest.mark.slow
def test_same_input_same_bits(case, coarse_mesh, tmp_path):
    """Two processes solve on two meshes each. So the test includes the error estimate and the start from the coarse
    flow."""
    files = ["--boundary", str(case / "boundary.json"), "--centreline", str(case / "centreline.vtp")]
    line = ["solve", str(case / "mesh.msh"), "--coarse", str(coarse_mesh), *files, "--ffr-tolerance", "0"]
    found = []
    for name in "ab":
        command = [sys.executable, "-m", "flow", *line, "--out", str(tmp_path / name)]
        subprocess.run(command, env=lone_environment(), check=True, capture_output=True)
        found.append({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()})
    documents = [_without_timings(json.loads(files.pop("ffr.json"))) for files in found]
    assert len(documents[0]["meshes"]) == 2 and documents[0] == documents[1]
    assert sorted(found[0]) == ["pullback.csv", "solution.vtu"] and found[0] == found[1]


def test_the_answer_in_words_has_its_error_and_what_the_flow_is():
    answer = {"ffr": 0.86174, "error_estimate": {"ffr": 0.0012}, "status": "converged"}
    assert solve.summary_line(answer) == "FFR 0.8617 +- 0.0012"
    assert solve.summary_line(answer | {"error_estimate": None}) == "FFR 0.8617 +- unknown"
    kept = answer | {"status": solved_mesh.CONVERGED_WITH_VISCOSITY}
    assert solve.summary_line(kept) == "FFR 0.8617 +- 0.0012 (converged with artificial viscosity)"


def test_the_fine_mesh_does_not_start_with_nothing_left(case, coarse_mesh, tmp_path, capfd):
    arguments = ["solve", str(case / "mesh.msh"), "--coarse", str(coarse_mesh), "--boundary"]
    arguments += [str(case / "boundary.json"), "--centreline", str(case / "centreline.vtp")]
    with pytest.raises(SystemExit) as stop:
        command_line.main(
            arguments + ["--out", str(tmp_path / "out"), "--max-newton-iterations", "2", "--residual-absolute", "1e-20"]
        )
    assert stop.value.code == 3
    said = capfd.readouterr().err
    assert "stalled" in said and "2 factorizations" in said and f"{case / 'mesh.msh'}:" not in said


def test_the_dual_solution_says_how_the_goal_changes_with_a_load(case):
    problem = _problem(case)
    assert newton.newton(problem, 1e-12, 8).converged
    goal = problem.boundaries.flux[0]  # the outflow as goal
    dual = dual_solutions.dual(problem, goal)
    before = problem.boundaries.outflows(problem.state.x.array)[0]
    # MAP occurs only in the equation of the inflow. Its dual value is the dual solution at the inlet over the profile.
    inlet, profile = problem.space.inlet_dofs, problem.boundaries.profile
    largest = inlet[np.argmax(np.abs(profile[inlet]))]
    step = 1.0
    problem.boundaries.map_pa += step
    assert newton.newton(problem, 1e-12, 8).converged
    after = problem.boundaries.outflows(problem.state.x.array)[0]
    assert dual[largest] / profile[largest] == pytest.approx((after - before) / step, rel=1e-4)
    problem.destroy()


def test_each_probe_has_the_error_it_would_have_alone(case):
    problem, tree = _problem(case), centreline.read(case / "centreline.vtp")
    assert newton.newton(problem, 1e-12, 8).converged
    solved = types.SimpleNamespace(problem=problem, space=problem.space)
    probes = [{"branch": "main", "point_mm": tree.main.point(s).tolist()} for s in (0.75 * LENGTH, 0.25 * LENGTH)]
    document = json.loads((case / "boundary.json").read_text())

    def parts(*chosen):
        return dual_solutions.error_parts(solved, document | {"probes": list(chosen)}, tree)

    both, alone = parts(*probes, probes[0]), [parts(probe)[0] for probe in probes]
    assert both[0] == pytest.approx(alone[0], rel=1e-9) and both[1] == pytest.approx(alone[1], rel=1e-9)
    assert (both[2] == both[0]).all() and np.abs(both[0] - both[1]).max() > 0.1 * np.abs(both[0]).max()
    problem.destroy()
