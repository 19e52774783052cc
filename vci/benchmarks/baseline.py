"""Compares speed and error of the default solver with the textbook scheme, and with a wall of springs.

/usr/bin/python3 -m vci.benchmarks.baseline --out results/baseline [--edges 1.0 0.8 ...] [--only NAME ...] [--budget 60]
/usr/bin/python3 -m vci.benchmarks.baseline results/cases/lad01 --out results/baseline [--budget 400]

The first command runs generated scenes. The second runs the procedures of a study's cases, on the study's meshes. The
textbook scheme has fixed time steps and solves by conjugate gradients without preconditioner. It moves the whole
vessel, and stops once velocities are small. It is run with contact to the flat triangles, as in textbooks (FACET_RUNS),
and with this engine's smooth contact (TEXTBOOK_RUNS). The default solver is run with several edge lengths, in a case on
the case's own mesh alone. A run that has used up its budget of CPU seconds is stopped.

baseline.csv has a row for each run. Errors are differences from a reference run: the default solver with edges of
REFERENCE_EDGE_MM and a tenth of the default residual tolerance. levels.csv compares the times at which the schemes
reach the same error of the mean area. A row belongs to a scene, a textbook scheme and an error. It gives the cheapest
runs of default and textbook scheme within this error, and the ratio of their times. If a scheme has no such run, the
row gives the scheme's smallest error and the time of all its runs. Runs follow one another on one thread. CPU seconds
are those of the whole program.

patients.csv has a row for each run of a case. `times` is its CPU time over that of the default, and its errors are
against the default on the same mesh at a tenth of its residual tolerance.
"""

import argparse
import dataclasses
import json
import pathlib
import resource
import sys

from common.errors import InputError, guarded
from vci.benchmarks.benchmark import ERROR_COLUMNS, SCENES, add_errors, run_outcome, write_table
from vci.benchmarks.programs import case_scene
from vci.benchmarks.scenes import write_scene
from vci.benchmarks.speed_figures import draw_fronts

COLUMNS = (
    *"case,scheme,edge_mm,fixed_step_ms,velocity_stop_mm_per_ms,pcg_tolerance,outcome,reason".split(","),
    *"steps,cg_iterations,largest_residual,max_penetration_mm,cpu_seconds,mean_csa_mm2,mla_mm2".split(","),
    *ERROR_COLUMNS,
)
LEVEL_COLUMNS = (
    *"case,error_percent,contact,default_edge_mm,default_cpu_seconds,default_error_percent,textbook_edge_mm".split(","),
    *"textbook_step_ms,textbook_stop_mm_per_ms,textbook_cpu_seconds,textbook_error_percent,times".split(","),
)
SCENE_NAMES = ("straight", "eccentric", "calcified", "curved 0.12 per mm")  # scenes in benchmark.SCENES
EDGES_MM = [1.0, 0.8, 0.6, 0.4]  # mm: edge lengths of the wall for the default solver
REFERENCE_EDGE_MM = 0.25  # mm: edge length of the wall for the reference
REFERENCE_NUMERICS = {"residual_tolerance": 3e-4}  # a tenth of the default
ERROR_LEVELS_PERCENT = (5, 3, 1)  # %: errors of the mean area for the rows of levels.csv
LINEAR_SOLVES = {"pcg_tolerance": 1e-3, "pcg_maximal_iterations": 3000}
# Runs of the textbook scheme: edge (mm), fixed step (ms), velocity below which a stage stops (mm/ms), settings of the
# linear solves. On a coarse mesh a small error may be due to chance; the runs on finer meshes show whether it is.
TEXTBOOK_RUNS = [
    *((1.0, 0.01, stop, LINEAR_SOLVES) for stop in (1e-2, 3e-3)),
    *((edge, 0.01, 1e-2, LINEAR_SOLVES) for edge in (0.8, 0.6)),
    (1.0, 0.003, 1e-3, LINEAR_SOLVES),
    (1.0, 0.001, 1e-3, LINEAR_SOLVES),
    (0.6, 0.01, 1e-2, {}),  # linear solves to the default tolerance
]
# Runs with contact to flat triangles. The error of this contact depends on the mesh, so there are three edge lengths.
# At 0.4 mm a run with the longest fixed step (0.01 ms) is not done within 60 CPU seconds, so the step is shorter.
FACET_RUNS = [
    *((edge, 0.01, 1e-2, LINEAR_SOLVES) for edge in (1.0, 0.6)),
    (0.6, 0.003, 1e-3, LINEAR_SOLVES),
    (0.4, 0.003, 1e-2, LINEAR_SOLVES),
]
TEXTBOOK_SCHEMES = {  # textbook schemes by name: value of numerics.contact_surface, runs
    "textbook, contact with facets": ("facets", FACET_RUNS),
    "textbook, smooth contact": ("smooth", TEXTBOOK_RUNS),
}
CASE_STEP_MS, CASE_STOP_MM_PER_MS = 0.01, 1e-2  # the longest step and the largest velocity of the runs above
PATIENT_COLUMNS = (*COLUMNS[:2], *COLUMNS[3:5], *COLUMNS[6:], "times")
SPRING_WALLS = {"springs, Lame": {}, "springs, Van Gelder": {"spring_mapping": "van_gelder"}}


