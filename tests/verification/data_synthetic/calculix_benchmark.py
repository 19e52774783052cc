"""The reference's slices against CalculiX (Debian package calculix-ccx), as CSV.

Run: /usr/bin/python3 tests/verification/data_synthetic/calculix_benchmark.py --out FOLDER [--case CASE.yaml]. It takes
a minute or two. ring.csv is of an inflated ring, case.csv of the tightest stented slice of a case through its whole
procedure. First the case is generated, its anatomy is measured by build/lumen, and its plan is made.
"""

import argparse
import json
import pathlib
import tempfile

from benchmark_case import PYTHON, ROOT, grow_and_plan, run, write_csv


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--case", type=pathlib.Path, default=ROOT / "config/cases/lad01.yaml")
    options = parser.parse_args()
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        command = [*PYTHON, "data_synthetic", "reference-ccx", "--out", folder]
        run(*command)
        write_csv(out / "ring.csv", json.loads((folder / "slices_vs_calculix.json").read_text())["loads"])
        plan, truth = grow_and_plan(options.case.resolve(), folder)
        run(*command, "--scene", plan, "--truth", truth)
        write_csv(out / "case.csv", json.loads((folder / "case_vs_calculix.json").read_text())["stages"])


if __name__ == "__main__":
    main()
