"""Tables of flow/measured.md from the results' files: the benchmarks' CSV, and ffr.json of each state of each case.

    /usr/bin/python3 tests/verification/flow/measured_tables.py results

A table stands between the lines `<!-- table: NAME -->` and `<!-- end -->`. NAME is the folder of a benchmark, `study`,
`coverage`, `reach`, `meshes`, `reduced_models` or `audit`. A table stays as it is if its results do not exist. The
benchmarks of the tables KEYS can be run in part. Rows of these tables stay unless they were run again: remove by hand
what holds no more. The tables over all states of a study need a finished study, `results/study`, and have its cases.
"""

import csv
import json
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1]), str(pathlib.Path(__file__).parent)]

import reach_tables  # noqa: E402
from page_tables import Page, markdown, read_columns  # noqa: E402

from common.errors import InputError  # noqa: E402
from flow.errors import error_estimate  # noqa: E402

# benchmark: (the file of its results, {column of the file: heading on the page})
TABLES = {
    "flow_against_openfoam": (
        "benchmark.csv",
        {
            "solver": "solver",
            "resolution": "mesh",
            "error": "error of FFR",
            "solve_cpu_s": "solve, CPU s",
            "outcome": "outcome",
        },
    ),
    "flow_tree_against_openfoam": (
        "tree.csv",
        {
            "state": "state",
            "mesh": "mesh",
            "cells": "cells",
            "ffr": "simpleFoam",
            "our_ffr": "ours",
            "our_estimate": "estimate",
            "difference": "difference",
            "cpu_s": "simpleFoam, CPU s",
            "our_cpu_s": "ours, CPU s",
        },
    ),
    "flow_speed_error": (
        "speed_error.csv",
        {
            "case": "case",
            "solver": "solver",
            "mesh": "mesh",
            "size": "unknowns or cells",
            "cpu_s": "CPU s",
            "error": "error",
            "estimate": "estimate",
            "answers": "default stops",
        },
    ),
    "flow_fda_jet": (
        "jet.csv",
        {"row": "z, mm", **{f"z_{z}": f"{z}" for z in (-20, -8, 0, 8, 16, 24, 32, 60, 80)}, "within": "within 2 SD"}
        | {"ffr": "FFR", "estimate": "estimate"},
    ),
    "flow_hard_cases": (
        "hard_cases.csv",
        {
            "case": "case",
            "error": "error",
            "estimate": "estimate",
            "artificial": "eps",
            "cpu_s": "CPU s",
        },
    ),
    "flow_finer_mesh": (
        "finer_mesh.csv",
        {
            "state": "state",
            "rings": "rings",
            "eps": "eps",
            "ffr": "FFR",
            "estimate": "estimate",
            "finer_rings": "finer: rings",
            "finer_eps": "eps",
            "difference": "FFR minus the answer's",
        },
    ),
    "flow_starts": (
        "starts.csv",
        {
            "state": "state",
            "rest_factorizations": "from rest",
            "reduced_factorizations": "from the reduced models",
            "vci_factorizations": "from `vci`",
            "rest_cpu_s": "CPU s: from rest",
            "reduced_cpu_s": "from the reduced models",
            "vci_cpu_s": "from `vci`",
            "difference": "FFR differs by",
        },
    ),
    "flow_wall_shear": (
        "wall_shear.csv",
        {
            "rings": "rings",
            "wall_layers": "layers",
            "lesion_rms_percent": "rms, % of the peak",
            "peak_error_percent": "peak, %",
            "behind_rms_pa": "rms behind, Pa",
            "cpu_s": "CPU s",
        },
    ),
    "flow_growth": (
        "growth.csv",
        {
            "rings": "rings",
            "dofs": "dofs",
            "error": "error",
            "fine_cpu_s": "fine mesh, CPU s",
            "mib": "MiB",
        },
    ),
}
STUDY, COVERAGE = "study", "coverage"
STUDY_COLUMNS = ("case", "FFR before", "estimate", "eps", "of it by eps", "grad-div, %", "CPU s")
STUDY_COLUMNS += ("estimate after", "CPU s after", "MiB")
COVERAGE_COLUMNS = ("estimates of", "against", "number", "not below the error", "least over the error")
AUDIT_COLUMNS = ("case", "state", "steady FFR", "mean in time", "least", "largest", "units", "of them start-up")
AUDIT_COLUMNS += ("steps", "steady within .005 of the mean")
USED_KEYS = (
    "ffr",
    "energy",
    "error_estimate",
    "artificial_viscosity",
    "cpu_seconds",
    "peak_memory_mib",
    "mesh",
    "meshes",
    "models",
)
# Tables whose rows stay unless they are run again: how many cells tell the rows of each apart.
KEYS = {
    "flow_against_openfoam": 2,
    "flow_tree_against_openfoam": 2,
    "flow_speed_error": 3,
    "flow_hard_cases": 1,
    "flow_finer_mesh": 1,
    "flow_starts": 1,
    "flow_wall_shear": 2,
    "flow_growth": 1,
    COVERAGE: 1,
    "reach": 1,
    "audit": 2,
}
DIGITS = {"volume_mm3": ".1f", "error": "+.4f", "mesh_cpu_s": ".1f", "solve_cpu_s": ".1f", "settled_cpu_s": ".1f"}


def answers(results):
    """[(case, state, document)] of the ffr.json of the study's cases. [] without a study.

    Raises InputError if a file lacks a key.
    """
    study_table, found = results / "study" / "cohort.csv", []
    if not study_table.is_file():
        return []
    cases = {row["case"] for row in read_columns(study_table, ["case"])}
    for path in sorted((results / "cases").glob("*/flow/*/ffr.json")):
        if path.parts[-4] not in cases:
            continue
        try:
            answer = json.loads(path.read_text())
            found.append((path.parts[-4], path.parts[-2], {key: answer[key] for key in USED_KEYS}))
        except (json.JSONDecodeError, KeyError) as error:
            raise InputError("not an answer of the flow solver", path, repr(error), "solve this state again") from error
    return found


