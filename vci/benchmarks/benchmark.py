"""Speed against error of the deployment: scenes at several edges, tolerances, precisions and walls, as CSV and figure.

/usr/bin/python3 -m vci.benchmarks.benchmark [results/cases/quick_branch ...] [--generated] --out results/benchmark

Without case folders, the generated scenes of SCENES and the shipped bifurcation are run; with --generated they are run
before the folders. Every edge is run with the first tolerance, precision and wall, and the edge `--varied-at` also with
the others. Errors are differences from a reference run of the case (see run_case()), which the column `reference`
names. The row of a refused run has the reason. Runs follow one another on one thread. `seconds` is the engine's
wall-clock time for all stages; `cpu_seconds` and memory are those of the whole program. `microseconds_per_vertex_step`
is the CPU time divided by steps and wall vertices. medians.csv has the medians over the cases.
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

from common.errors import InputError, error_summary, guarded
from vci.benchmarks.programs import culotte_scene, process_lumen, run_program
from vci.benchmarks.scenes import Tube, write_scene
from vci.benchmarks.speed_figures import draw_speed

SETTING_COLUMNS = ("edge_mm", "residual_tolerance", "precision", "wall")
ERROR_COLUMNS = ("mean_csa_error_percent", "mla_error_percent")
COLUMNS = (
    "case",
    *SETTING_COLUMNS,
    *"outcome,reason,wall_vertices,steps,cg_iterations,largest_residual,max_penetration_mm,seconds,cpu_seconds".split(
        ","
    ),
    *"microseconds_per_vertex_step,peak_memory_mib,mean_csa_mm2,mla_mm2".split(","),
    *ERROR_COLUMNS,
    "reference",
)
MEDIAN_COLUMNS = ("steps", "seconds", "cpu_seconds", "microseconds_per_vertex_step", "peak_memory_mib", *ERROR_COLUMNS)
SCENES = {
    "straight": (Tube(stenosis=0.6), {}),
    "curved 0.12 per mm": (Tube(stenosis=0.6, curvature=0.12), {}),
    "curved 0.3 per mm": (Tube(curvature=0.3), {}),
    "eccentric": (Tube(stenosis=0.6, eccentricity=0.8), {}),
    "calcified": (Tube(stenosis=0.55, eccentricity=0.8, calcium_deg=120), {}),
    "long diffuse": (Tube(length=40, stenosis=0.5, lesion_length=24), {"length": 18}),
}
BIFURCATION = "bifurcation"  # the shipped bench's first two steps: stent across the side branch, proximal optimisation
BUDGET_CPU_SECONDS = 300  # CPU seconds after which a run is stopped; a slower one has no place in a table of speeds


def source_surface(case):
    """(path, units) of the surface from which a case's anatomy was made: a synthetic one or the user's."""
    source = json.loads((case / "anatomy" / "anatomy.json").read_text())["source"]
    synthetic = case / "source" / "lumen.vtp"
    path = synthetic if synthetic.is_file() else pathlib.Path(source["path"])
    if not path.is_file():
        raise InputError("the case's surface is absent", str(case), str(path), "run the case's anatomy first")
    return path, source["units"]


def remeshed_scene(programs, case, edge, folder):
    """The case's scene (JSON) after its surface was remeshed to the edge length `edge` (mm)."""
    process_lumen(programs, *source_surface(case), edge, folder / "anatomy")
    scene = json.loads((case / "vci" / "scene.json").read_text())
    return scene | {"lumen": "anatomy/lumen.vtp", "centreline": "anatomy/centreline.vtp"}


def generated_scene(name, edge, folder):
    """The generated scene (JSON) with triangles of the edge length `edge` (mm)."""
    tube, scene_options = SCENES[name]
    return json.loads(write_scene(folder, dataclasses.replace(tube, edge=edge), **scene_options).read_text())


def benchmark_scene(programs, case, edge, folder):
    if case == BIFURCATION:
        return culotte_scene(programs, edge, folder, steps=2)
    return generated_scene(case, edge, folder) if case in SCENES else remeshed_scene(programs, case, edge, folder)


def deployment_row(programs, case, setting, folder):
    """Runs a case (folder or name of a scene) and returns its row. The devices' edges scale with the wall's."""
    edge, tolerance, precision, wall = setting
    folder.mkdir(parents=True, exist_ok=True)
    scene = benchmark_scene(programs, case, edge, folder)
    numerics = scene.get("numerics", {})
    default = numerics.get("device_edge_mm", 0.45)
    scene["numerics"] = numerics | {"residual_tolerance": tolerance, "device_edge_mm": min(1.0, default * edge / 0.4)}
    scene["numerics"]["pcg_precision"] = precision
    scene["wall"] = scene.get("wall", {}) | {"model": wall}
    (folder / "scene.json").write_text(json.dumps(scene))
    row = run_outcome(programs / "vci", folder / "scene.json", BUDGET_CPU_SECONDS)
    return {"case": case_name(case)} | dict(zip(SETTING_COLUMNS, setting)) | row


