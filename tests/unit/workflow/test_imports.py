"""The import closure: what it follows, what it leaves to other commands, and that it agrees with Python."""

import ast
import json
import subprocess

import pytest

from workflow import imports

PART = {
    "common/__init__.py": "",
    "common/errors.py": "",
    "part/__init__.py": "",
    "part/__main__.py": "from common import errors\ndef a():\n    import part.other\ndef b():\n    import part.deep\n"
    "def work():\n    from part import lazy\n    _inner()\ndef _inner():\n    from part.run import go\n",
    "part/other.py": "import json\n",
    "part/deep/__init__.py": "",
    "part/deep/one.py": "from . import two\nfrom ..shared import thing\ndef late():\n    import part.lazy\n",
    "part/deep/two.py": "",
    "part/shared.py": "thing = 1\n",
    "part/lazy.py": "",
    "part/run.py": "",
    "bench/script.py": "import sys\nimport beside\nfrom part import shared\n",
    "bench/beside.py": "def late():\n    import helper\n",
    "help/helper.py": "from part.deep import two\n",
    "help/unused.py": "",
}


@pytest.fixture
def part(tmp_path, monkeypatch):
    """A small package in place of the repository."""
    for name, text in PART.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr(imports, "ROOT", tmp_path)
    for cached in (imports._module_file, imports._imported_modules):
        cached.cache_clear()
    yield
    for cached in (imports._module_file, imports._imported_modules):
        cached.cache_clear()


def test_a_module_that_is_its_own_command(part):
    assert imports.module_code("part.deep.two") == ["part/__init__.py", "part/deep/__init__.py", "part/deep/two.py"]
    with pytest.raises(ValueError, match="part.none"):
        imports.module_code("part.none")


def test_follows_relative_lazy_and_package_imports(part):
    assert imports.code("part", "part.deep.one") == [
        "common/__init__.py",
        "common/errors.py",
        "part/__init__.py",
        "part/__main__.py",
        "part/deep/__init__.py",
        "part/deep/one.py",
        "part/deep/two.py",
        "part/lazy.py",
        "part/shared.py",
    ]


def test_leaves_other_commands_alone(part):
    assert "part/deep/one.py" not in imports.code("part", "part.other")


def test_a_command_has_what_its_function_and_those_it_calls_import(part):
    common = ["common/__init__.py", "common/errors.py", "part/__init__.py", "part/__main__.py"]
    assert imports.command_code("part", "work") == [*common, "part/lazy.py", "part/run.py"]
    assert imports.command_code("part", "a") == [*common, "part/other.py"]
    with pytest.raises(ValueError, match="none"):
        imports.command_code("part", "none")


def test_a_script_has_what_lies_beside_it_and_in_its_folders(part):
    own = ["bench/beside.py", "bench/script.py", "help/helper.py"]
    packages = ["part/__init__.py", "part/deep/__init__.py", "part/deep/two.py", "part/shared.py"]
    assert imports.script_code("bench/script.py", "help") == own + packages


@pytest.mark.slow
@pytest.mark.parametrize("script", ["hard_cases", "growth", "against_openfoam"])
def test_a_flow_benchmark_agrees_with_what_python_loads(repo_root, script):
    """What the script loads, and what it would where it solves the reference."""
    folder = "tests/verification/flow"
    program = f"import sys; sys.path[:0] = ['{folder}']; import {script}, axisymmetric"
    loaded = _imported_files(repo_root, program)
    found = imports.flow_benchmark_code(script)
    assert f"{folder}/axisymmetric.py" in loaded and loaded <= set(found)


def test_a_solve_has_what_its_function_imports(repo_root):
    program = (
        "from flow import __main__, solve; from flow.reduced import extended, network; from flow.inputs import boundary"
    )
    found = set(imports.command_code("flow", "solve_command"))
    assert (
        {"flow/reduced/extended.py", "flow/reduced/coupled.py", "flow/reduced/axisymmetric.py"}
        <= _imported_files(repo_root, program)
        <= found
    )
    assert "flow/reduced/ranking.py" not in found


def test_unknown_module_is_an_error(part):
    with pytest.raises(ValueError, match="part.none"):
        imports.code("part", "part.none")


def _imported_files(repo_root, program):
    """Files of the repository, relative to it, that a program's imports load."""
    program += (
        "\nimport sys, json\n"
        "print(json.dumps([m.__file__ for m in sys.modules.values() if getattr(m, '__file__', None)]))"
    )
    run = subprocess.run(["/usr/bin/python3", "-c", program], cwd=repo_root, text=True, capture_output=True, check=True)
    files = [str((repo_root / name).resolve()) for name in json.loads(run.stdout)]
    return {name.removeprefix(f"{repo_root}/") for name in files if name.startswith(f"{repo_root}/")}


@pytest.mark.parametrize(
    "part_name, module", [("reports", "reports.measuring.metrics"), ("data_synthetic", "data_synthetic.generate")]
)
def test_agrees_with_what_python_loads(repo_root, part_name, module):
    """Everything of the repository that importing the modules loads is in the closure."""
    loaded = _imported_files(repo_root, f"import {module}, {part_name}.__main__")
    assert loaded and loaded <= set(imports.code(part_name, module))


def test_an_import_is_found_in_every_kind_of_statement():
    text = """
if a: import b1
else: import b2
try: import b3
except E: import b4
else: import b5
finally: import b6
for i in a: import b7
while a: import b8
with a: import b9
class C:
    async def f(self):
        match a:
            case 1: import b10
x = lambda: (1 if a else 2)
"""
    assert imports._names_in_imports(imports._all_statements(ast.parse(text)), "") == {f"b{k}" for k in range(1, 11)}