def study(results):
    """Markdown with a row for each case; None if no case was solved.

    A row has the state before the intervention, and the largest values of the states after it.
    """
    cases = {}
    for case, state, answer in answers(results):
        cases.setdefault(case, {})[state] = answer
    rows = []
    for case, states in cases.items():
        before, after = states.pop(reach_tables.STATE_BEFORE, None), list(states.values())
        row = [case, *[""] * 6]
        if before:
            row[1:] = f"{before['ffr']:.4f}", error_of(before), f"{before['artificial_viscosity']:.2g}"
            row += effect_of_eps(before), grad_div_percent(before), f"{before['cpu_seconds']:.0f}"
        row.append(max((error_of(answer) for answer in after), default=""))
        row.append(f"{max(answer['cpu_seconds'] for answer in after):.0f}" if after else "")
        row.append(f"{max(answer['peak_memory_mib'] for answer in [before or after[0], *after]):.0f}")
        rows.append(row)
    return markdown(STUDY_COLUMNS, rows) if rows else None


def error_of(answer):
    """The error estimate of an answer; `unknown` if it has none. As a text `unknown` sorts above all numbers."""
    return f"{answer['error_estimate']['ffr']:.4f}" if answer["error_estimate"] else "unknown"


def effect_of_eps(answer):
    """What the artificial viscosity adds to the estimate of FFR; empty without one, or without an estimate."""
    effect = (answer["error_estimate"] or {}).get("artificial_viscosity")
    return f"{error_estimate.SAFETY_FACTOR * abs(effect):.4f}" if effect is not None else ""


def grad_div_percent(answer):
    """Share of the grad-div term in the power that is lost between inlet and outlets, in percent."""
    energy = answer["energy"]
    lost = sum(energy[name] for name in ("friction_w", "grad_div_w", "artificial_w", "backflow_w"))
    return f"{100 * energy['grad_div_w'] / lost:.1f}"


def coverage(results):
    """Markdown that shows how often an estimate is not below the true error. None if nothing was run.

    In trees the true error is unknown. The change of FFR to the next finer mesh takes its place.
    """
    rows, hard = [], results / "benchmarks" / "flow_hard_cases" / "hard_cases.csv"
    if hard.is_file():
        with hard.open(newline="") as file:
            pairs = [(row["estimate"], row["error"]) for row in csv.DictReader(file) if row["error"]]
        rows += coverage_row("straight tubes, the default's answers", "axisymmetric solution", pairs)
    pairs = {"before": [], "after": []}
    for _, state, answer in answers(results):
        meshes = [mesh for mesh in answer["meshes"] if mesh.get("error_estimate") is not None]
        for coarse, fine in zip(meshes, meshes[1:]):
            pairs["before" if state == reach_tables.STATE_BEFORE else "after"].append(
                (coarse["error_estimate"], fine["ffr"] - coarse["ffr"])
            )
    for when, found in pairs.items():
        rows += coverage_row(f"trees {when} PCI, meshes passed over", "next finer mesh", found)
    finer = results / "benchmarks" / "flow_finer_mesh" / "finer_mesh.csv"
    if finer.is_file():
        found = read_columns(finer, TABLES["flow_finer_mesh"][1])
        for when, pairs in reach_tables.pairs_of_finer_meshes(found).items():
            known = [pair for pair in pairs if pair[0] != "unknown"]
            rows += coverage_row(f"trees {when} PCI, answers", "next finer mesh", known)
    return markdown(COVERAGE_COLUMNS, rows) if rows else None


def coverage_row(what, against, pairs):
    """[row] that sums up pairs (estimate, error); [] if there are no pairs."""
    ratios = [float(estimate) / max(abs(float(error)), 1e-6) for estimate, error in pairs]
    enough = sum(ratio >= 1 for ratio in ratios)
    return [[what, against, f"{len(ratios)}", f"{enough}", f"{min(ratios):.1f}"]] if ratios else []


def audit(results):
    """Markdown with a row for each state that was marched in time (`flow audit`); None if none was."""
    rows = []
    for path in sorted((results / "cases").glob("*/flow/*/audit.json")):
        found = json.loads(path.read_text())
        row = [path.parts[-4], path.parts[-2], f"{found['ffr_steady']:.4f}"]
        row.append(f"{found['ffr_mean']:.4f} ± {found['ffr_mean_half_width_95']:.4f}")
        row += [f"{found[key]:.4f}" for key in ("ffr_least", "ffr_most")]
        row += [f"{found['time_units']:.0f}", f"{found['start_up_units']:.1f}"]
        row += [f"{found['steps']}", {True: "yes", False: "no", None: "not settled"}[found["agrees"]]]
        rows.append(row)
    return markdown(AUDIT_COLUMNS, rows) if rows else None


def reach(results):
    """Markdown: the aims for the solver beside what was found; None without a study."""
    return reach_tables.reach(results, answers(results))


def meshes(results):
    """Markdown: what each mesh of the sequence costs over all states; None without a study."""
    return reach_tables.meshes(answers(results))


def reduced_models(results):
    """Markdown: how far reduced models are from 3D; None without a study."""
    return reach_tables.reduced_models(answers(results))


FUNCTIONS = {
    STUDY: study,
    COVERAGE: coverage,
    "reach": reach,
    "meshes": meshes,
    "reduced_models": reduced_models,
    "audit": audit,
}
PAGE = Page("flow", TABLES, DIGITS, FUNCTIONS, KEYS)

if __name__ == "__main__":
    PAGE.main()
