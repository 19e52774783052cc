"""How much the reference's answer depends on its constants, as CSV.

Run: /usr/bin/python3 tests/verification/data_synthetic/sensitivity_benchmark.py --out FOLDER [--case CASE.yaml]. It
takes about a minute. First the case is generated, its anatomy is measured by build/lumen, and its plan is made.
"""

import argparse
import pathlib
import tempfile

from benchmark_case import PYTHON, ROOT, grow_and_plan, run


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--case", type=pathlib.Path, default=ROOT / "config/cases/lad01.yaml")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        plan, truth = grow_and_plan(options.case.resolve(), pathlib.Path(name))
        place = ["--scene", plan, "--truth", truth, "--out", options.out.resolve()]
        run(*PYTHON, "data_synthetic", "reference-sensitivity", *place)


if __name__ == "__main__":
    main()
