"""Fixtures of the anatomy's tests, which run `lumen process` and read what it wrote."""

import csv
import json
import subprocess

import pytest


@pytest.fixture(scope="session")
def lumen(binary):
    """lumen(surface, out, *options) -> CompletedProcess of `lumen process`."""
    program = binary("lumen")

    def run(surface, out, *options):
        command = [str(c) for c in (program, "process", surface, "--out", out, *options)]
        return subprocess.run(command, text=True, capture_output=True, timeout=240)

    return run


@pytest.fixture(scope="session")
def process(lumen):
    """process(surface, out, *options) -> (anatomy.json, rows of sections.csv). Asserts that the command succeeds."""

    def run(surface, out, *options):
        done = lumen(surface, out, *options)
        assert done.returncode == 0, done.stderr
        with (out / "sections.csv").open() as file:
            rows = list(csv.DictReader(file))
        return json.loads((out / "anatomy.json").read_text()), rows

    return run
