"""Arguments that the command line refuses before any long work."""

import json
import os
import signal
import subprocess
import sys

import pytest

import tubes
from common.errors import ComputationError
from flow import __main__ as command_line
from flow import command_files
from flow.meshing import mesh


def _refused(capsys, *command):
    """The message of a command that must end with exit code 2."""
    with pytest.raises(SystemExit) as ended:
        command_line.main([str(word) for word in command])
    assert ended.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    "out, more, words",
    [
        ("mesh.vtu", [], ["end in .msh", "mesh.vtu"]),
        ("mesh", [], ["end in .msh"]),
        ("mesh.msh", ["--coarse", "coarse.json"], ["end in .msh", "coarse.json"]),
        ("mesh.msh", ["--coarse", "mesh.msh"], ["replace another", "mesh.msh"]),
        ("mesh.msh", ["--coarse", "a.msh", "a.msh"], ["replace another", "a.msh"]),
        (
            "mesh.msh",
            ["--coarse", "a.msh", "b.msh", "c.msh"],
            ["more coarse meshes than coarse_rings", "3 files, [2, 3]"],
        ),
        ("mesh.msh", ["--coarse", "coarse.msh", "--json", "coarse.msh"], ["replace another", "coarse.msh"]),
        ("mesh.msh", ["--json", "lumen.vtp"], ["replaced by its answer", "lumen.vtp"]),
        ("mesh.msh", ["--json", "sub/../line.vtp"], ["replaced by its answer", "line.vtp"]),
    ],
)
def test_names_of_meshes(tmp_path, monkeypatch, capsys, out, more, words):
    monkeypatch.chdir(tmp_path)
    said = _refused(capsys, "mesh", "lumen.vtp", "--centreline", "line.vtp", "--out", out, *more)
    for word in words:
        assert word in said


