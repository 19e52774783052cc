"""Tables of flow/measured.md from the results' files: the benchmarks' CSV, and ffr.json of each state of each case.

    /usr/bin/python3 tests/verification/flow/measured_tables.py results

A table stands between the lines `<!-- table: NAME -->` and `<!-- end -->`, NAME being the folder of a benchmark, or
`study`; where nothing of it was run the table stays.
"""

import json
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from page_tables import Page, markdown  # noqa: E402

from common.errors import InputError  # noqa: E402

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
            "artificial": "eps",
            "factorizations": "factorizations",
            "cpu_s": "CPU s",
            "mib": "MiB",
        },
    ),
    "flow_tolerance": (
        "tolerance.csv",
        {
            "case": "case",
            "tolerance": "tolerance",
            "rings": "rings of the meshes",
            "dofs": "dofs",
            "ffr": "FFR",
            "error": "error",
            "estimate": "estimate",
            "met": "met",
            "mesh_cpu_s": "mesh, CPU s",
            "cpu_s": "solve, CPU s",
            "mib": "MiB",
        },
    ),
    "flow_wall_shear": (
        "wall_shear.csv",
        {
            "rings": "rings",
            "wall_layers": "layers",
            "dofs": "dofs",
            "ffr_error": "error of FFR",
            "lesion_rms_percent": "rms, % of the peak",
            "lesion_largest_percent": "largest, %",
            "peak_error_percent": "peak, %",
            "behind_rms_pa": "rms behind, Pa",
            "cpu_s": "CPU s",
        },
    ),
    "flow_growth": (
        "growth.csv",
        {
            "rings": "rings",
            "coarse_rings": "coarse",
            "cells": "cells",
            "dofs": "dofs",
            "ffr": "FFR",
            "error": "error",
            "linearisations": "linearisations",
            "fine_cpu_s": "fine mesh, CPU s",
            "cpu_s": "both, CPU s",
            "mib": "MiB",
        },
    ),
}
STUDY = "study"
STATES = ("pre", "vci", "rc", "reference", "ct")  # in the order of the rows; others of a case follow
STUDY_COLUMNS = ("case", "state", "dofs", "FFR", "estimate", "axisymmetric", "eps", "ends extended")
STUDY_COLUMNS += ("warnings", "factorizations", "CPU s", "MiB")
DIGITS = {"volume_mm3": ".1f", "error": "+.4f", "mesh_cpu_s": ".1f", "solve_cpu_s": ".1f", "settled_cpu_s": ".1f"}


def study(results):
    """Markdown of the states in results/cases/*/flow/*/ffr.json, or None where there is none."""
    order = {state: k for k, state in enumerate(STATES)}
    paths = sorted((results / "cases").glob("*/flow/*/ffr.json"))
    paths.sort(key=lambda path: (path.parts[-4], order.get(path.parts[-2], len(order)), path.parts[-2]))
    return markdown(STUDY_COLUMNS, [state_row(path) for path in paths]) if paths else None


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
            f"{answer['artificial_viscosity']:.2g}",
            f"{len(answer['extensions']['ends'])}",
            f"{len(answer['warnings'])}",
            f"{sum(mesh.get('factorizations', 0) for mesh in answer['meshes'])}",
            f"{answer['cpu_seconds']:.0f}",
            f"{answer['peak_memory_mib']:.0f}",
        ]
    except (json.JSONDecodeError, KeyError, TypeError) as error:
        raise InputError("not an answer of the flow solver", path, repr(error), "solve this state again") from error


PAGE = Page("flow", TABLES, DIGITS, {STUDY: study})

if __name__ == "__main__":
    PAGE.main()
