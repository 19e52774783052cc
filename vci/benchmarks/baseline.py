"""Compares speed and error of the default solver with the textbook scheme, and with a wall of springs.

/usr/bin/python3 -m vci.benchmarks.baseline --out results/baseline [--edges 1.0 0.8 ...] [--only NAME ...] [--budget 60]

All runs are on generated scenes. The textbook scheme has fixed time steps and solves by conjugate gradients without
preconditioner. It stops once velocities are small, and moves the whole vessel. It is run with contact to the flat
triangles, as in textbooks, with the meshes and settings in FACETS. It is run again with this engine's smooth contact,
with those in TEXTBOOK. The default solver is run with several edge lengths. A run that has used its budget of CPU
seconds is stopped.

baseline.csv has a row for each run. A run's errors are its differences to the reference: the default solver with edges
of REFERENCE mm and a tenth of the default residual tolerance. levels.csv has rows for levels of error of the mean area.
A row gives, for a scene and a level, the cheapest run of each scheme within this error, and the ratio of their times.
If no run of a scheme has so small an error, the row gives the scheme's smallest error and the time of all its runs.
Runs follow one another on one thread. CPU seconds are those of the whole program.
"""

import argparse
import dataclasses
import json
import pathlib
import resource
import sys

from common.errors import InputError, guarded
from vci.benchmarks.benchmark import ERRORS, SCENES, outcome_of, with_errors, write_table
from vci.benchmarks.scenes import write_scene
from vci.benchmarks.speed_figures import draw_fronts

COLUMNS = (
    *"case,scheme,edge_mm,fixed_step_ms,velocity_stop_mm_per_ms,pcg_tolerance,outcome,reason".split(","),
    *"steps,cg_iterations,largest_residual,max_penetration_mm,cpu_seconds,mean_csa_mm2,mla_mm2".split(","),
    *ERRORS,
)
LEVEL_COLUMNS = (
    *"case,error_percent,contact,default_edge_mm,default_cpu_seconds,default_error_percent,textbook_edge_mm".split(","),
    *"textbook_step_ms,textbook_stop_mm_per_ms,textbook_cpu_seconds,textbook_error_percent,times".split(","),
)
NAMES = ("straight", "eccentric", "calcified", "curved 0.12 per mm")  # scenes in benchmark.SCENES
EDGES = [1.0, 0.8, 0.6, 0.4]  # mm: edge lengths of the wall for the default solver
REFERENCE = 0.25  # mm: edge length of the wall for the reference
LEVELS = (5, 3, 1)  # %: errors of the mean area for the rows of levels.csv
SOLVES = {"pcg_tolerance": 1e-3, "pcg_maximal_iterations": 3000}
# Runs of the textbook scheme: edge (mm), fixed step (ms), velocity at which it stops (mm/ms), settings of the linear
# solves. The finer meshes show which small errors are due to chance.
TEXTBOOK = [
    *((1.0, 0.01, stop, SOLVES) for stop in (1e-2, 3e-3)),
    *((edge, 0.01, 1e-2, SOLVES) for edge in (0.8, 0.6)),
    (1.0, 0.003, 1e-3, SOLVES),
    (1.0, 0.001, 1e-3, SOLVES),
    (0.6, 0.01, 1e-2, {}),  # linear solves to the default tolerance
]
# Runs with contact to flat triangles, whose error depends on the mesh. At edges of 0.4 mm, a run with the longest fixed
# step (0.01 ms) is not done within 60 CPU seconds.
FACETS = [
    *((edge, 0.01, 1e-2, SOLVES) for edge in (1.0, 0.6)),
    (0.6, 0.003, 1e-3, SOLVES),
    (0.4, 0.003, 1e-2, SOLVES),
]
SCHEMES = {  # textbook schemes by name: value of numerics.contact_surface, runs
    "textbook, contact with facets": ("facets", FACETS),
    "textbook, smooth contact": ("smooth", TEXTBOOK),
}
SPRINGS = {"springs, Lame": {}, "springs, Van Gelder": {"spring_mapping": "van_gelder"}}