def textbook_settings(surface, step, stop, linear_solves):
    """({column of a table: value}, settings `numerics`) of a run by the textbook scheme.

    surface: value of `contact_surface`. step: its fixed step (ms). stop: velocity (mm/ms) at which a stage ends.
    linear_solves: settings of the linear solves.
    """
    columns = {"fixed_step_ms": step, "velocity_stop_mm_per_ms": stop}
    numerics = {"integration": "textbook", "contact_surface": surface, "maximal_steps_per_stage": 20000}
    return columns, numerics | columns | linear_solves


def scheme_runs(edges):
    """Yields each run of a scene as (scheme, edge in mm, {column of the table: value}, settings of the scene).

    edges: edge lengths (mm) for the runs of the default solver. The last run is the reference.
    """
    for edge in edges:
        yield "default", edge, {}, {}
    for scheme, (surface, runs) in TEXTBOOK_SCHEMES.items():
        for edge, step, stop, linear_solves in runs:
            columns, numerics = textbook_settings(surface, step, stop, linear_solves)
            if linear_solves:
                columns["pcg_tolerance"] = linear_solves["pcg_tolerance"]
            yield scheme, edge, columns, {"numerics": numerics}
    for scheme, mapping in SPRING_WALLS.items():
        yield scheme, max(edges), {}, {"wall": {"model": "mass-spring"} | mapping}
    yield "reference", REFERENCE_EDGE_MM, {}, {"numerics": REFERENCE_NUMERICS}


