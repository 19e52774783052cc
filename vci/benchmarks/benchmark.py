"""Speed against error of the deployment: scenes at several edges, tolerances, precisions and walls, as CSV and figure.

/usr/bin/python3 -m vci.benchmarks.benchmark [results/cases/quick_branch ...] [--generated] --out results/benchmark

The generated scenes of SCENES and the shipped bifurcation are run if no case folders are given, or before them with
--generated. Tolerances, precisions and walls other than the first are run only at the edge `--varied-at`. A case's
error is its difference to the finest edge that balances at a tenth of the first residual tolerance, or, if none does,
to the finest row that balances (column `reference`). A refused row gives the reason. Runs follow one another on one
thread. `seconds` are the engine's own (wall clock of all stages); `cpu_seconds` and memory are the whole program's.
`microseconds_per_vertex_step` is CPU time over steps and wall vertices. medians.csv holds the medians over the cases.
"""

import argparse
import csv
import dataclasses
import json
import pathlib
import resource
import signal
import sys

import numpy as np

from common.errors import InputError, guarded
from vci.benchmarks.programs import reason_of, run
from vci.benchmarks.scenes import Tube, write_scene
from vci.benchmarks.shipped import culotte, processed
from vci.benchmarks.speed_figures import draw_speed

SETTING = ("edge_mm", "residual_tolerance", "precision", "wall")
ERRORS = ("mean_csa_error_percent", "mla_error_percent")
COLUMNS = (
    "case",
    *SETTING,
    *"outcome,reason,wall_vertices,steps,cg_iterations,largest_residual,max_penetration_mm,seconds,cpu_seconds".split(
        ","
    ),
    *"microseconds_per_vertex_step,peak_memory_mib,mean_csa_mm2,mla_mm2".split(","),
    *ERRORS,
    "reference",
)
MEDIANS = ("steps", "seconds", "cpu_seconds", "microseconds_per_vertex_step", "peak_memory_mib", *ERRORS)
SCENES = {
    "straight": (Tube(stenosis=0.6), {}),
    "curved 0.12 per mm": (Tube(stenosis=0.6, curvature=0.12), {}),
    "curved 0.3 per mm": (Tube(curvature=0.3), {}),
    "eccentric": (Tube(stenosis=0.6, eccentricity=0.8), {}),
    "calcified": (Tube(stenosis=0.55, eccentricity=0.8, calcium_deg=120), {}),
    "long diffuse": (Tube(length=40, stenosis=0.5, lesion_length=24), {"length": 18}),
}
BIFURCATION = "bifurcation"  # the shipped bench's first two steps: a stent across the side branch, optimised
BUDGET = 300  # limit of a run in CPU seconds; a slower one has no place in a table of speeds


def surface_of(case):
    """The surface from which a case's anatomy was made, synthetic or the user's, and its units."""
    source = json.loads((case / "anatomy" / "anatomy.json").read_text())["source"]
    synthetic = case / "source" / "lumen.vtp"
    path = synthetic if synthetic.is_file() else pathlib.Path(source["path"])
    if not path.is_file():
        raise InputError("the case's surface is absent", str(case), str(path), "run the case's anatomy first")
    return path, source["units"]


def remeshed(programs, case, edge, folder):
    """The case's scene (JSON) on its surface remeshed at an edge (mm)."""
    processed(programs, *surface_of(case), edge, folder / "anatomy")
    scene = json.loads((case / "vci" / "scene.json").read_text())
    return scene | {"lumen": "anatomy/lumen.vtp", "centreline": "anatomy/centreline.vtp"}


def generated(name, edge, folder):
    """The generated scene (JSON) at an edge (mm)."""
    tube, how = SCENES[name]
    return json.loads(write_scene(folder, dataclasses.replace(tube, edge=edge), **how).read_text())


def scene_of(programs, case, edge, folder):
    if case == BIFURCATION:
        return culotte(programs, edge, folder, steps=2)
    return generated(case, edge, folder) if case in SCENES else remeshed(programs, case, edge, folder)


def deploy(programs, case, setting, folder):
    """One row: a case (folder or name of a generated scene) at a setting, the devices' edge in proportion."""
    edge, tolerance, precision, wall = setting
    folder.mkdir(parents=True, exist_ok=True)
    scene = scene_of(programs, case, edge, folder)
    numerics = scene.get("numerics", {})
    default = numerics.get("device_edge_mm", 0.45)
    scene["numerics"] = numerics | {"residual_tolerance": tolerance, "device_edge_mm": min(1.0, default * edge / 0.4)}
    scene["numerics"]["pcg_precision"] = precision
    scene["wall"] = scene.get("wall", {}) | {"model": wall}
    (folder / "scene.json").write_text(json.dumps(scene))
    row = outcome_of(programs / "vci", folder / "scene.json", BUDGET)
    return {"case": name_of(case)} | dict(zip(SETTING, setting)) | row


