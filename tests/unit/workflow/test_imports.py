"""The import closure: what it follows, what it leaves to other commands, and that it agrees with Python."""

import json
import subprocess

import pytest

from workflow import imports

PART = {
    "common/__init__.py": "",
    "common/errors.py": "",
    "part/__init__.py": "",
    "part/__main__.py": "from common import errors\ndef a():\n    import part.other\ndef b():\n    import part.deep\n",
    "part/other.py": "import json\n",
    "part/deep/__init__.py": "",
    "part/deep/one.py": "from . import two\nfrom ..shared import thing\ndef late():\n    import part.lazy\n",
    "part/deep/two.py": "",
    "part/shared.py": "thing = 1\n",
    "part/lazy.py": "",
}


@pytest.fixture
def part(tmp_path, monkeypatch):
    """A small package in place of the repository."""
    for name, text in PART.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr(imports, "ROOT", tmp_path)
    imports._imported.cache_clear()
    yield
    imports._imported.cache_clear()


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


def test_unknown_module_is_an_error(part):
    with pytest.raises(ValueError, match="part.none"):
        imports.code("part", "part.none")


@pytest.mark.parametrize(
    "part_name, module", [("reports", "reports.metrics"), ("data_synthetic", "data_synthetic.generate")]
)
def test_agrees_with_what_python_loads(repo_root, part_name, module):
    """Everything of the repository that importing the modules loads is in the closure."""
    program = (
        f"import sys, json, {module}, {part_name}.__main__\n"
        "print(json.dumps([m.__file__ for m in sys.modules.values() if getattr(m, '__file__', None)]))"
    )
    run = subprocess.run(["/usr/bin/python3", "-c", program], cwd=repo_root, text=True, capture_output=True, check=True)
    loaded = {name.removeprefix(f"{repo_root}/") for name in json.loads(run.stdout) if name.startswith(f"{repo_root}/")}
    assert loaded and loaded <= set(imports.code(part_name, module))