def run_outcome(program, scene, budget=None):
    """Runs a scene into the folder vci/ beside it. Returns {column: value}: outcome, CPU seconds, any results."""
    out = scene.parent / "vci"
    code, messages, cpu = run_program([program, "deploy", scene, "--out", out], budget)
    if code == -signal.SIGXCPU:
        return {"outcome": "stopped", "reason": f"not done after {budget} CPU s", "cpu_seconds": cpu}
    if code:
        return {"outcome": "refused", "reason": error_summary(messages), "cpu_seconds": cpu}
    result = json.loads((out / "deployment.json").read_text())
    stages, area = result["stages"], section_areas(out)
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


def section_areas(out):
    """Areas (n,) in mm2 along the segment of a run's deployment.json; NaN where the section has no closed outline."""
    profile = json.loads((out / "deployment.json").read_text())["csa_profile"]
    return np.array([row["area_mm2"] for row in profile], float)


def case_name(case):
    return case if isinstance(case, str) else case.name


def median_rows(rows):
    """A row for each setting with the medians over the cases that balanced. Errors enter with their absolute value."""
    result = []
    for setting in dict.fromkeys(tuple(r[k] for k in SETTING_COLUMNS) for r in rows):
        balanced_rows = [
            r for r in rows if tuple(r[k] for k in SETTING_COLUMNS) == setting and r["outcome"] == "balanced"
        ]
        row = dict(zip(SETTING_COLUMNS, setting)) | {"cases": len(balanced_rows)}
        for key in MEDIAN_COLUMNS:
            values = [abs(r[key]) for r in balanced_rows if key in r]
            row[key] = float(np.median(values)) if values else ""
        result.append(row)
    return result


def write_table(rows, columns, path):
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)


def add_errors(rows, reference):
    """Adds errors in percent against the row `reference` (None if no run balanced) and returns the rows."""
    for row in rows:
        if reference and row["outcome"] == "balanced":
            for name in ("mean_csa", "mla"):
                row[f"{name}_error_percent"] = 100 * (row[f"{name}_mm2"] / reference[f"{name}_mm2"] - 1)
            if "residual_tolerance" in reference:
                row["reference"] = f"{reference['edge_mm']:g} mm, {reference['residual_tolerance']:g}"
    return rows


def benchmark_settings(options):
    """Settings to run: all edges with the first tolerance, precision and wall, and one edge with each of the others."""
    first = (options.tolerances[0], options.precisions[0], options.walls[0])
    settings = [(edge, *first) for edge in sorted(options.edges, reverse=True)]
    for place, values in enumerate((options.tolerances, options.precisions, options.walls)):
        for value in values[1:]:
            other = (*first[:place], value, *first[place + 1 :])
            settings.append((options.varied_at, *other))
    return settings


def run_case(options, case):
    """Runs a case at all settings and returns its rows, with errors against the case's reference.

    The reference is the run with the finest edge that balances at a tenth of the first tolerance. If none does, it is
    the finest run that balanced.
    """

    def run_setting(setting):
        folder = options.out / case_name(case).replace(" ", "_") / f"edge_{setting[0]:g}"
        row = deployment_row(options.build, case, setting, folder)
        print(f"{case_name(case)}, {setting}: {row['outcome']} {row.get('reason', '')}", file=sys.stderr)
        return row

    rows = [run_setting(setting) for setting in benchmark_settings(options)]
    default_method = (options.precisions[0], options.walls[0])
    for edge in sorted(options.edges):
        rows.append(run_setting((edge, float(f"{options.tolerances[0] / 10:.3g}"), *default_method)))
        if rows[-1]["outcome"] == "balanced":
            return add_errors(rows, rows[-1])
    comparable_rows = [r for r in rows if r["outcome"] == "balanced" and (r["precision"], r["wall"]) == default_method]
    return add_errors(rows, min(comparable_rows, key=lambda r: (r["edge_mm"], r["residual_tolerance"]), default=None))


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
        write_table(median_rows(rows), [*SETTING_COLUMNS, "cases", *MEDIAN_COLUMNS], options.out / "medians.csv")
    draw_speed(rows, median_rows(rows), ERROR_COLUMNS, options.out / "benchmark.png")


if __name__ == "__main__":
    main()