def outcome_of(program, scene, budget=None):
    """Runs a scene (results in vci/ beside it): outcome, CPU seconds, memory and, if it balanced, its results."""
    out = scene.parent / "vci"
    code, messages, cpu = run([program, "deploy", scene, "--out", out], budget)
    if code == -signal.SIGXCPU:
        return {"outcome": "stopped", "reason": f"not done after {budget} CPU s", "cpu_seconds": cpu}
    if code:
        return {"outcome": "refused", "reason": reason_of(messages), "cpu_seconds": cpu}
    result = json.loads((out / "deployment.json").read_text())
    stages, area = result["stages"], areas_of(out)
    steps = sum(s["steps"] for s in stages)
    return {
        "outcome": "balanced",
        "cpu_seconds": cpu,
        "peak_memory_mib": result["peak_memory_mib"],
        "microseconds_per_vertex_step": 1e6 * cpu / (steps * result["wall_vertices"]),
        "wall_vertices": result["wall_vertices"],
        "steps": steps,
        "cg_iterations": sum(s["cg_iterations"] for s in stages),
        "largest_residual": max(s["residual"] for s in stages),
        "max_penetration_mm": max(s["max_penetration_mm"] for s in stages),
        "seconds": result["seconds"],
        "mean_csa_mm2": float(np.nanmean(area)),
        "mla_mm2": float(np.nanmin(area)),
    }


def areas_of(out):
    """Areas (n,) in mm2 along the segment of a run's deployment.json; NaN where the section has no closed outline."""
    profile = json.loads((out / "deployment.json").read_text())["csa_profile"]
    return np.array([row["area_mm2"] for row in profile], float)


def name_of(case):
    return case if isinstance(case, str) else case.name


def medians(rows):
    """A row for each setting: medians over the cases that balanced; errors count by their size."""
    result = []
    for setting in dict.fromkeys(tuple(r[k] for k in SETTING) for r in rows):
        own = [r for r in rows if tuple(r[k] for k in SETTING) == setting and r["outcome"] == "balanced"]
        row = dict(zip(SETTING, setting)) | {"cases": len(own)}
        for key in MEDIANS:
            values = [abs(r[key]) for r in own if key in r]
            row[key] = float(np.median(values)) if values else ""
        result.append(row)
    return result


def write_table(rows, columns, path):
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)


def with_errors(rows, truth):
    """Rows with their errors in percent against the row `truth` (None: none balanced)."""
    for row in rows:
        if truth and row["outcome"] == "balanced":
            for name in ("mean_csa", "mla"):
                row[f"{name}_error_percent"] = 100 * (row[f"{name}_mm2"] / truth[f"{name}_mm2"] - 1)
            if "residual_tolerance" in truth:
                row["reference"] = f"{truth['edge_mm']:g} mm, {truth['residual_tolerance']:g}"
    return rows


def settings_of(options):
    """The settings to run at: every edge with the first tolerance, precision and wall, and one edge with the others."""
    first = (options.tolerances[0], options.precisions[0], options.walls[0])
    settings = [(edge, *first) for edge in sorted(options.edges, reverse=True)]
    for place, values in enumerate((options.tolerances, options.precisions, options.walls)):
        for value in values[1:]:
            other = (*first[:place], value, *first[place + 1 :])
            settings.append((options.varied_at, *other))
    return settings


def run_case(options, case):
    """A case's rows, with errors against its reference.

    The reference is the finest edge that balances at a tenth of the first tolerance. If none does, it is the finest run
    that balanced.
    """

    def row_at(setting):
        folder = options.out / name_of(case).replace(" ", "_") / f"edge_{setting[0]:g}"
        row = deploy(options.build, case, setting, folder)
        print(f"{name_of(case)}, {setting}: {row['outcome']} {row.get('reason', '')}", file=sys.stderr)
        return row

    rows = [row_at(setting) for setting in settings_of(options)]
    usual = (options.precisions[0], options.walls[0])
    for edge in sorted(options.edges):
        rows.append(row_at((edge, float(f"{options.tolerances[0] / 10:.3g}"), *usual)))
        if rows[-1]["outcome"] == "balanced":
            return with_errors(rows, rows[-1])
    known = [r for r in rows if r["outcome"] == "balanced" and (r["precision"], r["wall"]) == usual]
    return with_errors(rows, min(known, key=lambda r: (r["edge_mm"], r["residual_tolerance"]), default=None))


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.benchmarks.benchmark", description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", type=pathlib.Path, help="folders of cases; generated scenes without")
    parser.add_argument("--generated", action="store_true", help="the generated scenes before the folders' cases")
    parser.add_argument("--only", nargs="+", help="names of generated scenes; all without it")
    parser.add_argument("--edges", nargs="+", type=float, default=[1.0, 0.8, 0.6, 0.4, 0.3, 0.25], help="mm")
    parser.add_argument("--tolerances", nargs="+", type=float, default=[3e-3, 1e-2, 1e-3], help="residuals of balance")
    parser.add_argument("--precisions", nargs="+", choices=["single", "double"], default=["single", "double"])
    parser.add_argument("--walls", nargs="+", choices=["membrane", "mass-spring"], default=["membrane", "mass-spring"])
    parser.add_argument("--varied-at", type=float, default=0.4, help="mm: the edge for all but the first of these")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of vci and lumen")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for benchmark.csv and benchmark.png")
    options = parser.parse_args(arguments)
    names = (*SCENES, BIFURCATION)
    unknown = set(options.only or []) - set(names)
    if unknown:
        raise InputError("no such scene", "--only", ", ".join(sorted(unknown)), "use " + "; ".join(names))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    rows = []
    for case in [*((options.only or names) if options.generated or not options.cases else ()), *options.cases]:
        rows += run_case(options, case)
        write_table(rows, COLUMNS, options.out / "benchmark.csv")
        write_table(medians(rows), [*SETTING, "cases", *MEDIANS], options.out / "medians.csv")
    draw_speed(rows, medians(rows), ERRORS, options.out / "benchmark.png")


if __name__ == "__main__":
    main()