def test_other_names_are_let_through(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for coarse in (["b.msh"], ["d.msh", "b.msh"]):
        files = ["--out", "a.msh", "--coarse", *coarse, "--json", "c.json"]
        assert "lumen.vtp" in _refused(capsys, "mesh", "lumen.vtp", "--centreline", "line.vtp", *files)


@pytest.mark.parametrize(("paths", "given"), [(["a", "b"], [("a", 2), ("b", 3)]), (["b"], [("b", 3)]), ([], [])])
def test_fewer_coarse_meshes_are_those_of_the_last_rings(paths, given):
    assert command_files.pair_with_rings(paths, [2, 3]) == given


def test_patient_values_given_twice(tmp_path, capsys):
    """Otherwise the values on the command line would be ignored without a message."""
    given = ["--anatomy", "anatomy.json", "--case", "config/cases/lad01.yaml", "--lvm-g", "90"]
    assert "given twice" in _refused(capsys, "boundary", *given, "--out", tmp_path / "boundary.json")


@pytest.mark.parametrize("command", ["boundary", "solve", "rank"])
def test_an_anatomy_and_a_centreline_of_two_lumens(tmp_path, capsys, command):
    """The anatomy is of a vessel of 20 mm, the centreline of one of 24 mm."""
    for name, length in (("plan", 20.0), ("other", 24.0)):
        tubes.write_case(
            tmp_path / name, tubes.tube(length, lambda s: 1.2, 0.8), [tubes.centre_branch(length, lambda s: 1.2)]
        )
    patient = ["--lvm-g", "60", "--sbp-mmhg", "120", "--dbp-mmhg", "80"]
    boundary = ["--boundary", tmp_path / "boundary.json"]
    anatomy = ["--anatomy", tmp_path / "plan" / "anatomy.json"]
    command_line.main([str(word) for word in ["boundary", *anatomy, *patient, "--out", boundary[1]]])
    (tmp_path / "plan" / "centreline.vtp").write_bytes((tmp_path / "other" / "centreline.vtp").read_bytes())
    (tmp_path / "mesh.msh").write_text("")
    line = ["--centreline", tmp_path / "plan" / "centreline.vtp"]
    given = {
        "boundary": [*anatomy, *patient],
        "solve": [tmp_path / "mesh.msh", *boundary, *line],
        "rank": [f"a={tmp_path / 'plan'}", *boundary],
    }[command]
    said = _refused(capsys, command, *given, "--out", tmp_path / "out")
    assert "a branch of another lumen" in said and "anatomy.json: main" in said and "20 mm" in said and "24 mm" in said


PATIENT = ["--lvm-g", "60", "--sbp-mmhg", "120", "--dbp-mmhg", "80"]


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """Folder of a short tube's files with boundary.json."""
    folder = tmp_path_factory.mktemp("short")
    tubes.write_case(folder, tubes.tube(6.0, lambda s: 1.2, 0.6), [tubes.centre_branch(6.0, lambda s: 1.2)])
    anatomy = ["--anatomy", str(folder / "anatomy.json")]
    command_line.main(["boundary", *anatomy, *PATIENT, "--out", str(folder / "boundary.json")])
    return folder


def _mesh(case, out, *more):
    line = ["--centreline", str(case / "centreline.vtp"), "--rings", "3", "--coarse-rings", "2"]
    files = ["--out", str(out / "mesh.msh"), "--coarse", str(out / "coarse.msh")]
    return ["mesh", str(case / "lumen.vtp"), *line, *files, *more]


def _solve(case, meshes, out, *more):
    files = ["--boundary", str(case / "boundary.json"), "--centreline", str(case / "centreline.vtp")]
    return ["solve", str(meshes / "mesh.msh"), *files, "--out", str(out), *more]


@pytest.fixture(scope="module")
def meshes(case, tmp_path_factory):
    """Folder with mesh.msh, coarse.msh and mesh.json of the tube."""
    folder = tmp_path_factory.mktemp("meshes")
    command_line.main(_mesh(case, folder))
    return folder


@pytest.mark.parametrize(
    "command, name, more",
    [
        ("solve", "ffr.json", ["--ffr-tolerance", "-1"]),
        ("solve", "ffr.json", ["--residual-absolute", "nan"]),
        ("solve", "ffr.json", ["--rings", "3"]),
        ("solve", "ffr.json", ["--unknown", "3"]),
        ("solve", "pullback.csv", ["--settings", "none.json"]),
        ("mesh", "mesh.json", ["--rings", "-1"]),
        ("mesh", "coarse.msh", ["--settings", "none.json"]),
        ("boundary", "out.json", ["--case", "none.yaml"]),
        ("rank", "out.csv", ["--model", "3d"]),
    ],
)
def test_a_refused_run_leaves_no_former_answer(case, tmp_path, capsys, command, name, more):
    (tmp_path / name).write_text("former")
    (tmp_path / "notes.txt").write_text("mine")
    words = {
        "solve": _solve(case, tmp_path, tmp_path),
        "mesh": _mesh(case, tmp_path),
        "boundary": ["boundary", "--anatomy", case / "anatomy.json", "--out", tmp_path / name],
        "rank": ["rank", f"a={case}", "--boundary", case / "boundary.json", "--out", tmp_path / name],
    }[command]
    _refused(capsys, *words, *more)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_warnings_are_printed_where_they_are_made_and_with_every_answer(meshes, tmp_path, capsys):
    lesions = [{"branch": "main", "s_end_mm": 5.0}]  # too near to the vessel's end for the probe
    radius = lambda s: 1.2  # noqa: E731
    tubes.write_case(tmp_path, tubes.tube(6.0, radius, 0.6), [tubes.centre_branch(6.0, radius)], lesions=lesions)
    out = ["--out", str(tmp_path / "boundary.json")]
    command_line.main(["boundary", "--anatomy", str(tmp_path / "anatomy.json"), *PATIENT, *out])
    said = "probe distal is -0.5 mm past its lesion's end instead of 10 mm"
    assert capsys.readouterr().err.count(said) == 1
    command_line.main(_solve(tmp_path, meshes, tmp_path / "out", "--model", "network"))
    printed, answer = capsys.readouterr().err, json.loads((tmp_path / "out" / "ffr.json").read_text())
    assert said in answer["warnings"][0] and [printed.count(one) for one in answer["warnings"]] == [1, 1]


def test_every_input_is_known(case, tmp_path):
    """The command knows all files that it may read: those given, those in given folders, reports of meshes, and files
    beside a centreline."""
    words = _solve(case, tmp_path, tmp_path / "out", "--start", str(tmp_path / "before"), str(tmp_path / "old.vtp"))
    given = {k: v for k, v in vars(command_line.make_parser().parse_args(words)).items() if k != "out"}
    found = command_files._files_read(given)
    for path in ("mesh.msh", "mesh.json", "before/solution.vtu", "before/ffr.json", "old.vtp"):
        assert tmp_path / path in found
    assert {case / name for name in ("boundary.json", "centreline.vtp", "anatomy.json", "sections.csv")} <= set(found)
    assert not any("out" in path.parts for path in found)


@pytest.mark.parametrize("name", ["anatomy.json", "centreline.vtp", "boundary.json", "sections.csv", "lumen.vtp"])
def test_an_input_is_not_replaced_by_its_answer(case, capsys, name):
    before = (case / name).read_bytes()
    boundary = ["boundary", "--anatomy", case / "anatomy.json", *PATIENT]
    rank = ["rank", f"a={case}", "--boundary", case / "boundary.json"]
    for words in [rank] + ([boundary] if name in ("anatomy.json", "centreline.vtp") else []):
        assert "replaced by its answer" in _refused(capsys, *words, "--out", case / "sub" / ".." / name)
    assert (case / name).read_bytes() == before


def test_an_out_that_cannot_be_written_is_refused_before_any_work(case, tmp_path, capsys):
    """The inputs do not exist. So a refusal because of --out shows that nothing was read before."""
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.msh").mkdir()
    for out in ("file/out.msh", "folder.msh"):
        for words in (["boundary", "--anatomy", "none"], ["rank", "a=none", "--boundary", "none"]):
            assert "folder" in _refused(capsys, *words, "--out", tmp_path / out)
        assert "folder" in _refused(capsys, "mesh", "none", "--centreline", "none", "--out", tmp_path / out)


def test_where_the_coarse_mesh_fails_no_mesh_is_left(case, tmp_path, monkeypatch):
    def fails(*_):
        raise ComputationError("no coarse mesh", "here", 1, "none")

    for name in ("mesh.msh", "coarse.msh", "mesh.json"):
        (tmp_path / name).write_text("former")
    build = mesh.build
    monkeypatch.setattr(mesh, "build", lambda *given: build(*given) if given[4] == 3 else fails())
    with pytest.raises(SystemExit) as ended:
        command_line.main(_mesh(case, tmp_path))
    assert ended.value.code == 3 and not list(tmp_path.iterdir())


def test_a_mesh_that_cannot_be_written_whole_leaves_nothing(case, tmp_path, monkeypatch):
    write = mesh.write

    def ended(built, path):
        if "coarse" in path.name:
            sys.exit(143)
        write(built, path)

    monkeypatch.setattr(mesh, "write", ended)
    with pytest.raises(SystemExit):
        command_line.main(_mesh(case, tmp_path))
    assert not list(tmp_path.iterdir())


def test_a_report_is_known_by_its_meshes_content(case, meshes, tmp_path, capsys):
    """The number of cells does not suffice: the mesh of a lumen that is .01 mm wider has the same number."""
    radius = tubes.lesion(1.21, 0.0, 3.0, 3.0)
    tubes.write_case(tmp_path / "other", tubes.tube(6.0, radius, 0.6), [tubes.centre_branch(6.0, radius)])
    command_line.main(_mesh(tmp_path / "other", tmp_path / "other"))
    told, other = (json.loads((folder / "mesh.json").read_text()) for folder in (meshes, tmp_path / "other"))
    assert told["cells"] == other["cells"] and told["coarse"][0]["cells"] == other["coarse"][0]["cells"]
    for path in meshes.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    both = ["--coarse", tmp_path / "coarse.msh", "--model", "network"]
    command_line.main([str(word) for word in _solve(case, tmp_path, tmp_path / "out", *both)])
    for name, words in (("coarse.msh", "not known to be of the same lumen"), ("mesh.msh", "report is of another mesh")):
        (tmp_path / name).write_bytes((tmp_path / "other" / name).read_bytes())
        assert words in _refused(capsys, *_solve(case, tmp_path, tmp_path / "out", *both))


def test_the_same_lumen_has_the_same_mesh_and_report(case, meshes, tmp_path):
    command_line.main(_mesh(case, tmp_path))
    for name in ("mesh.msh", "coarse.msh", "mesh.json"):
        assert (tmp_path / name).read_bytes() == (meshes / name).read_bytes()


def test_a_reduced_model_answers_the_same_on_its_single_mesh(case, meshes, tmp_path):
    reduced = ["--model", "axisymmetric"]
    command_line.main(_mesh(case, tmp_path, *reduced))
    found = []
    for there in (meshes, tmp_path):
        both = ["--coarse", str(there / "coarse.msh"), "--lumen", str(case / "lumen.vtp"), *reduced]
        command_line.main(_solve(case, there, tmp_path / "out", *both))
        found.append(json.loads((tmp_path / "out" / "ffr.json").read_text()))
    assert (tmp_path / "coarse.msh").stat().st_size == 0
    assert found[0]["ffr"] == found[1]["ffr"] and found[0]["outlets"] == found[1]["outlets"]
    sizes = [json.loads((folder / "mesh.json").read_text()) for folder in (meshes, tmp_path)]
    assert sizes[1]["cells"] == sizes[0]["coarse"][0]["cells"] < sizes[0]["cells"]


@pytest.mark.parametrize("name, option", [("anatomy.json", "--anatomy"), ("sections.csv", "--sections")])
def test_files_of_the_anatomy_step_that_lie_elsewhere_are_asked_for(case, meshes, tmp_path, capsys, name, option):
    for there in {"centreline.vtp", "boundary.json", "anatomy.json", "sections.csv"} - {name}:
        (tmp_path / there).write_bytes((case / there).read_bytes())
    said = _refused(capsys, *_solve(tmp_path, meshes, tmp_path / "out"))
    assert str(tmp_path / name) in said and f"beside the centreline, or give {option}" in said


def test_a_terminated_run_leaves_nothing(case, meshes, tmp_path):
    """SIGTERM comes while solving. An earlier answer is removed too."""
    (tmp_path / "ffr.json").write_text("{}")
    words = [str(word) for word in _solve(case, meshes, tmp_path)]
    root = str(command_line.pathlib.Path(command_line.__file__).parent.parent)
    run = subprocess.Popen(
        [sys.executable, "-m", "flow", *words], cwd=root, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    assert any("dofs" in line for line in run.stderr)
    os.kill(run.pid, signal.SIGTERM)
    assert run.wait() == 143 and not list(tmp_path.iterdir())
