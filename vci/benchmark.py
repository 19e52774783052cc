"""Speed against error of the deployment: scenes at several edges, tolerances and precisions, as CSV and as a figure.

/usr/bin/python3 -m vci.benchmark [results/cases/quick_branch ...] [--generated] --out results/benchmark

The generated scenes of SCENES are run where no case folders are given, or before them with --generated. A case's error
is taken against its own run at the finest edge with a tenth of the smallest residual tolerance. One run at a time, one
thread; `seconds` are the engine's own (wall clock of all stages), `cpu_seconds` and memory those of the whole program,
`microseconds_per_vertex_step` CPU time over steps and wall vertices. medians.csv holds the medians over the cases.
"""

import argparse
import csv
import dataclasses
import json
import os
import pathlib
import resource
import subprocess
import sys

import numpy as np

from common.errors import ComputationError, InputError, guarded
from vci.scenes import Tube, write_scene

COLUMNS = (
    "case,edge_mm,residual_tolerance,precision,outcome,wall_vertices,steps,cg_iterations,largest_residual,"
    "max_penetration_mm,seconds,cpu_seconds,microseconds_per_vertex_step,peak_memory_mib,"
    "mean_csa_mm2,mla_mm2,mean_csa_error_percent,mla_error_percent"
).split(",")

SETTING = ("edge_mm", "residual_tolerance", "precision")
ERRORS = ("mean_csa_error_percent", "mla_error_percent")
MEDIANS = ("steps", "seconds", "cpu_seconds", "microseconds_per_vertex_step", "peak_memory_mib", *ERRORS)
SCENES = {
    "straight": (Tube(stenosis=0.6), {}),
    "curved 0.12 per mm": (Tube(stenosis=0.6, curvature=0.12), {}),
    "curved 0.3 per mm": (Tube(curvature=0.3), {}),
    "eccentric": (Tube(stenosis=0.6, eccentricity=0.8), {}),
    "calcified": (Tube(stenosis=0.55, eccentricity=0.8, calcium_deg=120), {}),
    "long diffuse": (Tube(length=40, stenosis=0.5, lesion_length=24), {"length": 18}),
}


