"""Tables of flow/measured.md from the results' files: the benchmarks' CSV, and ffr.json of each state of each case.

    /usr/bin/python3 tests/verification/flow/measured_tables.py results

A table stands between the lines `<!-- table: NAME -->` and `<!-- end -->`, NAME being the folder of a benchmark, or
`study`; where nothing of it was run the table stays.
"""

import argparse
import csv
import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT)]

from common.errors import InputError, guarded  # noqa: E402

# benchmark: its table's file, and columns of it under the headings of the page
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
    "flow_growth": (
        "growth.csv",
        {
            "rings": "rings",
            "coarse_rings": "coarse",
            "cells": "cells",
            "dofs": "dofs",
            "solver": "solver",
            "ffr": "FFR",
            "linearisations": "linearisations",
            "iterations": "most iterations",
            "fine_cpu_s": "fine mesh, CPU s",
            "cpu_s": "both, CPU s",
            "mib": "MiB",
        },
    ),
}
STUDY = "study"
STATES = ("pre", "vci", "rc", "reference", "ct")  # in the order of the rows; others of a case follow
STUDY_COLUMNS = ("case", "state", "dofs", "FFR", "estimate", "axisymmetric", "c", "amplitude", "ends extended")
STUDY_COLUMNS += ("warnings", "factorizations", "CPU s", "MiB")
DIGITS = {"volume_mm3": ".1f", "error": "+.4f", "mesh_cpu_s": ".1f", "solve_cpu_s": ".1f", "settled_cpu_s": ".1f"}
PLACE = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)", re.S)


def text(column, value):
    """A value as the page writes it."""
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


def study(results):
    """Markdown of the states in results/cases/*/flow/*/ffr.json, or None where there is none."""
    order = {state: k for k, state in enumerate(STATES)}
    paths = sorted((results / "cases").glob("*/flow/*/ffr.json"))
    paths.sort(key=lambda path: (path.parts[-4], order.get(path.parts[-2], len(order)), path.parts[-2]))
    lines = [STUDY_COLUMNS, ["---"] * len(STUDY_COLUMNS), *(state_row(path) for path in paths)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines) if paths else None


def state_row(path):
    """Fields of STUDY_COLUMNS of one ffr.json. Raises InputError where it is of another kind."""
    try:
        answer = json.loads(path.read_text())
        estimate, axisymmetric = answer["error_estimate"], answer["models"]["axisymmetric"]["ffr"]
        return [
            path.parts[-4],
            path.parts[-2],
            f"{answer['dofs']}",
            f"{answer['ffr']:.4f}",
            f"{estimate['ffr']:.4f}" if estimate else "unknown",
            "none" if axisymmetric is None else f"{axisymmetric:.4f}",
            f"{answer['jet_mixing']:g}",
            f"{answer['unsteady']['ffr_amplitude']:.4f}" if answer["unsteady"] else "",
            f"{len(answer['extensions']['ends'])}",
            f"{len(answer['warnings'])}",
            f"{sum(mesh.get('factorizations', 0) for mesh in answer['meshes'])}",
            f"{answer['cpu_seconds']:.0f}",
            f"{answer['peak_memory_mib']:.0f}",
        ]
    except (json.JSONDecodeError, KeyError, TypeError) as error:
        raise InputError("not an answer of the flow solver", path, repr(error), "solve this state again") from error


def filled(text, results):
    """The text of measured.md with the tables of what was run in the folder `results`."""

    def replacement(found):
        name = found.group(2)
        if name == STUDY:
            made = study(results)
            return found.group(1) + made + found.group(3) if made else found.group(0)
        if name not in TABLES:
            raise InputError("no such table", "flow/measured.md", name, ", ".join([*TABLES, STUDY]))
        file, columns = TABLES[name]
        path = results / "benchmarks" / name / file
        return found.group(1) + table(path, columns) + found.group(3) if path.is_file() else found.group(0)

    return PLACE.sub(replacement, text)


@guarded
def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=pathlib.Path, help="folder with `benchmarks` and `cases`")
    parser.add_argument("--page", default=ROOT / "flow" / "measured.md", type=pathlib.Path)
    options = parser.parse_args()
    options.page.write_text(filled(options.page.read_text(), options.results))


if __name__ == "__main__":
    main()
