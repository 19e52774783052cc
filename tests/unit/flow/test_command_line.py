"""What the command line refuses before any long work."""

import pytest

import tubes
from flow import __main__ as command_line


def _refused(capsys, *command):
    """What is said of a command that ends with exit code 2."""
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
        ("mesh.msh", ["--coarse", "coarse.msh", "--json", "coarse.msh"], ["replace another", "coarse.msh"]),
        ("mesh.msh", ["--json", "lumen.vtp"], ["replace another", "lumen.vtp"]),
        ("mesh.msh", ["--json", "sub/../line.vtp"], ["replace another", "line.vtp"]),
    ],
)
def test_names_of_meshes(tmp_path, monkeypatch, capsys, out, more, words):
    monkeypatch.chdir(tmp_path)
    said = _refused(capsys, "mesh", "lumen.vtp", "--centreline", "line.vtp", "--out", out, *more)
    for word in words:
        assert word in said


def test_other_names_are_let_through(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    files = ["--out", "a.msh", "--coarse", "b.msh", "--json", "c.json"]
    assert "lumen.vtp" in _refused(capsys, "mesh", "lumen.vtp", "--centreline", "line.vtp", *files)


def test_patient_values_given_twice(tmp_path, capsys):
    """Those of the command line would not count."""
    given = ["--anatomy", "anatomy.json", "--case", "config/cases/lad01.yaml", "--lvm-g", "90"]
    assert "given twice" in _refused(capsys, "boundary", *given, "--out", tmp_path / "boundary.json")


@pytest.mark.parametrize("command", ["boundary", "solve", "rank"])
def test_an_anatomy_and_a_centreline_of_two_lumens(tmp_path, capsys, command):
    """A vessel of 20 mm with the line of one of 24 mm."""
    for name, length in (("plan", 20.0), ("other", 24.0)):
        tubes.write_case(tmp_path / name, tubes.tube(length, lambda s: 1.2, 0.8), [tubes.line(length, lambda s: 1.2)])
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
