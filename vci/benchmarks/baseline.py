"""Compares the default scheme with the textbook scheme at several costs, and with springs for a wall.

/usr/bin/python3 -m vci.benchmarks.baseline --out results/baseline [--edges 1.0 0.8 ...] [--only NAME ...] [--budget 60]

All runs are on generated scenes. The textbook scheme has fixed steps and conjugate gradients without preconditioner to
1e-3. It stops by velocity and moves the whole vessel. It is run with contact to the flat triangles, as in textbooks, at
the meshes, steps and velocity stops of FACETS. It is run again with this engine's smooth contact, at those of TEXTBOOK.
The default is run at several edges. A run that has used the budget of CPU seconds is stopped.

baseline.csv has a row for each run. Errors are differences to the default at REFERENCE mm and a tenth of its tolerance,
with areas measured in the same way. levels.csv has, for each scene and level of error of the mean area, the cheapest
run of each scheme within that level, and the ratio of their times. If no run of the textbook scheme is within it, the
table has its smallest error and the time of all its runs. Runs follow one another on one thread; seconds are the whole
program's.
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
NAMES = ("straight", "eccentric", "calcified", "curved 0.12 per mm")  # of the benchmark's scenes
EDGES = [1.0, 0.8, 0.6, 0.4]  # mm, of the default
REFERENCE = 0.25  # mm
LEVELS = (5, 3, 1)  # %, of the mean area
SOLVES = {"pcg_tolerance": 1e-3, "pcg_maximal_iterations": 3000}
# edge (mm), fixed step (ms), velocity stop (mm/ms), the linear solves; finer meshes show which small errors are chance
TEXTBOOK = [
    *((1.0, 0.01, stop, SOLVES) for stop in (1e-2, 3e-3)),
    *((edge, 0.01, 1e-2, SOLVES) for edge in (0.8, 0.6)),
    (1.0, 0.003, 1e-3, SOLVES),
    (1.0, 0.001, 1e-3, SOLVES),
    (0.6, 0.01, 1e-2, {}),  # solved no better than the default's
]
# the same for contact to flat triangles, whose error depends on the mesh; 0.4 mm takes over 60 s at the longest step
FACETS = [
    *((edge, 0.01, 1e-2, SOLVES) for edge in (1.0, 0.6)),
    (0.6, 0.003, 1e-3, SOLVES),
    (0.4, 0.003, 1e-2, SOLVES),
]
SCHEMES = {  # of the textbook: the contact's surface, its runs
    "textbook, contact with facets": ("facets", FACETS),
    "textbook, smooth contact": ("smooth", TEXTBOOK),
}
SPRINGS = {"springs, Lame": {}, "springs, Van Gelder": {"spring_mapping": "van_gelder"}}


def runs_of(edges):
    """Yields every run of a scene: (scheme, edge in mm, {column of the table: value}, settings of the scene).

    The reference is the last.
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
    """The scene's rows: every scheme, the springs, then the reference."""
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
    """Columns of the cheapest runs of the default and of a textbook scheme within an error (%), and their ratio."""
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
        elif tried:  # not reached: the time of all runs, and their smallest error
            row[f"{column}_edge_mm"] = "not reached"
            row[f"{column}_cpu_seconds"] = sum(r["cpu_seconds"] for r in tried)
            row[f"{column}_error_percent"] = min((r[key] for r in tried if key in r), key=abs, default="")
    if len(cheapest) == 2:
        row["times"] = cheapest["textbook"]["cpu_seconds"] / cheapest["default"]["cpu_seconds"]
    return row


def levels(rows):
    """A row for each case, textbook scheme and level of error: the cheapest runs within it and their ratio."""
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
