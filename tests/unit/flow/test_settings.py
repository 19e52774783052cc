"""Each command offers the settings that have an effect on it, and refuses all others."""

import json
import types

import pytest

import tubes
from flow import __main__ as command_line
from flow import settings as settings_module
from workflow import imports

LENGTH, RADIUS = 6.0, 1.2
MODULES = {
    "boundary": ("flow.inputs.boundary",),
    "mesh": ("flow.meshing.mesh",),
    "solve": ("flow.solve", "flow.reduced.extended"),
    "audit": ("flow.audit", "flow.adaptive", "flow.reduced.extended"),
    "rank": ("flow.reduced.ranking",),
}


def _offered(command):
    return {name for name in settings_module.properties() if command in settings_module.commands_of(name)}


@pytest.fixture
def read(monkeypatch):
    """Function that returns the names of the settings that were read so far."""
    names, made = set(), settings_module.make

    class Recording(types.SimpleNamespace):
        def __getattribute__(self, name):
            names.add(name)
            return super().__getattribute__(name)

    monkeypatch.setattr(settings_module, "make", lambda **values: Recording(**vars(made(**values))))
    return lambda: names & set(settings_module.properties())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    top = tmp_path_factory.mktemp("tube")
    tubes.write_case(top, tubes.tube(LENGTH, lambda s: RADIUS, 0.6), [tubes.centre_branch(LENGTH, lambda s: RADIUS)])
    return top


def _boundary(folder, *options):
    patient = ["--lvm-g", "60", "--sbp-mmhg", "120", "--dbp-mmhg", "80"]
    anatomy = ["--anatomy", str(folder / "anatomy.json")]
    command_line.main(["boundary", *anatomy, *patient, "--out", str(folder / "boundary.json"), *options])


def _mesh(folder):
    meshes = ["--out", str(folder / "mesh.msh"), "--coarse", str(folder / "coarse.msh")]
    sizes = ["--rings", "3", "--coarse-rings", "2", "--cells-per-radius", "2", "--coarse-cells-per-radius", "1.5"]
    line = ["--centreline", str(folder / "centreline.vtp")]
    command_line.main(["mesh", str(folder / "lumen.vtp"), *line, *meshes, *sizes])


def test_boundary_reads_what_it_offers(folder, read):
    _boundary(folder, "--viscosity-model", "carreau_yasuda")
    assert read() == _offered("boundary")


def test_mesh_reads_what_it_offers(folder, read):
    _mesh(folder)
    assert read() == _offered("mesh")


@pytest.fixture(scope="module")
def prepared(folder):
    _boundary(folder)
    _mesh(folder)
    return folder


def test_solve_reads_no_more_than_it_offers(prepared, read):
    folder = prepared
    out = ["--boundary", str(folder / "boundary.json"), "--out", str(folder / "out")]
    line = ["--centreline", str(folder / "centreline.vtp")]
    command_line.main(["solve", str(folder / "coarse.msh"), *line, *out])
    assert "grad_div_pa_s" in read() and read() <= _offered("solve")


@pytest.mark.parametrize("command", MODULES)
def test_what_a_command_offers_occurs_in_its_code(command):
    text = "".join(open(imports.ROOT / file).read() for file in imports.code("flow", *MODULES[command]))
    assert [name for name in _offered(command) if f"settings.{name}" not in text] == []


def test_every_setting_acts_somewhere():
    for name in settings_module.properties():
        assert set(settings_module.commands_of(name)) and set(settings_module.commands_of(name)) <= set(MODULES)


@pytest.mark.parametrize(
    ("command", "given", "owner"),
    [
        ("solve", ["--viscosity-pa-s", ".02"], "flow boundary"),
        ("solve", ["--venous-pressure-mmhg=15"], "flow boundary"),
        ("solve", ["--rings", "12"], "flow mesh"),
        ("mesh", ["--ffr-tolerance", "0"], "flow solve` or `flow audit"),
        ("boundary", ["--model", "network"], "flow solve` or `flow audit` or `flow rank"),
        ("rank", ["--march-steps", "20"], "flow audit"),
    ],
)
def test_a_setting_of_another_command_is_refused(command, given, owner, capsys):
    required = {
        "solve": ["mesh.msh", "--boundary", "b.json", "--centreline", "c.vtp", "--out", "out"],
        "mesh": ["lumen.vtp", "--centreline", "c.vtp", "--out", "mesh.msh"],
        "boundary": ["--anatomy", "anatomy.json", "--out", "b.json"],
        "rank": ["a=folder", "--boundary", "b.json", "--out", "r.csv"],
    }
    with pytest.raises(SystemExit) as ended:
        command_line.main([command, *required[command], *given])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and owner in said and given[0].partition("=")[0] in said