def run_case(options, case):
    """Runs the procedure of a study's case with every scheme, on the study's mesh. Returns the rows of patients.csv.

    case: folder of the case. The last row is the reference.
    """
    runs = [("default", {}, {})]
    for scheme, (surface, _) in TEXTBOOK_SCHEMES.items():
        runs.append((scheme, *textbook_settings(surface, CASE_STEP_MS, CASE_STOP_MM_PER_MS, LINEAR_SOLVES)))
    rows = []
    for number, (scheme, columns, numerics) in enumerate([*runs, ("reference", {}, REFERENCE_NUMERICS)]):
        folder = options.out / case.name / str(number)
        folder.mkdir(parents=True, exist_ok=True)
        scene = case_scene(case, folder)
        scene["numerics"] = scene.get("numerics", {}) | numerics
        (folder / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
        row = {"case": case.name, "scheme": scheme} | columns
        rows.append(row | run_outcome(options.build / "vci", folder / "scene.json", options.budget))
        rows[-1]["times"] = rows[-1]["cpu_seconds"] / rows[0]["cpu_seconds"]
        print(json.dumps(rows[-1]), file=sys.stderr)
    return add_errors(rows, rows[-1] if rows[-1]["outcome"] == "balanced" else None)


def run_scene(options, name):
    """Runs the scene `name` with every scheme. Returns the rows of the table; the reference's row is the last."""
    tube, scene_options = SCENES[name]
    folder, rows = options.out / name.replace(" ", "_"), []
    for number, (scheme, edge, columns, settings) in enumerate(scheme_runs(options.edges)):
        numerics = {"device_edge_mm": min(1.0, 1.125 * edge)} | settings.get("numerics", {})
        run_folder = folder / str(number)
        scene = write_scene(
            run_folder, dataclasses.replace(tube, edge=edge), **scene_options, **settings | {"numerics": numerics}
        )
        row = {"case": name, "scheme": scheme, "edge_mm": edge} | columns
        rows.append(row | run_outcome(options.build / "vci", scene, options.budget))
        print(json.dumps(rows[-1]), file=sys.stderr)
    return add_errors(rows, rows[-1] if rows[-1]["outcome"] == "balanced" else None)


def level_columns(rows, scheme, error):
    """The columns of a row of levels.csv that compare the default solver with a textbook scheme.

    rows: a scene's rows of baseline.csv. scheme: name of the textbook scheme. error: largest permitted error of the
    mean area (%). The columns describe the cheapest run of each within this error, and the ratio of their times.
    """
    key, row, cheapest = ERROR_COLUMNS[0], {}, {}
    for name, column in (("default", "default"), (scheme, "textbook")):
        scheme_rows = [r for r in rows if r["scheme"] == name]
        within = [r for r in scheme_rows if key in r and abs(r[key]) <= error]
        if within:
            best = cheapest[column] = min(within, key=lambda r: r["cpu_seconds"])
            row[f"{column}_edge_mm"] = best["edge_mm"]
            row[f"{column}_cpu_seconds"] = best["cpu_seconds"]
            row[f"{column}_error_percent"] = best[key]
            if column == "textbook":
                row["textbook_step_ms"] = best["fixed_step_ms"]
                row["textbook_stop_mm_per_ms"] = best["velocity_stop_mm_per_ms"]
        elif scheme_rows:  # no run is within the error: the time of all runs, and their smallest error
            row[f"{column}_edge_mm"] = "not reached"
            row[f"{column}_cpu_seconds"] = sum(r["cpu_seconds"] for r in scheme_rows)
            row[f"{column}_error_percent"] = min((r[key] for r in scheme_rows if key in r), key=abs, default="")
    if len(cheapest) == 2:
        row["times"] = cheapest["textbook"]["cpu_seconds"] / cheapest["default"]["cpu_seconds"]
    return row


def level_rows(rows):
    """The rows of levels.csv, one for each scene, textbook scheme and level of error, from the rows of all runs."""
    table = []
    for case in dict.fromkeys(r["case"] for r in rows):
        case_rows = [r for r in rows if r["case"] == case]
        for scheme, (surface, _) in TEXTBOOK_SCHEMES.items():
            for error in ERROR_LEVELS_PERCENT:
                table.append(
                    {"case": case, "error_percent": error, "contact": surface} | level_columns(case_rows, scheme, error)
                )
    return table


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.benchmarks.baseline", description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", type=pathlib.Path, help="folders with anatomy/ and vci/scene.json")
    parser.add_argument("--only", nargs="+", help="names of scenes; all without it")
    parser.add_argument("--edges", nargs="+", type=float, default=EDGES_MM, help="mm: the default's")
    parser.add_argument("--budget", type=int, default=60, help="CPU seconds after which a run is stopped")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of the program vci")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for baseline.csv and the scenes")
    options = parser.parse_args(arguments)
    unknown = set(options.only or []) - set(SCENE_NAMES)
    if unknown:
        raise InputError("no such scene", "--only", ", ".join(sorted(unknown)), "use " + "; ".join(SCENE_NAMES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    options.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for case in options.cases:
        rows += run_case(options, case)
        table_rows = [{k: r[k] for k in PATIENT_COLUMNS if k in r} for r in rows]
        write_table(table_rows, PATIENT_COLUMNS, options.out / "patients.csv")
    if options.cases:
        return
    for name in options.only or SCENE_NAMES:
        rows += run_scene(options, name)
        table_rows = [{k: r[k] for k in COLUMNS if k in r} for r in rows]
        write_table(table_rows, COLUMNS, options.out / "baseline.csv")
        write_table(level_rows(rows), LEVEL_COLUMNS, options.out / "levels.csv")
    draw_fronts(rows, ("default", *TEXTBOOK_SCHEMES), ERROR_COLUMNS[0], options.out / "baseline.png")


if __name__ == "__main__":
    main()
