"""Two MPI ranks: the same answer as one, files written once; what each rank assembles; refusals."""

import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

import tubes
from common.errors import InputError
from flow import __main__ as command_line
from flow.discretisation import mixing, parallel, spaces

ROOT = pathlib.Path(__file__).resolve().parents[4]
LENGTH = 8.0


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """A narrowed tube, meshed through the command line, and its boundary values."""
    folder = tmp_path_factory.mktemp("ranks")
    tubes.mesh_narrowed(folder, 0.3, LENGTH, 1.2)
    return folder


def _solve(case, out, *options):
    """The ended process of a solve."""
    command = [sys.executable, "-m", "flow", "solve", str(case / "mesh.msh"), "--boundary", str(case / "boundary.json")]
    command += ["--centreline", str(case / "centreline.vtp"), "--out", str(out), *options]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=400)


@pytest.mark.skipif(shutil.which("mpirun") is None, reason="needs mpirun (package openmpi-bin)")
def test_two_ranks_give_the_answer_of_one(case, tmp_path):
    one, two = _solve(case, tmp_path / "one"), _solve(case, tmp_path / "two", "--ranks", "2")
    assert one.returncode == two.returncode == 0, two.stderr
    found = [json.loads((tmp_path / name / "ffr.json").read_text()) for name in ("one", "two")]
    assert [answer["ranks"] for answer in found] == [1, 2]
    assert found[1]["ffr"] == pytest.approx(found[0]["ffr"], abs=1e-6)
    assert found[1]["error_estimate"]["ffr"] == pytest.approx(found[0]["error_estimate"]["ffr"], rel=1e-4)
    errors = [[outlet["error_estimate"] for outlet in answer["outlets"]] for answer in found]
    assert errors[1] == pytest.approx(errors[0], rel=1e-4) and errors[0][0] > 0
    along = [pd.read_csv(tmp_path / name / "pullback.csv")["ffr_error_estimate"].to_numpy() for name in ("one", "two")]
    assert along[1] == pytest.approx(along[0], rel=1e-4, abs=1e-4 * along[0].max())
    assert found[1]["iterations"] == found[0]["iterations"]
    assert sorted(path.name for path in (tmp_path / "two").iterdir()) == ["ffr.json", "pullback.csv", "solution.vtu"]
    assert two.stdout.count("FFR") == 1  # one rank speaks
    hopeless = ["--max-newton-iterations", "1", "--residual-absolute", "1e-20", "--march-steps", "0"]
    refused = _solve(case, tmp_path / "refused", "--ranks", "2", *hopeless)
    assert refused.returncode == 3, refused.stderr
    assert "stalled" in refused.stderr and not (tmp_path / "refused" / "ffr.json").exists()


@pytest.mark.skipif(shutil.which("mpirun") is None, reason="needs mpirun (package openmpi-bin)")
def test_two_ranks_solve_iteratively_as_one(case, tmp_path):
    own = pathlib.Path(shutil.copytree(case, tmp_path / "case"))
    given = [str(own / "lumen.vtp"), "--centreline", str(own / "centreline.vtp"), "--rings", "3", "--coarse-rings", "2"]
    given += [text for name in tubes.AS_IT_IS for text in ("--" + name.replace("_", "-"), "0")]
    command_line.main(["mesh", *given, "--out", str(own / "mesh.msh"), "--coarse", str(own / "coarse.msh")])
    options = ["--coarse", str(own / "coarse.msh"), "--linear-solver", "iterative", "--ffr-tolerance", "1e-9"]
    found = []
    for ranks in ("1", "2"):
        ended = _solve(own, tmp_path / ranks, *options, "--ranks", ranks)
        assert ended.returncode == 0, ended.stderr
        found.append(json.loads((tmp_path / ranks / "ffr.json").read_text()))
    assert found[0]["meshes"][1]["linear_iterations"] and found[1]["meshes"][1]["linear_iterations"]
    assert found[1]["ffr"] == pytest.approx(found[0]["ffr"], abs=1e-6)
    assert found[1]["error_estimate"]["ffr"] == pytest.approx(found[0]["error_estimate"]["ffr"], rel=1e-2)