def test_an_option_that_there_is_not_is_refused(capsys):
    with pytest.raises(SystemExit) as ended:
        command_line.main(["rank", "a=folder", "--boundary", "b.json", "--out", "r.csv", "--nonsense"])
    assert ended.value.code == 2 and "--nonsense" in capsys.readouterr().err


def test_the_3d_model_does_not_rank(capsys):
    with pytest.raises(SystemExit) as ended:
        command_line.main(["rank", "a=b", "--boundary", "b.json", "--out", "r.csv", "--model", "3d"])
    assert ended.value.code == 2 and "not a reduced model" in capsys.readouterr().err


def test_a_file_may_hold_the_settings_of_all_commands(folder, tmp_path):
    (tmp_path / "flow.json").write_text('{"rings": 5, "ffr_tolerance": 0.001, "viscosity_pa_s": 0.003}')
    _boundary(folder, "--settings", str(tmp_path / "flow.json"))
    assert '"viscosity_pa_s": 0.003' in (folder / "boundary.json").read_text()


@pytest.mark.parametrize(
    ("command", "given", "allowed"),
    [
        ("mesh", ["--wall-layers", "2.5"], "a whole number at least 1 at most 4"),
        ("mesh", ["--wall-layers", "abc"], "a whole number at least 1 at most 4"),
        ("mesh", ["--wall-layers", "0"], "a whole number at least 1 at most 4"),
        ("audit", ["--march-steps", "two"], "a whole number at least 16 at most 100000"),
        ("solve", ["--ffr-tolerance", "nan"], "a number at least 0 at most 0.1"),
        ("solve", ["--model", "fast"], "one of 3d, axisymmetric, network"),
    ],
)
def test_a_value_that_is_not_allowed_is_refused_with_what_is(command, given, allowed, capsys):
    required = {
        "solve": ["mesh.msh", "--boundary", "b.json", "--centreline", "c.vtp", "--out", "out"],
        "audit": ["mesh.msh", "--boundary", "b.json", "--centreline", "c.vtp", "--out", "audit.json"],
        "mesh": ["lumen.vtp", "--centreline", "c.vtp", "--out", "mesh.msh"],
    }
    with pytest.raises(SystemExit) as ended:
        command_line.main([command, *required[command], *given])
    said = capsys.readouterr().err
    name = given[0].strip("-").replace("-", "_")
    assert ended.value.code == 2 and allowed in said and name in said and given[1] in said and "usage" not in said


def test_a_whole_number_may_have_a_point(folder, monkeypatch):
    monkeypatch.setattr(settings_module, "check_meshes", lambda values, where: pytest.fail(repr(values["rings"])))
    with pytest.raises(pytest.fail.Exception, match="^5$"):
        command_line.main(
            ["mesh", "l.vtp", "--centreline", "c", "--out", "m.msh", "--coarse", "k.msh", "--rings", "5.0"]
        )


@pytest.mark.parametrize(
    ("given", "remedy"),
    [
        (["--viscosity-power-index", ".3"], "set viscosity_model to carreau_yasuda"),
        (["--viscosity-time-s", "1.902"], "set viscosity_model to carreau_yasuda"),  # the default, but asked for
        (["--viscosity-model", "carreau_yasuda", "--viscosity-pa-s", ".003"], "set viscosity_model to newtonian"),
    ],
)
def test_a_setting_whose_switch_is_not_set_is_refused(folder, given, remedy, capsys):
    with pytest.raises(SystemExit) as ended:
        _boundary(folder, *given)
    said = capsys.readouterr().err
    assert ended.value.code == 2 and remedy in said and "does not act" in said


def test_a_file_with_every_default_sets_no_switch(folder, tmp_path, capsys):
    rules = settings_module.properties()
    values = {name: rule["default"] for name, rule in rules.items()}
    (tmp_path / "flow.json").write_text(json.dumps(values))
    _boundary(folder, "--settings", str(tmp_path / "flow.json"))
    (tmp_path / "flow.json").write_text(json.dumps(values | {"viscosity_time_s": 2}))
    with pytest.raises(SystemExit):
        _boundary(folder, "--settings", str(tmp_path / "flow.json"))
    assert "set viscosity_model to carreau_yasuda" in capsys.readouterr().err
