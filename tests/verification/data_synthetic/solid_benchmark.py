"""The slices against a solid in three dimensions, and against CalculiX where that is installed, as CSV.

Run: /usr/bin/python3 tests/verification/data_synthetic/solid_benchmark.py --out FOLDER [--case CASE.yaml]
[--meshes 8x3x2 12x4x1.2]; some ten minutes of one core. The case is grown, measured and planned first (build/lumen).
"""

import argparse
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
PYTHON = [sys.executable, "-m"]


def commands(case, folder, meshes):
    """What is run, in order; `folder` is for what it writes."""
    source, anatomy, plan = folder / "source", folder / "anatomy", folder / "vci" / "plan.json"
    truth = ["--truth", source / "truth.json"]
    return [
        [*PYTHON, "data_synthetic", "generate", case, "--out", source],
        [ROOT / "build" / "lumen", "process", source / "lumen.vtp", "--units", "mm", "--out", anatomy],
        [*PYTHON, "anatomy", "plan", case, "--anatomy", anatomy, "--devices", ROOT / "config/devices", "--out", plan],
        [*PYTHON, "data_synthetic", "reference-3d", "--scene", plan, *truth, "--meshes", *meshes, "--out", folder],
    ]


def rows(document):
    """A row for each mesh of the document slices_vs_3d.json, for the CSV."""
    found = []
    for solid in document["solids"]:
        against = solid["slices_against_it"]
        row = {"mesh": solid["mesh"], "unknowns": solid["degrees_of_freedom"], "seconds_s": solid["seconds"]}
        for region in ("stent", "stent_edges", "beyond"):
            for name in ("rms", "largest"):
                row[f"{region}_area_{name}_percent"] = against.get(f"{region}_area_percent", {}).get(name)
        row["smallest_area_percent"] = against["minimal_stent_area_percent"]
        row["resistance_percent"] = against["resistance_percent"]
        found.append(row)
    return found


def write(path, table):
    """Writes a list of dicts of the same keys as CSV."""
    with open(path, "w", newline="") as handle:
        writer = csv.DictWriter(handle, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--case", type=pathlib.Path, default=ROOT / "config/cases/quick_focal.yaml")
    parser.add_argument("--meshes", nargs="+", default=["8x3x2", "12x4x1.2"])
    options = parser.parse_args()
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for command in commands(options.case.resolve(), folder, options.meshes):
            subprocess.run([str(word) for word in command], env=environment, check=True)
        write(out / "benchmark.csv", rows(json.loads((folder / "slices_vs_3d.json").read_text())))
        if shutil.which("ccx") is None:
            print(
                "CalculiX is not installed (Debian package calculix-ccx): its comparison is left out", file=sys.stderr
            )
            return
        subprocess.run([*PYTHON, "data_synthetic", "reference-ccx", "--out", str(folder)], env=environment, check=True)
        write(out / "calculix.csv", json.loads((folder / "slices_vs_calculix.json").read_text())["loads"])


if __name__ == "__main__":
    main()
