"""The default against the textbook scheme and springs for a wall, on generated scenes: a row each in baseline.csv.

/usr/bin/python3 -m vci.baseline --out results/baseline [--edge 0.5] [--only NAME ...]

`factor` is the CPU time of the scene's textbook run over this row's. Errors are taken against the membrane at 0.6 of
the edge and a tenth of the residual tolerance. One run at a time, one thread; seconds are the whole program's.
"""

import argparse
import csv
import dataclasses
import json
import pathlib
import resource
import sys

import numpy as np

from common.errors import InputError, guarded
from vci.benchmark import run
from vci.scenes import Tube, write_scene

COLUMNS = (
    "case,variant,outcome,steps,cg_iterations,largest_residual,max_penetration_mm,cpu_seconds,factor,"
    "mean_csa_mm2,mla_mm2,mean_csa_error_percent,mla_error_percent"
).split(",")
SCENES = {
    "straight": Tube(stenosis=0.6),
    "curved 0.12 per mm": Tube(stenosis=0.6, curvature=0.12),
    "eccentric": Tube(stenosis=0.6, eccentricity=0.8),
    "calcified": Tube(stenosis=0.55, eccentricity=0.8, calcium_deg=120),
}
TEXTBOOK = {"integration": "textbook", "maximal_steps_per_stage": 20000}
VARIANTS = {
    "adaptive": {},
    "textbook": {"numerics": TEXTBOOK},
    "textbook, solves to 1e-3": {"numerics": TEXTBOOK | {"pcg_tolerance": 1e-3, "pcg_maximal_iterations": 3000}},
    "springs, Lame": {"wall": {"model": "mass-spring"}},
    "springs, Van Gelder": {"wall": {"model": "mass-spring", "spring_mapping": "van_gelder"}},
}


def result_row(program, case, variant, scene):
    """Runs a scene and returns its row, without errors and factor."""
    code, messages, cpu, _ = run([program, "deploy", scene, "--out", scene.parent / "out"])
    row = {"case": case, "variant": variant, "outcome": "refused" if code else "done", "cpu_seconds": round(cpu, 2)}
    if code:
        print(messages.strip().splitlines()[-3:], file=sys.stderr)
        return row
    result = json.loads((scene.parent / "out" / "deployment.json").read_text())
    stages, area = result["stages"], [p["area_mm2"] for p in result["csa_profile"]]
    return row | {
        "steps": sum(s["steps"] for s in stages),
        "cg_iterations": sum(s["cg_iterations"] for s in stages),
        "largest_residual": max(s["residual"] for s in stages),
        "max_penetration_mm": max(s["max_penetration_mm"] for s in stages),
        "mean_csa_mm2": float(np.mean(area)),
        "mla_mm2": min(area),
    }


def compared(rows, truth):
    """Rows with errors in percent against `truth`, and how many times faster than the textbook row each is."""
    textbook = next((r for r in rows if r["variant"] == "textbook"), None)
    for row in rows:
        if textbook:
            row["factor"] = round(textbook["cpu_seconds"] / row["cpu_seconds"], 2)
        for name in ("mean_csa", "mla"):
            if f"{name}_mm2" in row and f"{name}_mm2" in truth:
                row[f"{name}_error_percent"] = round(100 * (row[f"{name}_mm2"] / truth[f"{name}_mm2"] - 1), 2)
    return rows


def run_scene(options, name):
    tube, folder = SCENES[name], options.out / "".join(c if c.isalnum() else "_" for c in name)
    edge, program = options.edge, options.build / "vci"
    fine = dataclasses.replace(tube, edge=0.6 * edge)
    numerics = {"residual_tolerance": 3e-4, "device_edge_mm": 0.3}
    truth = result_row(program, name, "reference", write_scene(folder / "reference", fine, numerics=numerics))
    rows = []
    for number, (variant, how) in enumerate(VARIANTS.items()):
        scene = write_scene(folder / str(number), dataclasses.replace(tube, edge=edge), **how)
        rows.append(result_row(program, name, variant, scene))
        print(f"{name}, {variant}: {rows[-1]}", file=sys.stderr)
    return compared(rows + [truth], truth)


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.baseline", description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", help="names of scenes; all without it")
    parser.add_argument("--edge", type=float, default=0.5, help="mm")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of the program vci")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for baseline.csv and the scenes")
    options = parser.parse_args(arguments)
    unknown = set(options.only or []) - set(SCENES)
    if unknown:
        raise InputError("no such scene", "--only", ", ".join(sorted(unknown)), "use " + "; ".join(SCENES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    options.out.mkdir(parents=True, exist_ok=True)
    with (options.out / "baseline.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for name in options.only or SCENES:
            writer.writerows(run_scene(options, name))
            file.flush()


if __name__ == "__main__":
    main()
