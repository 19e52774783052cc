"""Speed against error of the deployment: each case at several edges, as CSV and as a figure.

/usr/bin/python3 -m vci.benchmark results/cases/quick_focal --edges 0.8 0.6 0.4 0.3 --out results/benchmark

A case's error is taken against its own run at the finest edge with a tenth of the residual tolerance. One run at a
time, one thread; `seconds` are the engine's own (all stages), `cpu_seconds` and memory those of the whole program.
"""

import argparse
import csv
import json
import os
import pathlib
import resource
import subprocess
import sys

import numpy as np

from common.errors import ComputationError, InputError

COLUMNS = (
    "case,edge_mm,residual_tolerance,outcome,wall_vertices,steps,cg_iterations,largest_residual,max_penetration_mm,"
    "seconds,cpu_seconds,peak_memory_mib,mean_csa_mm2,mla_mm2,mean_csa_error_percent,mla_error_percent"
).split(",")


def run(command):
    """(exit code, standard error, CPU seconds, peak memory in MiB) of a program."""
    process = subprocess.Popen([str(c) for c in command], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    messages = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, messages, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def surface_of(case):
    """The surface that a case's anatomy was made from, the synthetic one or the user's, with its units."""
    source = json.loads((case / "anatomy" / "anatomy.json").read_text())["source"]
    synthetic = case / "source" / "lumen.vtp"
    path = synthetic if synthetic.is_file() else pathlib.Path(source["path"])
    if not path.is_file():
        raise InputError("the case's surface is absent", str(case), str(path), "run the case's anatomy first")
    return path, source["units"]


def deploy(programs, case, edge, tolerance, folder):
    """One row: the case remeshed at an edge (mm), the devices' edge in proportion, run to a residual tolerance."""
    anatomy, out = folder / "anatomy", folder / "vci"
    surface, units = surface_of(case)
    if not (anatomy / "lumen.vtp").is_file():
        remesh = [programs / "lumen", "process", surface, "--units", units, "--edge", edge, "--out", anatomy]
        code, messages, _, _ = run(remesh)
        if code:
            raise ComputationError("the lumen cannot be remeshed", str(case), f"edge {edge} mm", messages.strip())
    scene = json.loads((case / "vci" / "scene.json").read_text())
    scene |= {"lumen": "anatomy/lumen.vtp", "centreline": "anatomy/centreline.vtp"}
    default = scene["numerics"].get("device_edge_mm", 0.45)
    scene["numerics"] |= {"residual_tolerance": tolerance, "device_edge_mm": min(1.0, default * edge / 0.4)}
    (folder / "scene.json").write_text(json.dumps(scene))
    code, messages, cpu, memory = run([programs / "vci", "deploy", folder / "scene.json", "--out", out])
    row = {"case": case.name, "edge_mm": edge, "residual_tolerance": tolerance, "cpu_seconds": cpu}
    row |= {"peak_memory_mib": memory, "outcome": "refused" if code else "balanced"}
    if code:
        print(messages.strip().splitlines()[-3:], file=sys.stderr)
        return row
    result = json.loads((out / "deployment.json").read_text())
    stages, area = result["stages"], [p["area_mm2"] for p in result["csa_profile"]]
    return row | {
        "wall_vertices": result["wall_vertices"],
        "steps": sum(s["steps"] for s in stages),
        "cg_iterations": sum(s["cg_iterations"] for s in stages),
        "largest_residual": max(s["residual"] for s in stages),
        "max_penetration_mm": max(s["max_penetration_mm"] for s in stages),
        "seconds": result["seconds"],
        "mean_csa_mm2": float(np.mean(area)),
        "mla_mm2": min(area),
    }


def with_errors(rows):
    """Rows with their errors in percent against the case's last balanced row, its finest."""
    truth = next((r for r in reversed(rows) if r["outcome"] == "balanced"), None)
    for row in rows:
        for name in ("mean_csa", "mla"):
            if truth and row["outcome"] == "balanced":
                row[f"{name}_error_percent"] = 100 * (row[f"{name}_mm2"] / truth[f"{name}_mm2"] - 1)
    return rows


def draw(rows, path):
    """Pareto figure: error of the mean area against seconds, a line per case."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6, 4))
    for case in sorted({r["case"] for r in rows}):
        points = [r for r in rows if r["case"] == case and r.get("mean_csa_error_percent")]
        axes.loglog(
            [r["seconds"] for r in points], [abs(r["mean_csa_error_percent"]) for r in points], "o-", label=case
        )
    axes.set(xlabel="seconds, one core", ylabel="error of the mean area in the stent, %")
    axes.legend()
    figure.savefig(path, dpi=150, bbox_inches="tight")


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.benchmark", description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="+", type=pathlib.Path, help="result folders of cases with anatomy and scene")
    parser.add_argument("--edges", nargs="+", type=float, default=[0.8, 0.6, 0.4, 0.3], help="mm, coarse to fine")
    parser.add_argument("--tolerance", type=float, default=3e-3, help="residual at which a stage ends")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of vci and lumen")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for benchmark.csv and benchmark.png")
    options = parser.parse_args(arguments)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    edges, rows = sorted(options.edges, reverse=True), []
    for case in options.cases:
        own = []
        for edge, tolerance in [(e, options.tolerance) for e in edges] + [(edges[-1], options.tolerance / 10)]:
            folder = options.out / case.name / f"edge_{edge:g}"
            folder.mkdir(parents=True, exist_ok=True)
            own.append(deploy(options.build, case, edge, tolerance, folder))
            print(f"{case.name}, edge {edge:g} mm, {tolerance:g}: {own[-1]['outcome']}", file=sys.stderr)
        rows += with_errors(own)
    with (options.out / "benchmark.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, options.out / "benchmark.png")


if __name__ == "__main__":
    main()