def runs_of(edges):
    """Yields each run of a scene as (scheme, edge in mm, {column of the table: value}, settings of the scene).

    `edges` (mm) are those of the default solver. The last run is the reference.
    """
    for edge in edges:
        yield "default", edge, {}, {}
    for scheme, (surface, runs) in SCHEMES.items():
        for edge, step, stop, solves in runs:
            columns = {"fixed_step_ms": step, "velocity_stop_mm_per_ms": stop}
            numerics = {"integration": "textbook", "contact_surface": surface, "maximal_steps_per_stage": 20000}
            if solves:
                columns["pcg_tolerance"] = solves["pcg_tolerance"]
            yield scheme, edge, columns, {"numerics": numerics | columns | solves}
    for scheme, mapping in SPRINGS.items():
        yield scheme, max(edges), {}, {"wall": {"model": "mass-spring"} | mapping}
    yield "reference", REFERENCE, {}, {"numerics": {"residual_tolerance": 3e-4}}


def run_scene(options, name):
    """Runs the scene `name` with every scheme. Returns the rows of the table; the reference's row is the last."""
    tube, how = SCENES[name]
    folder, rows = options.out / name.replace(" ", "_"), []
    for number, (scheme, edge, columns, settings) in enumerate(runs_of(options.edges)):
        numerics = {"device_edge_mm": min(1.0, 1.125 * edge)} | settings.get("numerics", {})
        place = folder / str(number)
        scene = write_scene(place, dataclasses.replace(tube, edge=edge), **how, **settings | {"numerics": numerics})
        row = {"case": name, "scheme": scheme, "edge_mm": edge} | columns
        rows.append(row | outcome_of(options.build / "vci", scene, options.budget))
        print(json.dumps(rows[-1]), file=sys.stderr)
    return with_errors(rows, rows[-1] if rows[-1]["outcome"] == "balanced" else None)


def level(rows, scheme, error):
    """Columns of levels.csv for a scene's rows, a textbook scheme and a largest error of the mean area (%).

    They describe the cheapest runs of the default and of this scheme within the error, and the ratio of their times.
    """
    key, row, cheapest = ERRORS[0], {}, {}
    for name, column in (("default", "default"), (scheme, "textbook")):
        tried = [r for r in rows if r["scheme"] == name]
        within = [r for r in tried if key in r and abs(r[key]) <= error]
        if within:
            best = cheapest[column] = min(within, key=lambda r: r["cpu_seconds"])
            row[f"{column}_edge_mm"] = best["edge_mm"]
            row[f"{column}_cpu_seconds"] = best["cpu_seconds"]
            row[f"{column}_error_percent"] = best[key]
            if column == "textbook":
                row["textbook_step_ms"] = best["fixed_step_ms"]
                row["textbook_stop_mm_per_ms"] = best["velocity_stop_mm_per_ms"]
        elif tried:  # no run is within the error: the time of all runs, and their smallest error
            row[f"{column}_edge_mm"] = "not reached"
            row[f"{column}_cpu_seconds"] = sum(r["cpu_seconds"] for r in tried)
            row[f"{column}_error_percent"] = min((r[key] for r in tried if key in r), key=abs, default="")
    if len(cheapest) == 2:
        row["times"] = cheapest["textbook"]["cpu_seconds"] / cheapest["default"]["cpu_seconds"]
    return row


def levels(rows):
    """The rows of levels.csv, one for each scene, textbook scheme and level of error, from the rows of all runs."""
    table = []
    for case in dict.fromkeys(r["case"] for r in rows):
        own = [r for r in rows if r["case"] == case]
        for scheme, (surface, _) in SCHEMES.items():
            for error in LEVELS:
                table.append({"case": case, "error_percent": error, "contact": surface} | level(own, scheme, error))
    return table


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.benchmarks.baseline", description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", help="names of scenes; all without it")
    parser.add_argument("--edges", nargs="+", type=float, default=EDGES, help="mm: the default's")
    parser.add_argument("--budget", type=int, default=60, help="CPU seconds after which a run is stopped")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of the program vci")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for baseline.csv and the scenes")
    options = parser.parse_args(arguments)
    unknown = set(options.only or []) - set(NAMES)
    if unknown:
        raise InputError("no such scene", "--only", ", ".join(sorted(unknown)), "use " + "; ".join(NAMES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    options.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in options.only or NAMES:
        rows += run_scene(options, name)
        known = [{k: r[k] for k in COLUMNS if k in r} for r in rows]
        write_table(known, COLUMNS, options.out / "baseline.csv")
        write_table(levels(rows), LEVEL_COLUMNS, options.out / "levels.csv")
    draw_fronts(rows, ("default", *SCHEMES), ERRORS[0], options.out / "baseline.png")


if __name__ == "__main__":
    main()
