"""Functions shared by the reference's benchmarks: generate, measure and plan a case, and write tables."""

import csv
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from places import ROOT, build_folder  # noqa: E402

PYTHON = [sys.executable, "-m"]


def run(*words):
    """Runs a command of the project with one thread. Raises CalledProcessError if it fails."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
    subprocess.run([str(word) for word in words], env=environment, check=True)


def grow_and_plan(case, folder):
    """Generates, measures and plans a synthetic case in `folder`; returns (plan.json, truth.json)."""
    source, anatomy, plan = folder / "source", folder / "anatomy", folder / "vci" / "plan.json"
    run(*PYTHON, "data_synthetic", "generate", case, "--out", source)
    run(build_folder() / "lumen", "process", source / "lumen.vtp", "--units", "mm", "--out", anatomy)
    run(*PYTHON, "anatomy", "plan", case, "--anatomy", anatomy, "--devices", ROOT / "config/devices", "--out", plan)
    return plan, source / "truth.json"


def write_csv(path, table):
    """Writes a list of dicts of the same keys as CSV."""
    with open(path, "w", newline="") as handle:
        writer = csv.DictWriter(handle, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
