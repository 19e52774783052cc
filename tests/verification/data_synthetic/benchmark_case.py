"""Functions shared by the reference's benchmarks: generate, measure and plan a case, and write tables."""

import argparse
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile

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


def compare_with_solids(description, cases, meshes, command, rows):
    """Command line of a benchmark that compares the reference with solids: writes --out/benchmark.csv.

    description: first line of the help. cases: names of the cases, meshes: meshes of the solid, both unless others are
    given. command: the command of data_synthetic that compares, and the name of the document that it writes.
    rows(case, document): the CSV's rows of a case.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    files = [ROOT / "config/cases" / f"{name}.yaml" for name in cases]
    parser.add_argument("--cases", type=pathlib.Path, nargs="+", default=files)
    parser.add_argument("--meshes", nargs="+", default=meshes)
    options = parser.parse_args()
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    name, document = command
    table = []
    with tempfile.TemporaryDirectory() as temporary:
        for case in options.cases:
            folder = pathlib.Path(temporary) / case.stem
            plan, truth = grow_and_plan(case.resolve(), folder)
            inputs = ["--scene", plan, "--truth", truth, "--meshes", *options.meshes]
            run(*PYTHON, "data_synthetic", name, *inputs, "--out", folder)
            table += rows(case.stem, json.loads((folder / document).read_text()))
    write_csv(out / "benchmark.csv", table)
