"""Fixtures for all tests: the repository's root, the public data, the built programs, and a part's command."""

import contextlib
import subprocess

import pytest

from common.errors import InputError
from places import ROOT, build_folder, public_data
from reports.study.software import git_output

PYTHON = "/usr/bin/python3"


@pytest.fixture(scope="session", autouse=True)
def recorded_revision(record_testsuite_property):
    """The results of the tests name the revision that they ran on, so that the report can say it."""
    with contextlib.suppress(InputError):  # an unpacked archive of the repository has no revision
        words = ("describe", "--always", "--abbrev=8", "--exclude=*", "--dirty= with changes")
        record_testsuite_property("revision", git_output(ROOT, *words))


@pytest.fixture(scope="session")
def repo_root():
    """Root of the repository."""
    return ROOT


@pytest.fixture(scope="session")
def shared_data():
    """shared_data(name) -> path of a file or folder of the public test data. The test is skipped if it is absent."""

    def find(name):
        path = public_data(name)
        if path is None:
            pytest.skip(f"public test data {name} is absent: put it in data/ or set VCI_DATA_DIR (see README.md)")
        return path

    return find


@pytest.fixture(scope="session")
def binary():
    """binary(name) -> path of a built program. The test is skipped if it is not built."""

    def find(name):
        path = build_folder() / name
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
