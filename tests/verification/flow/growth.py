"""Cost and error of the flow solver by mesh: python3 tests/verification/flow/growth.py --out DIR RINGS:COARSE ...

The tube with a lesion of 62 % is solved on meshes of RINGS rings. The distance of the sections goes with 1 / RINGS.
Each solve starts from the flow on a mesh of COARSE rings. Writes two tables. DIR/growth.csv has rings, coarse_rings,
cells, dofs, ffr, its error against axisymmetric.py, linearisations, CPU seconds of the fine mesh and of the whole
process, and peak memory. DIR/exponents.csv has CPU seconds and memory fitted as powers of the number of cells. Rows of
earlier runs stay unless they are run again.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).parent)]

import hard_cases  # noqa: E402  (makes the packages of the repository known)
from flow import settings  # noqa: E402
from places import lone_environment  # noqa: E402

CASE, DEFAULT = "single_62", settings.make()
SPACING = {"throat": DEFAULT.stations_throat, "plain": DEFAULT.stations_plain}  # for the default's number of rings
COLUMNS = ("rings", "coarse_rings", "cells", "dofs", "ffr", "error", "linearisations", "fine_cpu_s", "cpu_s")
COLUMNS += ("mib",)


def command(folder, *arguments, program=("-m", "flow")):
    """Runs `python3 -m flow` with `arguments` in `folder` and logs its output there. Raises CalledProcessError.

    program: Python's arguments that name the program, to run another one than `flow`.
    """
    with open(folder / f"{arguments[0]}.log", "w") as log:
        line = [sys.executable, *program, *map(str, arguments)]
        subprocess.run(line, cwd=folder, stdout=log, stderr=log, env=lone_environment(), check=True)


def mesh(folder, rings, coarse):
    """Makes both meshes of the lumen in `folder`. The default's distance of the sections is scaled with 1 / rings."""
    names = ["--out", f"r{rings}.msh", "--coarse", f"r{rings}_coarse.msh"]
    sizes = ["--rings", rings, "--coarse-rings", coarse]
    for name, radii in SPACING.items():
        sizes += [f"--stations-{name}", radii * DEFAULT.rings / rings]
    command(folder, "mesh", "lumen.vtp", "--centreline", "centreline.vtp", *names, *sizes)


def solve(folder, rings, coarse, reference):
    """Row of the table; reference: the true FFR."""
    names = [f"r{rings}.msh", "--coarse", f"r{rings}_coarse.msh", "--boundary", "boundary.json"]
    out = f"r{rings}"
    chosen = ["--ffr-tolerance", 0]
    command(folder, "solve", *names, "--centreline", "centreline.vtp", "--out", out, *chosen)
    answer = json.loads((folder / out / "ffr.json").read_text())
    fine = answer["meshes"][-1]
    if fine["status"] == "no flow":
        raise SystemExit(
            f"{rings}:{coarse}: no flow on {rings} rings from that on {coarse}; give another pair of meshes"
        )
    return {
        "rings": rings,
        "coarse_rings": coarse,
        "cells": answer["cells"],
        "dofs": answer["dofs"],
        "ffr": f"{answer['ffr']:.7f}",
        "error": f"{answer['ffr'] - reference:.5f}",
        "linearisations": fine["factorizations"],
        "fine_cpu_s": f"{fine['cpu_seconds']:.0f}",
        "cpu_s": f"{answer['cpu_seconds']:.0f}",
        "mib": f"{answer['peak_memory_mib']:.0f}",
    }


def exponents(rows):
    """[{of: column, exponent}]: each column fitted as a power of the number of cells. Empty for fewer than 3 meshes."""
    found = []
    for column in ("fine_cpu_s", "cpu_s", "mib") if len(rows) > 2 else ():
        cells, values = (np.log([float(row[name]) for row in rows]) for name in ("cells", column))
        found.append({"of": column, "exponent": f"{np.polyfit(cells, values, 1)[0]:.2f}"})
    return found


def write(path, columns, rows):
    """Writes a table."""
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)


def main():
    """Runs the meshes asked for and updates both tables after each solve."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", metavar="RINGS:COARSE")
    parser.add_argument("--out", required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    table, rows = arguments.out / "growth.csv", {}
    if table.is_file():
        with open(table, newline="") as file:
            rows = {int(row["rings"]): row for row in csv.DictReader(file)}
    folder = arguments.out / CASE
    hard_cases.write(CASE, folder)
    reference = hard_cases.STRAIGHT[CASE].reference(hard_cases.FLOW)
    for given in arguments.meshes:
        rings, coarse = map(int, given.split(":"))
        mesh(folder, rings, coarse)
        rows[rings] = solve(folder, rings, coarse, reference)
        print(rows[rings], flush=True)
        ordered = [rows[key] for key in sorted(rows)]
        write(table, COLUMNS, ordered)
        write(arguments.out / "exponents.csv", ("of", "exponent"), exponents(ordered))


if __name__ == "__main__":
    main()
