"""The slices against a solid in three dimensions, as CSV.

Run: /usr/bin/python3 tests/verification/data_synthetic/solid_benchmark.py --out FOLDER [--cases CASE.yaml ...]
[--meshes 8x3x2 12x4x1.2]. Each case takes some minutes on one core. First the case is generated, its anatomy is
measured by build/lumen, and its plan is made.
"""

import argparse
import json
import pathlib
import tempfile

from benchmark_case import PYTHON, ROOT, grow_and_plan, run, write_csv


def rows(case, document):
    """A row for each mesh of a case's document slices_vs_3d.json, for the CSV."""
    found = []
    for solid in document["solids"]:
        against = solid["slices_against_it"]
        row = {
            "case": case,
            "mesh": solid["mesh"],
            "unknowns": solid["degrees_of_freedom"],
            "seconds_s": solid["seconds"],
        }
        for region in ("stent", "stent_edges", "beyond"):
            for name in ("mean", "rms", "largest"):
                row[f"{region}_area_{name}_percent"] = against.get(f"{region}_area_percent", {}).get(name)
        row["smallest_area_percent"] = against["minimal_lumen_area_in_stent_percent"]
        row["resistance_percent"] = against["resistance_percent"]
        found.append(row)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, required=True)
    cases = [ROOT / "config/cases" / f"{name}.yaml" for name in ("quick_focal", "long_plaque_bench")]
    parser.add_argument("--cases", type=pathlib.Path, nargs="+", default=cases)
    parser.add_argument("--meshes", nargs="+", default=["8x3x2", "12x4x1.2"])
    options = parser.parse_args()
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    table = []
    with tempfile.TemporaryDirectory() as name:
        for case in options.cases:
            folder = pathlib.Path(name) / case.stem
            plan, truth = grow_and_plan(case.resolve(), folder)
            meshes = ["--meshes", *options.meshes]
            run(*PYTHON, "data_synthetic", "reference-3d", "--scene", plan, "--truth", truth, *meshes, "--out", folder)
            table += rows(case.stem, json.loads((folder / "slices_vs_3d.json").read_text()))
    write_csv(out / "benchmark.csv", table)


if __name__ == "__main__":
    main()
