"""The iterative solver against MUMPS: the same flow, tangent and transposed tangent; iterations needed; refusals."""

import json
import types

import numpy as np
import pytest

import tubes
from common.errors import ComputationError
from flow import __main__ as command_line
from flow.errors import error_field
from flow.geometry import centreline
from flow.physics import outlets
from flow.reduced import coupled as predictor, network as network_model
from flow.solvers import iterative, linear_choice
from flow import settings as settings_module
from flow.solvers import solved_mesh

LENGTH = 8.0
MOST = 20  # iterations of a correction to 1e-2: what is needed today, and a little


class _Case:
    """Coarse and fine mesh of a lumen, each solved by MUMPS and, the fine one, iteratively."""

    def __init__(self, folder, surface, branches, parents, document):
        tubes.write_case(folder, surface, branches, parents)
        self.folder, self.document = folder, document
        (folder / "boundary.json").write_text(json.dumps(document))
        along, rings = ["--centreline", str(folder / "centreline.vtp")], ["--rings", "3", "--coarse-rings", "2"]
        meshes = ["--out", str(folder / "mesh.msh"), "--coarse", str(folder / "mesh_coarse.msh")]
        command_line.main(["mesh", str(folder / "lumen.vtp"), *along, *rings, *meshes])
        self.tree, chosen = centreline.read(folder / "centreline.vtp"), settings_module.make()
        anatomy = json.loads((folder / "anatomy.json").read_text())
        sections = network_model.read_sections(folder / "sections.csv")
        network = network_model.Network(anatomy, sections, document, chosen.expansion_loss)
        self.predicted = predictor.Predictor(network, self.tree, document, chosen)
        self.coarse = self._solved("mesh_coarse.msh", "direct")
        self.direct = self._solved("mesh.msh", "direct", self.coarse)
        self.found = self._solved("mesh.msh", "iterative", self.coarse)

    def _solved(self, mesh, solver, start=None):
        chosen = settings_module.make(linear_solver=solver, residual_absolute=1e-10)
        return solved_mesh.solve_mesh(self.folder / mesh, self.document, chosen, self.tree, self.predicted, start)

    def command(self, out, *options):
        """Runs `flow solve` on both meshes."""
        folder = self.folder
        command = ["solve", str(folder / "mesh.msh"), "--boundary", str(folder / "boundary.json"), "--out", str(out)]
        command_line.main([*command, "--centreline", str(folder / "centreline.vtp"), "--ffr-tolerance", "0", *options])


@pytest.fixture(scope="module")
def tube(tmp_path_factory):
    """A tube narrowed by 30 %."""
    radius = tubes.lesion(1.2, 0.3, 4.0, 4.0)
    branches = [tubes.line(LENGTH, radius)]
    document = tubes.boundary_document(branches, [2e-6], [5e9], LENGTH - 1.0, 0.004)
    return _Case(tmp_path_factory.mktemp("tube"), tubes.tube(LENGTH, radius, 0.4), branches, None, document)


@pytest.fixture(scope="module")
def fork(tmp_path_factory):
    """A vessel with one side branch, resistances 1 to 10."""
    surface, branches = tubes.fork(length=16.0, at=7.0, side_length=6.0)
    document = tubes.boundary_document(branches, [2e-6, 2e-7], [5e9, 5e10], 12.0, 0.004)
    return _Case(tmp_path_factory.mktemp("fork"), surface, branches, {"side1": ("main", 7.0)}, document)


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """The narrowed tube with the inflow given, and behind its outlet a pressure."""
    radius = tubes.lesion(1.2, 0.3, 4.0, 4.0)
    branches = [tubes.line(LENGTH, radius)]
    document = tubes.boundary_document(branches, [2e-6], [0.0], LENGTH - 1.0, 0.004)
    document["inlet_flow_m3_per_s"] = 2e-6
    document["outlets"][0]["pressure_pa"] = 11000.0
    return _Case(tmp_path_factory.mktemp("driven"), tubes.tube(LENGTH, radius, 0.4), branches, None, document)


