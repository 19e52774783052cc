"""Cost and error of the flow solver by mesh: python3 tests/verification/flow/growth.py --out DIR RINGS:COARSE ...

The tube with a lesion of 62 % on meshes of RINGS rings with sections in proportion, each solved from the flow on one of
COARSE rings. Writes DIR/growth.csv: rings, coarse_rings, cells, dofs, ffr, its error against axisymmetric.py,
linearisations, CPU seconds of the fine mesh and of the whole process, peak memory; and DIR/exponents.csv: exponents of
cells fitted to CPU seconds and to memory. Rows that are not run again stay.
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

CASE, DEFAULT = "single_62", settings.make()
SPACING = {"throat": DEFAULT.stations_throat, "plain": DEFAULT.stations_plain}  # of the default's rings
COLUMNS = ("rings", "coarse_rings", "cells", "dofs", "ffr", "error", "linearisations", "fine_cpu_s", "cpu_s")
COLUMNS += ("mib",)


def command(folder, *arguments, program=("-m", "flow")):
    """Runs `python3 -m flow` with `arguments` in `folder`, its words in a log there. Raises CalledProcessError.

    program: what Python runs in place of it.
    """
    environment = {"PYTHONPATH": str(hard_cases.ROOT), "PATH": "/usr/bin:/bin", "OMP_NUM_THREADS": "1"}
    environment["HOME"] = str(pathlib.Path.home())  # without it Open MPI 5 does not start
    with open(folder / f"{arguments[0]}.log", "w") as log:
        line = [sys.executable, *program, *map(str, arguments)]
        subprocess.run(line, cwd=folder, stdout=log, stderr=log, env=environment, check=True)


def mesh(folder, rings, coarse):
    """Makes both meshes of the lumen in `folder`, sections as far apart as the default's by the ratio of the rings."""
    names = ["--out", f"r{rings}.msh", "--coarse", f"r{rings}_coarse.msh"]
    sizes = ["--rings", rings, "--coarse-rings", coarse]
    for name, radii in SPACING.items():
        sizes += [f"--stations-{name}", radii * DEFAULT.rings / rings]
    command(folder, "mesh", "lumen.vtp", "--centreline", "centreline.vtp", *names, *sizes)


def solve(folder, rings, coarse, reference):
    """Row of the table; reference: FFR."""
    names = [f"r{rings}.msh", "--coarse", f"r{rings}_coarse.msh", "--boundary", "boundary.json"]
    out = f"r{rings}"
    chosen = ["--ffr-tolerance", 0]
    command(folder, "solve", *names, "--centreline", "centreline.vtp", "--out", out, *chosen)
    answer = json.loads((folder / out / "ffr.json").read_text())
    fine = answer["meshes"][-1]
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
    """[{of, exponent}] of cells in each column, where there are three meshes or more."""
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
