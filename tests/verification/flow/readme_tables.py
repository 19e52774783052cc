"""Tables of flow/README.md from the benchmarks' CSV files.

    /usr/bin/python3 tests/verification/flow/readme_tables.py --results results/benchmarks --readme flow/README.md

A table stands between the lines `<!-- table: NAME -->` and `<!-- end -->`, NAME being the folder of a benchmark; where
it was not run the table stays.
"""

import argparse
import csv
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT)]

from common.errors import InputError, guarded  # noqa: E402

# benchmark: its table's file, and columns of it under the headings of the README
TABLES = {
    "flow_against_openfoam": (
        "benchmark.csv",
        {
            "solver": "solver",
            "resolution": "mesh",
            "cells": "cells",
            "volume_mm3": "volume, mm3",
            "error": "error of FFR",
            "mesh_cpu_s": "mesh, CPU s",
            "solve_cpu_s": "solve, CPU s",
            "settled_cpu_s": "until FFR settles",
            "outcome": "outcome",
        },
    ),
    "flow_hard_cases": (
        "hard_cases.csv",
        {
            "case": "case",
            "outcome": "outcome",
            "ffr": "FFR",
            "reference": "reference",
            "error": "error",
            "estimate": "estimate",
            "ffr_axisymmetric": "axisymmetric",
            "ffr_1d": "1D",
            "residual_n": "residual, N",
            "eddy": "c",
            "amplitude": "amplitude",
            "factorizations": "factorizations",
            "cpu_s": "CPU s",
            "mib": "MiB",
        },
    ),
}
DIGITS = {"volume_mm3": ".1f", "error": "+.4f", "mesh_cpu_s": ".1f", "solve_cpu_s": ".1f", "settled_cpu_s": ".1f"}
PLACE = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)", re.S)


def text(column, value):
    """A value as the README writes it."""
    if not value or column not in DIGITS:
        return value
    return f"{float(value):{DIGITS[column]}}"


def table(path, columns):
    """Markdown of the columns {name in the file: heading} of a CSV file. Raises InputError where one is missing."""
    with path.open(newline="") as file:
        reader = csv.DictReader(file)
        missing = [name for name in columns if name not in (reader.fieldnames or [])]
        if missing:
            raise InputError("a benchmark's table lacks columns", path, ", ".join(missing), "run the benchmark again")
        rows = [[text(name, row[name]) for name in columns] for row in reader]
    lines = [list(columns.values()), ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def filled(readme, results):
    """The README's text with the tables of the benchmarks in the folder `results`."""

    def replacement(found):
        name = found.group(2)
        if name not in TABLES:
            raise InputError("no such table", "flow/README.md", name, ", ".join(TABLES))
        file, columns = TABLES[name]
        path = results / name / file
        return found.group(1) + table(path, columns) + found.group(3) if path.is_file() else found.group(0)

    return PLACE.sub(replacement, readme)


@guarded
def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", required=True, type=pathlib.Path, help="folder of the benchmarks")
    parser.add_argument("--readme", required=True, type=pathlib.Path)
    options = parser.parse_args()
    options.readme.write_text(filled(options.readme.read_text(), options.results))


if __name__ == "__main__":
    main()
