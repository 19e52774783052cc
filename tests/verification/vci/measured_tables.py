"""Tables of vci/measured.md from the benchmarks' CSV files.

    /usr/bin/python3 tests/verification/vci/measured_tables.py results

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

# benchmark: its table's file, and columns of it under the headings of the page
TABLES = {
    "deployment_speed": (
        "medians.csv",
        {
            "edge_mm": "edge, mm",
            "residual_tolerance": "tolerance",
            "precision": "solves",
            "wall": "wall",
            "cases": "balanced",
            "steps": "steps",
            "cpu_seconds": "CPU s",
            "mean_csa_error_percent": "error of mean area, %",
            "mla_error_percent": "of minimal area, %",
            "microseconds_per_vertex_step": "microseconds per vertex and step",
            "peak_memory_mib": "MiB",
        },
    ),
    "deployment_baseline": (
        "levels.csv",
        {
            "case": "scene",
            "error_percent": "wanted, %",
            "default_edge_mm": "default: edge, mm",
            "default_cpu_seconds": "CPU s",
            "default_error_percent": "error, %",
            "textbook_edge_mm": "textbook: edge, mm",
            "textbook_step_ms": "step, ms",
            "textbook_stop_mm_per_ms": "stop, mm/ms",
            "textbook_cpu_seconds": "CPU s",
            "textbook_error_percent": "error, %",
            "times": "times",
        },
    ),
}
DIGITS = {
    "steps": ".0f",
    "cpu_seconds": ".2f",
    "microseconds_per_vertex_step": ".1f",
    "peak_memory_mib": ".0f",
    "mean_csa_error_percent": ".1f",
    "mla_error_percent": ".1f",
    "default_cpu_seconds": ".2f",
    "default_error_percent": "+.1f",
    "textbook_cpu_seconds": ".1f",
    "textbook_error_percent": "+.1f",
    "times": ".1f",
}


PLACE = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)", re.S)


def text(column, value):
    """A value as the page writes it; words stay."""
    try:
        return f"{float(value):{DIGITS[column]}}" if column in DIGITS else value
    except ValueError:
        return value


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


def filled(text, results):
    """The text of measured.md with the tables of what was run in the folder `results`."""

    def replacement(found):
        name = found.group(2)
        if name not in TABLES:
            raise InputError("no such table", "vci/measured.md", name, ", ".join(TABLES))
        file, columns = TABLES[name]
        path = results / "benchmarks" / name / file
        return found.group(1) + table(path, columns) + found.group(3) if path.is_file() else found.group(0)

    return PLACE.sub(replacement, text)


@guarded
def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=pathlib.Path, help="folder with `benchmarks`")
    parser.add_argument("--page", default=ROOT / "vci" / "measured.md", type=pathlib.Path)
    options = parser.parse_args()
    options.page.write_text(filled(options.page.read_text(), options.results))


if __name__ == "__main__":
    main()
