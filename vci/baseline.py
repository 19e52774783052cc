"""The default against the textbook scheme and springs for a wall, on generated scenes: a row each in baseline.csv.

/usr/bin/python3 -m vci.baseline --out results/baseline [--edge 0.5] [--only NAME ...]

`factor` is the CPU time of the scene's textbook run over this row's. Errors are taken against the membrane at 0.6 of
the edge and a tenth of the residual tolerance. One run at a time, one thread; seconds are the whole program's.
"""

import argparse
import csv
import dataclasses
import pathlib
import resource
import sys

from common.errors import InputError, guarded
from vci.benchmark import SCENES, outcome_of, with_errors
from vci.scenes import write_scene

COLUMNS = (
    "case,variant,edge_mm,outcome,steps,cg_iterations,largest_residual,max_penetration_mm,cpu_seconds,factor,"
    "mean_csa_mm2,mla_mm2,mean_csa_error_percent,mla_error_percent"
).split(",")
NAMES = ("straight", "curved 0.12 per mm", "eccentric", "calcified")  # of the benchmark's scenes
TEXTBOOK = {"integration": "textbook", "maximal_steps_per_stage": 20000}
COARSE = 0.8  # mm: the default once more, on a coarser mesh
VARIANTS = {
    "adaptive": {},
    "textbook": {"numerics": TEXTBOOK},
    "textbook, contact with facets": {"numerics": TEXTBOOK | {"contact_surface": "facets"}},
    "textbook, solves to 1e-3": {"numerics": TEXTBOOK | {"pcg_tolerance": 1e-3, "pcg_maximal_iterations": 3000}},
    "springs, Lame": {"wall": {"model": "mass-spring"}},
    "springs, Van Gelder": {"wall": {"model": "mass-spring", "spring_mapping": "van_gelder"}},
}


def compared(rows):
    """Rows with errors in percent against the last, and how many times faster than the textbook row each is."""
    textbook = next((r for r in rows if r["variant"] == "textbook"), None)
    for row in with_errors(rows):
        if textbook:
            row["factor"] = textbook["cpu_seconds"] / row["cpu_seconds"]
    return rows


def run_scene(options, name):
    """The scene's rows: every variant, then the reference."""
    tube, how = SCENES[name]
    folder, program = options.out / name.replace(" ", "_"), options.build / "vci"
    numerics = {"residual_tolerance": 3e-4, "device_edge_mm": 0.3}
    runs = [(variant, options.edge, settings) for variant, settings in VARIANTS.items()]
    runs.append(("adaptive, coarse", COARSE, {"numerics": {"device_edge_mm": 1.125 * COARSE}}))
    rows = []
    for number, (variant, edge, settings) in enumerate(
        [*runs, ("reference", 0.6 * options.edge, {"numerics": numerics})]
    ):
        scene = write_scene(folder / str(number), dataclasses.replace(tube, edge=edge), **how, **settings)
        rows.append({"case": name, "variant": variant, "edge_mm": edge} | outcome_of(program, scene))
        print(f"{name}, {variant}: {rows[-1]}", file=sys.stderr)
    return compared(rows)


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.baseline", description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", help="names of scenes; all without it")
    parser.add_argument("--edge", type=float, default=0.5, help="mm")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of the program vci")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for baseline.csv and the scenes")
    options = parser.parse_args(arguments)
    unknown = set(options.only or []) - set(NAMES)
    if unknown:
        raise InputError("no such scene", "--only", ", ".join(sorted(unknown)), "use " + "; ".join(NAMES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    options.out.mkdir(parents=True, exist_ok=True)
    with (options.out / "baseline.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore")
        writer.writeheader()
        for name in options.only or NAMES:
            writer.writerows(run_scene(options, name))
            file.flush()


if __name__ == "__main__":
    main()
