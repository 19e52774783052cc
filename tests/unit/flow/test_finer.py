"""Meshes made where the given ones miss the tolerance: how fine, from what, how far."""

import json
import types

import pytest

import solved_tube
import tubes

from common.errors import InputError
from flow import __main__ as command_line
from flow import finer, settings
from flow.geometry import centreline
from flow.solvers import linear_choice


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """A straight tube with meshes of 2 and 3 rings."""
    folder = solved_tube.make(tmp_path_factory.mktemp("finer"))
    meshes = ["--out", str(folder / "mesh.msh"), "--coarse", str(folder / "coarse.msh")]
    line = ["--centreline", str(folder / "centreline.vtp"), "--rings", "3", "--coarse-rings", "2"]
    command_line.main(["mesh", str(folder / "lumen.vtp"), *line, *meshes])
    return folder


def _finer(case, **values):
    tree = centreline.read(case / "centreline.vtp")
    return finer.Finer(case / "lumen.vtp", tree, case / "mesh.json", settings.make(**values), case)


@pytest.mark.parametrize(
    "estimate, dofs, rings",
    [(0.0055, 10000, 4), (0.05, 10000, 4), (0.0055, 300000, None)],
)
def test_rings_go_with_the_error_as_far_as_the_limits_allow(case, estimate, dofs, rings):
    assert _finer(case).rings_for(dofs, estimate, 700000) == rings


def test_rings_of_a_mesh_of_eight(case):
    """Halving the error asks for sqrt(2 / MARGIN) times the rings; a much larger one for half as many more; less where
    the unknowns end."""
    made = _finer(case)
    made.rings = 8
    assert [made.rings_for(10000, error, 700000) for error in (0.0041, 0.006, 0.05)] == [9, 10, 12]
    assert made.rings_for(500000, 0.05, 700000) is None and made.rings_for(450000, 0.05, 700000) == 9
    made.rings = 12
    assert made.rings_for(10000, 0.006, 700000) is None


def test_where_meshes_are_factorized_their_size_is_what_memory_allows(monkeypatch):
    solved = types.SimpleNamespace(outcome="steady", unsteady=None, mixing=0.0)
    assert linear_choice.most_dofs(solved, settings.make()) == 700000
    direct = settings.make(linear_solver="direct")
    most = linear_choice.most_dofs(solved, direct)
    assert linear_choice.factors_mib(most) == pytest.approx(linear_choice.MOST_MIB, rel=1e-4)
    monkeypatch.setattr(linear_choice, "free_mib", lambda: 100.0)
    assert linear_choice.factors_mib(linear_choice.most_dofs(solved, direct)) == pytest.approx(100, rel=1e-3)
    assert linear_choice.most_dofs(solved, settings.make(linear_solver="direct", most_dofs=12345)) == 12345


def test_a_finer_mesh_is_made_as_flow_mesh_makes_it(case):
    made = _finer(case, ffr_tolerance=1e-7)
    path = made.make(6000, 1.1e-6, 100000)
    direct = case / "direct.msh"
    # settings of 4 rings instead of 3, all sizes in proportion
    sizes = ["--rings", "4", "--cells-per-radius", str(2.5 * 4 / 3)]
    sizes += ["--stations-throat", str(0.3 * 3 / 4), "--stations-plain", str(3 / 4)]
    command_line.main(
        ["mesh", str(case / "lumen.vtp"), "--centreline", str(case / "centreline.vtp"), *sizes, "--out", str(direct)]
    )
    assert made.report["cells"] == json.loads(direct.with_suffix(".json").read_text())["cells"]
    assert made.report["rings"] == 4 and path.is_file()
    made.close()
    assert not path.exists() and not list(case.glob(".meshes-*"))


def test_another_surface_centreline_or_report_is_refused(case, tmp_path):
    """A vessel moved aside; its line moved; a report that does not say what it is of."""
    other = tubes.tube(solved_tube.LENGTH, lambda s: solved_tube.RADIUS, 0.4)
    other.points[:, 1] += 1e-3
    line = tubes.line(solved_tube.LENGTH, lambda s: solved_tube.RADIUS)
    tubes.write_case(tmp_path, other, [line])
    tree, chosen = centreline.read(case / "centreline.vtp"), settings.make()
    with pytest.raises(InputError, match="another surface"):
        finer.Finer(tmp_path / "lumen.vtp", tree, case / "mesh.json", chosen, tmp_path)
    tree.main.points[:, 2] += 1e-3
    with pytest.raises(InputError, match="or centreline"):
        finer.Finer(case / "lumen.vtp", tree, case / "mesh.json", chosen, tmp_path)
    (tmp_path / "mesh.json").write_text(json.dumps({"rings": 3}))
    with pytest.raises(InputError, match="how its mesh was made"):
        finer.Finer(case / "lumen.vtp", tree, tmp_path / "mesh.json", chosen, tmp_path)


def _solve(case, out, *options):
    files = ["--boundary", str(case / "boundary.json"), "--centreline", str(case / "centreline.vtp")]
    meshes = [str(case / "mesh.msh"), "--coarse", str(case / "coarse.msh")]
    command_line.main(["solve", *meshes, *files, "--out", str(out), *options])
    return json.loads((out / "ffr.json").read_text())


def test_a_solve_goes_on_to_finer_meshes_until_the_error_is_small_enough(case, tmp_path, capfd):
    lumen = ["--lumen", str(case / "lumen.vtp"), "--ffr-tolerance", "3e-7"]
    answer = _solve(case, tmp_path / "out", *lumen)
    assert [mesh["mesh"] for mesh in answer["meshes"]] == ["coarse.msh", "mesh.msh", "mesh_4_rings.msh"]
    assert answer["tolerance_met"] and answer["error_estimate"]["ffr"] <= 3e-7
    assert answer["mesh"] == "mesh_4_rings.msh"
    assert answer["dofs"] == answer["meshes"][-1]["dofs"] == answer["meshes"][-1]["report"]["dofs"]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["ffr.json", "pullback.csv", "solution.vtu"]
    (tmp_path / "out" / ".meshes-left").mkdir()  # as of a solve that was killed
    capfd.readouterr()
    answer = _solve(case, tmp_path / "out", *lumen, "--most-dofs", "10000")
    assert len(answer["meshes"]) == 2 and not answer["tolerance_met"]
    assert "10000 are allowed" in capfd.readouterr().err
    assert not (tmp_path / "out" / ".meshes-left").exists()


def test_most_dofs_without_a_lumen_is_refused(case, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        _solve(case, tmp_path, "--most-dofs", "20000")
    assert ended.value.code == 2 and "give --lumen" in capsys.readouterr().err
