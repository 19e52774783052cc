"""The engine as a library: installed, found by another project, and used as its example shows."""

import pathlib
import subprocess

import pytest

from vci.benchmarks.scenes import Tube, write_geometry

EXAMPLE = pathlib.Path(__file__).resolve().parents[3] / "examples" / "deploy"
LONGEST = 15  # statements that a deployment takes


def call(*command, **options):
    """Runs a command that must succeed; returns its standard output."""
    result = subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=600, **options)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def program(binary, tmp_path_factory):
    """The example, built against an installation of the library alone."""
    folder = tmp_path_factory.mktemp("library")
    prefix, build = folder / "installed", folder / "build"
    call("cmake", "--install", binary("vci").parent, "--prefix", prefix)
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


def test_example_is_short():
    """A deployment takes no more than fifteen statements."""
    body = (EXAMPLE / "deploy.cpp").read_text().partition("int main")[2]
    assert body.count(";") <= LONGEST
