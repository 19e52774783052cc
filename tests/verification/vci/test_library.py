"""The engine as a library: it is installed, found by another CMake project, and used as in its example."""

import pathlib
import subprocess

import pytest

from vci.benchmarks.scenes import Tube, write_geometry

pytestmark = pytest.mark.slow

EXAMPLE = pathlib.Path(__file__).resolve().parents[3] / "examples" / "deploy"
LONGEST = 15  # statements that a deployment takes


def call(*command, **options):
    """Runs a command that must succeed; returns its standard output."""
    result = subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=600, **options)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def prefix(binary, tmp_path_factory):
    """The folder of an installation."""
    folder = tmp_path_factory.mktemp("library") / "installed"
    call("cmake", "--install", binary("vci").parent, "--prefix", folder)
    return folder


@pytest.fixture(scope="module")
def program(prefix):
    """The example program, built against the installation without the clone."""
    build = prefix.parent / "build"
    headers = [path.relative_to(prefix) for path in prefix.rglob("*.hpp")]
    assert pathlib.Path("include/vci/vci.hpp") in headers
    call("cmake", "-S", EXAMPLE, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release")
    call("cmake", "--build", build)
    return build / "deploy"


def test_example_opens_the_artery(program, tmp_path):
    """A balloon of 3 mm opens the throat of a narrowed tube, and progress goes to the caller's logger."""
    write_geometry(tmp_path, Tube(length=20, lesion_length=7, edge=0.8))
    before, after = map(float, call(program, tmp_path / "lumen.vtp", tmp_path / "centreline.vtp").split())
    assert before == pytest.approx(3.1416 * 0.75**2, rel=0.05)
    assert 1.3 * before < after < 3.1416 * 1.6**2


def test_python_package_is_installed(prefix, tmp_path):
    """The installed package works outside the clone, with its own compiled module."""
    packages = list(prefix.glob("lib/python3*/site-packages"))
    if not list(prefix.rglob("_engine*.so")):
        pytest.skip("the Python module is not built: run make build")
    script = "import vci; vci.deploy; print(vci.__file__, vci._engine.__file__)"
    environment = {"PYTHONPATH": str(packages[0]), "PATH": "/usr/bin"}
    found = call("/usr/bin/python3", "-c", script, cwd=tmp_path, env=environment).split()
    assert all(pathlib.Path(path).is_relative_to(packages[0]) for path in found)


def test_example_is_short():
    """A deployment takes no more than fifteen statements."""
    body = (EXAMPLE / "deploy.cpp").read_text().partition("int main")[2]
    assert body.count(";") <= LONGEST