@pytest.mark.parametrize("name", ["tube", "fork", "driven"])
def test_the_flow_is_that_of_the_factorization(name, request):
    case = request.getfixturevalue(name)
    found, direct = case.found, case.direct
    assert isinstance(found.problem, iterative.IterativeProblem)
    assert not isinstance(direct.problem, iterative.IterativeProblem)
    map_pa, pressure = case.document["map_pa"], [one.boundaries.pressures(one.outflows) for one in (found, direct)]
    assert np.abs(pressure[0] - pressure[1]).max() < 1e-6 * map_pa
    assert found.outflows == pytest.approx(direct.outflows, rel=1e-5)
    assert found.problem.inflow == pytest.approx(direct.problem.inflow, rel=1e-6)
    gap = found.problem.state.x.array - direct.problem.state.x.array
    assert np.abs(gap[found.space.q_map]).max() < 1e-6 * map_pa
    assert max(found.problem.iterations) <= MOST


def test_an_answer_conserves_mass_however_small_its_residual(tube):
    """A residual's limits may be met while the flow through the outlets is not yet the inflow to 1e-8 of it."""
    problem, settings = tube.found.problem, settings_module.make()
    values, inflow = problem.state.x.array.copy(), problem.inflow
    assert problem.small(0.0, settings.residual_absolute, settings.residual_relative)
    problem.inflow = inflow * (1 + 2 * outlets.LARGEST_IMBALANCE)
    assert not problem.small(0.0, settings.residual_absolute, settings.residual_relative)
    assert problem.small(0.0, np.inf, settings.residual_relative)  # on the way to an answer
    problem.move(values, inflow, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("name", ["fork", "driven"])
def test_the_operator_is_the_tangent_and_its_transposed(name, request):
    problem = request.getfixturevalue(name).found.problem
    problem.linearise(problem.forms.tangent)
    blocks, random = problem.blocks, np.random.default_rng(1)
    scale = np.concatenate([np.ones(blocks.count), np.full(len(blocks.of_profile), blocks.weight), [blocks.area]])
    free = np.concatenate([blocks.keep, np.ones(len(blocks.of_profile) + 1)])
    x, y = (free * random.standard_normal(len(free)) for _ in range(2))
    forth, back = y @ (blocks.apply(x, False) / scale), x @ (blocks.apply(y, True) / scale)
    assert forth == pytest.approx(back, rel=1e-9)
    x[-1] *= 1e-6
    values, inflow, step = problem.state.x.array.copy(), problem.inflow, 1e-6
    move, rate = blocks.unpacked(x)
    sides = []
    for sign in (1, -1):
        problem.move(values, inflow, move[problem.space.free], rate, sign * step)
        residual, inlet, _ = problem.residual()
        sides.append(np.append(residual.array.copy(), inlet))
    problem.move(values, inflow, 0.0, 0.0, 0.0)
    found, inlet = blocks.unpacked(blocks.apply(x, False) / scale)
    difference = (sides[0] - sides[1]) / (2 * step)
    wanted = np.append(found[problem.space.free], inlet)
    assert np.linalg.norm(difference - wanted) < 1e-5 * np.linalg.norm(wanted)


@pytest.mark.parametrize("name", ["fork", "driven"])
def test_the_dual_solution_is_that_of_the_factorization(name, request):
    case = request.getfixturevalue(name)
    goal = case.found.problem.state_vector().copy()
    goal.array[:] = np.random.default_rng(2).standard_normal(goal.size)
    goal.array[case.found.problem.fixed] = 0.0
    found, wanted = case.found.problem.dual(goal), case.direct.problem.dual(goal)
    assert np.linalg.norm(found - wanted) < 0.01 * np.linalg.norm(wanted)


def test_no_convergence_is_refused_and_leaves_no_answer(tube, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(iterative, "MOST_ITERATIONS", 2)
    coarse = ["--coarse", str(tube.folder / "mesh_coarse.msh")]
    with pytest.raises(SystemExit) as ended:
        tube.command(tmp_path / "out", *coarse, "--linear-solver", "iterative")
    assert ended.value.code == 3
    assert "linear solver did not converge" in capsys.readouterr().err
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_a_factorization_takes_over_where_memory_allows(tube, tmp_path, monkeypatch):
    monkeypatch.setattr(iterative, "MOST_ITERATIONS", 2)
    monkeypatch.setattr(linear_choice, "LARGE", 0)
    coarse = ["--coarse", str(tube.folder / "mesh_coarse.msh")]
    tube.command(tmp_path / "out", *coarse)
    answer = json.loads((tmp_path / "out" / "ffr.json").read_text())
    assert answer["meshes"][-1]["linear_iterations"] is None
    with monkeypatch.context() as little, pytest.raises(SystemExit) as ended:
        little.setattr(linear_choice, "free_mib", lambda: 0.0)
        tube.command(tmp_path / "refused", *coarse)
    assert ended.value.code == 3


def test_the_coarse_flow_answers_where_the_factors_would_be_large(tube, tmp_path, monkeypatch):
    monkeypatch.setattr(iterative, "MOST_ITERATIONS", 2)
    monkeypatch.setattr(linear_choice, "LARGE", 0)
    monkeypatch.setattr(linear_choice, "MOST_MIB", 0)
    tube.command(tmp_path / "out", "--coarse", str(tube.folder / "mesh_coarse.msh"))
    answer = json.loads((tmp_path / "out" / "ffr.json").read_text())
    assert answer["mesh"] == "mesh_coarse.msh" and answer["status"] == "converged"
    assert [mesh["status"] for mesh in answer["meshes"]] == ["converged", "no flow"]
    assert any("ffr_tolerance" in said for said in answer["warnings"])


def test_a_flow_stays_the_answer_where_only_its_dual_solution_is_not_found(tube, tmp_path, monkeypatch, capsys):
    """Two meshes estimate the error then."""
    monkeypatch.setattr(iterative, "DUAL_TOLERANCE", 1e-16)
    coarse = ["--coarse", str(tube.folder / "mesh_coarse.msh"), "--ffr-tolerance", "0"]
    tube.command(tmp_path / "out", *coarse, "--linear-solver", "iterative")
    answer = json.loads((tmp_path / "out" / "ffr.json").read_text())
    assert answer["mesh"] == "mesh.msh" and "no dual solution" in capsys.readouterr().err
    estimate = answer["error_estimate"]
    assert estimate["method"].startswith("two meshes") and estimate["ffr"] == estimate["mesh"] > 0


def test_the_probes_keep_their_estimate_where_only_that_of_the_other_places_is_not_found(tube, tmp_path, monkeypatch):
    def fails(*_):
        raise ComputationError("the linear solver did not converge", "60 iterations", "1e-2", iterative.HINT)

    monkeypatch.setattr(iterative.IterativeProblem, "responses", fails)
    coarse = ["--coarse", str(tube.folder / "mesh_coarse.msh"), "--ffr-tolerance", "0"]
    tube.command(tmp_path / "out", *coarse, "--linear-solver", "iterative")
    answer = json.loads((tmp_path / "out" / "ffr.json").read_text())
    assert answer["mesh"] == "mesh.msh" and answer["error_estimate"]["goal"] > 0
    assert answer["pullback_error_estimate"]["method"] == "two meshes"
    assert answer["outlets"][0]["error_estimate"] > 0


def test_without_a_coarse_mesh_it_is_not_to_be_had(tube, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        tube.command(tmp_path, "--linear-solver", "iterative")
    assert ended.value.code == 2
    assert "coarse mesh" in capsys.readouterr().err


def _start(**changes):
    """What linear_choice asks of a Solved: a steady flow without eddy viscosity, but for the changes."""
    return types.SimpleNamespace(**{"outcome": "steady", "unsteady": None, "mixing": 0.0, **changes})


@pytest.mark.parametrize("solver", ["auto", "iterative"])
def test_a_start_that_is_not_steady_goes_to_the_factorization(solver):
    chosen, large = settings_module.make(linear_solver=solver), linear_choice.LARGE + 1
    assert linear_choice.iterates(large, _start(), chosen)
    for start in (_start(mixing=0.06), _start(unsteady="a mean"), _start(outcome=None), None):
        assert not linear_choice.iterates(large, start, chosen)


def test_only_large_meshes_iterate_unless_asked_for():
    assert not linear_choice.iterates(linear_choice.LARGE, _start(), settings_module.make())
    assert linear_choice.iterates(10, _start(), settings_module.make(linear_solver="iterative"))
    assert not linear_choice.iterates(10**7, _start(), settings_module.make(linear_solver="direct"))


@pytest.mark.parametrize("name", ["fork", "driven"])
def test_the_error_field_of_all_stretches_is_the_sum_of_the_factorizations(name, request):
    case = request.getfixturevalue(name)
    (_, found), (along, direct) = (error_field.of(one, case.document, case.tree) for one in (case.found, case.direct))
    assert found.pressure.shape[1] == 1 and direct.pressure.shape[1] == along.shape[1] > 3
    gap = found.pressure[:, 0] - direct.pressure.sum(axis=1)
    assert np.abs(gap).max() < 0.02 * np.abs(direct.pressure.sum(axis=1)).max()
