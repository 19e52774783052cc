"""Fixtures for all tests: the repository's root, the public data, the built programs, and a part's command."""

import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent
PYTHON = "/usr/bin/python3"


@pytest.fixture(scope="session")
def repo_root():
    """Root of the repository."""
    return ROOT


@pytest.fixture(scope="session")
def shared_data():
    """Folder of the public test data. A test that needs it is skipped where it is absent."""
    candidates = [os.environ.get("VCI_DATA_DIR"), ROOT / "data", ROOT.parent / "shared" / "data"]
    for folder in candidates:
        if folder and (pathlib.Path(folder) / "dfemtoolz_case4_artery.stl").is_file():
            return pathlib.Path(folder)
    pytest.skip("public test data absent: put it in data/ or set VCI_DATA_DIR (see README.md)")


@pytest.fixture(scope="session")
def binary():
    """binary(name) -> path of a built program. The test is skipped if it is not built."""
    folder = pathlib.Path(os.environ.get("VCI_BUILD_DIR", ROOT / "build"))

    def find(name):
        path = folder / name
        if not path.is_file():
            pytest.skip(f"{path} is not built: run make build")
        return path

    return find


@pytest.fixture(scope="session")
def run_module():
    """run_module("flow", "solve", ...) runs `python3 -m flow solve ...` from the root -> CompletedProcess."""

    def run(module, *arguments, **options):
        command = [PYTHON, "-m", module, *map(str, arguments)]
        return subprocess.run(command, cwd=ROOT, text=True, capture_output=True, **options)

    return run