def test_rows_of_two_ranks_make_the_whole_matrix(case, monkeypatch):
    from flow import settings
    from flow.discretisation import compat, tangent
    from flow.geometry import centreline
    from flow.physics import outlets
    from flow.solvers import marching, nonlinear

    document, tree = json.loads((case / "boundary.json").read_text()), centreline.read(case / "centreline.vtp")

    def assembled(rank, size):
        world = type("World", (), {"rank": rank, "size": size})
        monkeypatch.setattr(parallel, "share", lambda count: (rank * count // size, (rank + 1) * count // size))
        space = spaces.read(case / "mesh.msh")
        length, bounds = mixing.mixing_length(space, tree, 0.1), outlets.Boundaries(space, document)
        problem = nonlinear.FlowProblem(space, bounds, document, settings.make(), length)
        problem.state.x.array[:] = np.random.default_rng(0).normal(size=space.dofs)
        monkeypatch.setattr(parallel, "world", lambda: world)
        built = tangent.FreeMatrix(space, problem.forms)
        built.assemble(problem.forms.tangent)
        monkeypatch.undo()
        rows, cells = space.rows, space.__dict__.get("shared_cells")
        profile = bounds.profile.x.array
        products = built.times(profile)[rows], built.times(profile, transposed=True)[space.free]
        norm, inertia = built.matrix.norm(), marching.Inertia(problem)
        inertia.weight, force = 1e3, problem.full_residual.duplicate()
        force.set(0.0)
        inertia.add_force(force, problem.state_vector())
        built.assemble(problem.forms.tangent, inertia)
        with_inertia = built.matrix.norm(), force.array.copy()
        found = norm, len(rows), cells, len(compat.cell_dofs(space.W)), products, *with_inertia
        inertia.destroy()
        built.destroy()
        problem.destroy()
        return found

    whole, first, second = assembled(0, 1), assembled(0, 2), assembled(1, 2)
    assert first[1] + second[1] == whole[1]
    for place in (0, 5):  # without and with inertia
        assert np.hypot(first[place], second[place]) == pytest.approx(whole[place], rel=1e-12)
    assert whole[5] > 1.01 * whole[0]
    assert whole[2] is None
    assert np.concatenate([first[4][0], second[4][0]]) == pytest.approx(whole[4][0], rel=1e-12)
    for part in (first, second):  # the inlet's rows, of which these are made, each rank has
        assert part[4][1] == pytest.approx(whole[4][1], rel=1e-12)
        assert part[6] == pytest.approx(whole[6], rel=1e-12)  # forces are whole on each rank
    for part in (first, second):
        assert len(part[2]) < 0.75 * part[3]  # neighbours are few: the dofs are numbered along the vessel


def test_residuals_of_two_ranks_make_the_whole(case, monkeypatch):
    from dolfinx import fem
    from dolfinx.fem import petsc as fem_petsc

    from flow.discretisation import forms
    from flow.geometry import centreline
    from flow.physics import viscosity

    tree, space = centreline.read(case / "centreline.vtp"), spaces.read(case / "mesh.msh")
    length, state = mixing.mixing_length(space, tree, 0.1), fem.Function(space.W)
    state.x.array[:] = np.random.default_rng(0).normal(size=space.dofs)  # flows back through the outlet, too

    def assembled(rank, size):
        world = type("World", (), {"rank": rank, "size": size})
        monkeypatch.setattr(parallel, "world", lambda: world)
        weak = forms.NavierStokes(space, state, 1060.0, viscosity.Newtonian(0.004), 0.2, 0.5, length)
        weak.mixing.value = 0.1
        vector = fem_petsc.assemble_vector(weak.residual)
        monkeypatch.undo()
        return vector.array.copy()

    whole, first, second = assembled(0, 1), assembled(0, 2), assembled(1, 2)
    assert first + second == pytest.approx(whole, rel=1e-12, abs=1e-12 * np.abs(whole).max())
    for part in (first, second):
        assert 0.4 < np.count_nonzero(part) / np.count_nonzero(whole) < 0.75


def test_shares_follow_one_another(monkeypatch):
    monkeypatch.setattr(parallel, "world", lambda: type("World", (), {"rank": 1, "size": 3}))
    assert parallel.share(10) == (3, 6)
    assert parallel.shares(10).tolist() == [3, 3, 4]


def test_ranks_that_the_launcher_did_not_start_are_refused(case, tmp_path, monkeypatch, capsys):
    """As under srun, whose processes an MPI without its support takes for worlds of one."""
    monkeypatch.setenv("PMI_SIZE", "1")
    command = ["solve", str(case / "mesh.msh"), "--boundary", str(case / "boundary.json"), "--out", str(tmp_path)]
    with pytest.raises(SystemExit) as ended:
        command_line.main(command + ["--centreline", str(case / "centreline.vtp"), "--ranks", "2"])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and "2 asked for, 1 run" in said and "mpirun -n 2" in said


def test_ranks_without_mpirun_are_refused(monkeypatch):
    monkeypatch.setattr(parallel.shutil, "which", lambda name: None)
    monkeypatch.setattr(parallel.os, "cpu_count", lambda: 2)
    for name in parallel.LAUNCHED:
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(InputError, match="mpirun"):
        parallel.launch(2, ["solve"])
    parallel.launch(1, ["solve"])
    monkeypatch.setenv(parallel.LAUNCHED[0], "2")
    parallel.launch(2, ["solve"])  # this is one of the ranks


def test_more_ranks_than_cores_are_refused(monkeypatch):
    """They would wait for each other on the same cores."""
    monkeypatch.setattr(parallel.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(parallel.os, "execv", lambda program, command: command)
    monkeypatch.setattr(parallel.shutil, "which", lambda name: "mpirun")
    for name in parallel.LAUNCHED:
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(InputError, match="more ranks than cores"):
        parallel.launch(3, ["solve"])
    parallel.launch(2, ["solve"])
