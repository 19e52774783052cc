"""The slices against a solid in three dimensions, as CSV.

Run: /usr/bin/python3 tests/verification/data_synthetic/solid_benchmark.py --out FOLDER [--case CASE.yaml]
[--meshes 8x3x2 12x4x1.2]; some ten minutes of one core. The case is grown, measured and planned first (build/lumen).
"""

import argparse
import json
import pathlib
import tempfile

from benchmark_case import PYTHON, ROOT, grow_and_plan, run, write_csv


def rows(document):
    """A row for each mesh of the document slices_vs_3d.json, for the CSV."""
    found = []
    for solid in document["solids"]:
        against = solid["slices_against_it"]
        row = {"mesh": solid["mesh"], "unknowns": solid["degrees_of_freedom"], "seconds_s": solid["seconds"]}
        for region in ("stent", "stent_edges", "beyond"):
            for name in ("rms", "largest"):
                row[f"{region}_area_{name}_percent"] = against.get(f"{region}_area_percent", {}).get(name)
        row["smallest_area_percent"] = against["minimal_lumen_area_in_stent_percent"]
        row["resistance_percent"] = against["resistance_percent"]
        found.append(row)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--case", type=pathlib.Path, default=ROOT / "config/cases/quick_focal.yaml")
    parser.add_argument("--meshes", nargs="+", default=["8x3x2", "12x4x1.2"])
    options = parser.parse_args()
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        plan, truth = grow_and_plan(options.case.resolve(), folder)
        meshes = ["--meshes", *options.meshes]
        run(*PYTHON, "data_synthetic", "reference-3d", "--scene", plan, "--truth", truth, *meshes, "--out", folder)
        write_csv(out / "benchmark.csv", rows(json.loads((folder / "slices_vs_3d.json").read_text())))


if __name__ == "__main__":
    main()
