"""`flow solve --start`: a solve that starts from the flow of another state of the vessel.

It must give the same answer with fewer factorizations.
"""

import json
import pathlib
import shutil
import sys

import pytest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[2] / "unit" / "flow")]

import tubes  # noqa: E402
from flow import __main__ as command_line  # noqa: E402

pytestmark = pytest.mark.slow

MAP, VENOUS, DENSITY, VISCOSITY = 12000.0, 600.0, 1060.0, 0.004
RESISTANCES = (4e9, 1.2e10)  # Pa s/m3: 230 mL/min
SIZES = {"at": 7.0, "length": 20.0, "side_length": 9.0, "edge_mm": 0.5}


def _mesh(folder, radius):
    surface, branches = tubes.fork(radius=radius, **SIZES)
    tubes.write_case(folder, surface, branches, {"side1": ("main", SIZES["at"])})
    flows = [(MAP - VENOUS) / resistance for resistance in RESISTANCES]
    document = tubes.boundary_document(branches, flows, RESISTANCES, 16.0, VISCOSITY, (MAP, VENOUS), DENSITY)
    (folder / "boundary.json").write_text(json.dumps(document))
    line = ["--centreline", str(folder / "centreline.vtp")]
    command_line.main(["mesh", str(folder / "lumen.vtp"), *line, "--out", str(folder / "mesh.msh"), "--rings", "2"])


def _solve(folder, *options, out="flow"):
    line = ["--centreline", str(folder / "centreline.vtp"), "--boundary", str(folder / "boundary.json")]
    command_line.main(["solve", str(folder / "mesh.msh"), *line, "--out", str(folder / out), *map(str, options)])
    return json.loads((folder / out / "ffr.json").read_text())


@pytest.fixture(scope="module")
def states(tmp_path_factory):
    """Folders of two forks, 3.0 and 2.8 mm wide; the first is solved."""
    folders = [tmp_path_factory.mktemp(name) for name in ("wide", "narrow")]
    for folder, radius in zip(folders, (1.5, 1.4)):
        _mesh(folder, radius)
    _solve(folders[0])
    return folders


def test_the_answer_is_the_same_for_less(states):
    other, folder = states
    alone = _solve(folder)
    started = _solve(folder, "--start", other / "flow", other / "centreline.vtp", out="started")
    assert started["ffr"] == pytest.approx(alone["ffr"], abs=2e-6)
    assert started["iterations"] < alone["iterations"]
    assert alone["start"] is None and started["start"]["led_to_flow"]
    assert [mesh["status"] for mesh in started["meshes"]] == ["converged"]


def test_files_that_are_no_state_of_the_vessel_are_refused(states, tmp_path, capsys):
    other, folder = states
    shutil.copytree(other / "flow", tmp_path / "flow")
    lone = tmp_path / "lone"
    lone.mkdir()
    branch = tubes.centre_branch(20.0, lambda s: 1.5 + 0 * s)
    tubes.write_case(lone, tubes.tube(20.0, lambda s: 1.5 + 0 * s), [branch], None)
    (tmp_path / "reduced").mkdir()
    shutil.copy(other / "flow" / "solution.vtu", tmp_path / "reduced")
    document = json.loads((other / "flow" / "ffr.json").read_text())
    del document["mesh"]
    (tmp_path / "reduced" / "ffr.json").write_text(json.dumps(document))
    for start, line, said in (
        (tmp_path / "none", other / "centreline.vtp", "no such file"),
        (tmp_path / "flow", lone / "centreline.vtp", "the state to start from has other branches"),
        (tmp_path / "reduced", other / "centreline.vtp", "not a flow in three dimensions to start from"),
    ):
        with pytest.raises(SystemExit) as ended:
            _solve(folder, "--start", start, line, out="refused")
        assert ended.value.code == 2 and said in capsys.readouterr().err
        assert not (folder / "refused" / "ffr.json").exists()