def run(command):
    """(exit code, standard error, CPU seconds) of a program."""
    process = subprocess.Popen([str(c) for c in command], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    messages = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, messages, usage.ru_utime + usage.ru_stime


def surface_of(case):
    """The surface that a case's anatomy was made from, the synthetic one or the user's, with its units."""
    source = json.loads((case / "anatomy" / "anatomy.json").read_text())["source"]
    synthetic = case / "source" / "lumen.vtp"
    path = synthetic if synthetic.is_file() else pathlib.Path(source["path"])
    if not path.is_file():
        raise InputError("the case's surface is absent", str(case), str(path), "run the case's anatomy first")
    return path, source["units"]


def remeshed(programs, case, edge, folder):
    """The case's scene (JSON) on its surface remeshed at an edge (mm)."""
    anatomy = folder / "anatomy"
    surface, units = surface_of(case)
    if not (anatomy / "lumen.vtp").is_file():
        remesh = [programs / "lumen", "process", surface, "--units", units, "--edge", edge, "--out", anatomy]
        code, messages, _ = run(remesh)
        if code:
            raise ComputationError("the lumen cannot be remeshed", str(case), f"edge {edge} mm", messages.strip())
    scene = json.loads((case / "vci" / "scene.json").read_text())
    return scene | {"lumen": "anatomy/lumen.vtp", "centreline": "anatomy/centreline.vtp"}


def generated(name, edge, folder):
    """The generated scene (JSON) at an edge (mm)."""
    tube, how = SCENES[name]
    return json.loads(write_scene(folder, dataclasses.replace(tube, edge=edge), **how).read_text())


def deploy(programs, case, setting, folder):
    """One row: a case (folder or name of a generated scene) at a setting, the devices' edge in proportion."""
    edge, tolerance, precision = setting
    folder.mkdir(parents=True, exist_ok=True)
    scene = generated(case, edge, folder) if case in SCENES else remeshed(programs, case, edge, folder)
    default = scene["numerics"].get("device_edge_mm", 0.45)
    scene["numerics"] |= {"residual_tolerance": tolerance, "device_edge_mm": min(1.0, default * edge / 0.4)}
    scene["numerics"]["pcg_precision"] = precision
    (folder / "scene.json").write_text(json.dumps(scene))
    return {"case": name_of(case)} | dict(zip(SETTING, setting)) | outcome_of(programs / "vci", folder / "scene.json")


def outcome_of(program, scene):
    """Runs a scene (results beside it, in vci/): outcome, CPU seconds, memory and, where it balanced, what came out."""
    out = scene.parent / "vci"
    code, messages, cpu = run([program, "deploy", scene, "--out", out])
    row = {"outcome": "refused" if code else "balanced", "cpu_seconds": cpu}
    if code:
        print(messages.strip().splitlines()[-3:], file=sys.stderr)
        return row
    result = json.loads((out / "deployment.json").read_text())
    stages, area = result["stages"], [p["area_mm2"] for p in result["csa_profile"]]
    steps = sum(s["steps"] for s in stages)
    return row | {
        "peak_memory_mib": result["peak_memory_mib"],
        "microseconds_per_vertex_step": 1e6 * cpu / (steps * result["wall_vertices"]),
        "wall_vertices": result["wall_vertices"],
        "steps": steps,
        "cg_iterations": sum(s["cg_iterations"] for s in stages),
        "largest_residual": max(s["residual"] for s in stages),
        "max_penetration_mm": max(s["max_penetration_mm"] for s in stages),
        "seconds": result["seconds"],
        "mean_csa_mm2": float(np.mean(area)),
        "mla_mm2": min(area),
    }


def name_of(case):
    return case if case in SCENES else case.name


def medians(rows):
    """A row for each setting: medians over the cases that balanced, errors by their size."""
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


def with_errors(rows):
    """Rows with their errors in percent against the case's last row, its finest, where that balanced."""
    truth = rows[-1] if rows[-1]["outcome"] == "balanced" else None
    for row in rows:
        for name in ("mean_csa", "mla"):
            if truth and row["outcome"] == "balanced":
                row[f"{name}_error_percent"] = 100 * (row[f"{name}_mm2"] / truth[f"{name}_mm2"] - 1)
    return rows


def pareto(points):
    """Of (cost, error) pairs those that no cheaper one undercuts, by cost."""
    front = []
    for cost, error in sorted(points):
        if not front or error < front[-1][1]:
            front.append((cost, error))
    return front


def draw(rows, path):
    """Figure: errors of the mean and of the minimal area against seconds with the Pareto front of the medians, and the
    cost of a step per vertex against the number of vertices."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (*both, cost) = pyplot.subplots(1, 3, figsize=(16, 4))
    for axes, key, what in zip(both, ERRORS, ("mean", "minimal")):
        for case in dict.fromkeys(r["case"] for r in rows):
            points = [r for r in rows if r["case"] == case and r.get(key)]
            axes.loglog([r["cpu_seconds"] for r in points], [abs(r[key]) for r in points], "o", label=case)
        front = pareto([(r["cpu_seconds"], r[key]) for r in medians(rows) if r[key]])
        axes.loglog(*zip(*front), "k-", label="front of the medians")
        axes.set(xlabel="CPU seconds, one core", ylabel=f"error of the {what} area in the stent, %")
    both[1].legend(fontsize=8)
    key = "microseconds_per_vertex_step"
    known = [r for r in rows if key in r]
    cost.semilogx([r["wall_vertices"] for r in known], [r[key] for r in known], "o")
    cost.set(xlabel="vertices of the wall", ylabel="microseconds per vertex and step", ylim=(0, None))
    figure.savefig(path, dpi=150, bbox_inches="tight")


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.benchmark", description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", type=pathlib.Path, help="folders of cases; generated scenes without")
    parser.add_argument("--generated", action="store_true", help="the generated scenes before the folders' cases")
    parser.add_argument("--edges", nargs="+", type=float, default=[1.0, 0.8, 0.6, 0.4, 0.3], help="mm")
    parser.add_argument("--tolerances", nargs="+", type=float, default=[3e-3], help="residuals at which a stage ends")
    parser.add_argument("--precisions", nargs="+", choices=["single", "double"], default=["single"])
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of vci and lumen")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for benchmark.csv and benchmark.png")
    options = parser.parse_args(arguments)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    edges = sorted(options.edges, reverse=True)
    settings = [(e, t, p) for e in edges for t in options.tolerances for p in options.precisions]
    settings.append((edges[-1], min(options.tolerances) / 10, options.precisions[-1]))
    rows = []
    for case in [*(SCENES if options.generated or not options.cases else ()), *options.cases]:
        own = []
        for setting in settings:
            folder = options.out / name_of(case).replace(" ", "_") / f"edge_{setting[0]:g}"
            own.append(deploy(options.build, case, setting, folder))
            print(f"{name_of(case)}, {setting}: {own[-1]['outcome']}", file=sys.stderr)
        rows += with_errors(own)
        write_table(rows, COLUMNS, options.out / "benchmark.csv")
    write_table(
        medians(rows),
        [*SETTING, "cases", *MEDIANS],
        options.out / "medians.csv",
    )
    draw(rows, options.out / "benchmark.png")


if __name__ == "__main__":
    main()
