"""Speed against error beside OpenFOAM: /usr/bin/python3 tests/verification/flow/against_openfoam.py --out DIR.

A straight tube (D 3.2 mm, L 50 mm) with a cosine lesion of 62 % at 15-25 mm, a parabolic inflow of 150 mL/min, 70 mmHg
at the outlet. FFR is the pressure on the axis at 45 mm over that at the inlet; its error is against an axisymmetric
Q3-Q2 solution that shares no code with either. Writes benchmark.csv and benchmark.png; CPU seconds of one core.
"""

import argparse
import csv
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "unit" / "flow")]

import openfoam_case  # noqa: E402
import tubes  # noqa: E402

from common.errors import ComputationError, InputError, guarded  # noqa: E402
from flow import settings  # noqa: E402

OUTLET, FLOW, DENSITY, VISCOSITY = 70 * 133.322, 150e-6 / 60, 1060.0, 0.004  # SI
RADIUS, LENGTH, THROAT, REDUCTION = 1.6, 50.0, 20.0, 0.62  # mm
PLACES = (0.01, 45.0)  # mm: just behind the inlet, and where FFR is read
OPENFOAM_EDGES = (0.8, 0.55, 0.4, 0.3, 0.22)  # mm
RINGS = (3, 4, 5, 6)  # of our only mesh
ADAPTIVE = 0  # in their place: the default, two meshes made, the coarse one solved and the fine one where it is needed
TIMES = ("mesh_cpu_s", "solve_cpu_s")
COLUMNS = (
    "solver",
    "resolution",
    "cells",
    "ffr",
    "error",
    "mesh_cpu_s",
    "solve_cpu_s",
    "iterations",
    "gradient",
    "outcome",
)
RADIUS_PROFILE = tubes.lesion(RADIUS, REDUCTION, THROAT, 10)


def document():
    """boundary.json: the inflow given, the pressure at the outlet."""
    point = tubes.line(LENGTH, RADIUS_PROFILE).point(PLACES[1]).tolist()
    outlet = {"name": "outlet1", "region_id": 2, "branch": "main", "flow_m3_per_s": FLOW}
    outlet |= {"resistance_pa_s_per_m3": 0.0, "pressure_pa": OUTLET}
    return {
        "map_pa": 93 * 133.322,  # not used: the inflow is given
        "venous_pressure_pa": 0.0,
        "density_kg_per_m3": DENSITY,
        "viscosity_pa_s": VISCOSITY,
        "inlet_flow_m3_per_s": FLOW,
        "outlets": [outlet],
        "probes": [{"name": "distal", "branch": "main", "s_mm": PLACES[1], "point_mm": point}],
    }


def ffr(pressures):
    """FFR of pressures over the outlet's at PLACES."""
    return (OUTLET + pressures[1]) / (OUTLET + pressures[0])


def reference():
    """FFR of the axisymmetric solution."""
    from axisymmetric import Tube

    return ffr(Tube(RADIUS_PROFILE, LENGTH, THROAT, document(), (220, 24)).pressures(FLOW, PLACES))


def openfoam(edge_mm, folder):
    """Row of one OpenFOAM mesh."""
    row = {"solver": "OpenFOAM", "resolution": f"edge {edge_mm} mm"}
    tube = RADIUS_PROFILE, LENGTH, THROAT, PLACES
    try:
        found = openfoam_case.run(folder, *tube, edge_mm, FLOW, DENSITY, VISCOSITY)
    except ComputationError as error:
        return row | {"outcome": str(error).splitlines()[0]}
    return row | {"ffr": ffr(found.pop("pressures_pa")), "outcome": "converged"} | found


def spacing(rings):
    """Options by which the sections are as far apart as `flow mesh` sets them on a coarse mesh with so many rings."""
    defaults = settings.make()
    ratio = defaults.rings / rings
    return [
        text
        for name in ("stations_throat", "stations_plain")
        for text in ("--" + name.replace("_", "-"), str(getattr(defaults, name) * ratio))
    ]


def ours(rings, folder):
    """Row of one mesh with so many rings, or of the default settings (ADAPTIVE)."""
    row = {"solver": "vci", "resolution": f"{rings} rings" if rings else "default, adaptive"}
    folder.mkdir(parents=True, exist_ok=True)
    branch = tubes.line(LENGTH, RADIUS_PROFILE)
    tubes.write_case(folder, tubes.tube(LENGTH, RADIUS_PROFILE, 0.4), [branch], None)
    (folder / "boundary.json").write_text(json.dumps(document()))
    meshes, line = ["mesh.msh"] + ["--coarse", "mesh_coarse.msh"] * (not rings), ["--centreline", "centreline.vtp"]
    sizes = ["--rings", str(rings), *spacing(rings)] if rings else []
    seconds = []
    for command in (
        ["mesh", "lumen.vtp", *line, "--out", *meshes, *sizes],
        ["solve", *meshes, *line, "--boundary", "boundary.json", "--out", ".", *sizes],
    ):
        started = sum(os.times()[2:4])
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
        with open(folder / f"{command[0]}.log", "w") as log:
            done = subprocess.run(
                [sys.executable, "-m", "flow", *command], cwd=folder, stdout=log, stderr=log, env=environment
            )
        seconds.append(sum(os.times()[2:4]) - started)
        if done.returncode:
            return row | {"outcome": f"{command[0]} ended with exit code {done.returncode}"}
    answer = json.loads((folder / "ffr.json").read_text())
    return row | {
        "cells": answer["cells"],
        "ffr": answer["ffr"],
        "mesh_cpu_s": seconds[0],
        "solve_cpu_s": seconds[1],
        "iterations": answer["iterations"],
        "outcome": "converged with eddy viscosity" if answer["jet_mixing"] else answer["status"],
    }


def draw(rows, path):
    """Error of FFR against CPU seconds of the solve, and of mesh and solve."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(9, 4), sharey=True)
    for panel, keys, title in ((axes[0], ("solve_cpu_s",), "solve"), (axes[1], TIMES, "mesh and solve")):
        for solver, colour in (("vci", "#0a5a94"), ("OpenFOAM", "#c4622d")):
            points = [
                (sum(r[k] for k in keys), abs(r["error"])) for r in rows if r["solver"] == solver and "error" in r
            ]
            panel.loglog(*zip(*points), "o-", color=colour, label=solver)
        panel.set(xlabel="CPU seconds", title=title)
        panel.grid(True, which="both", alpha=0.3)
    axes[0].set_ylabel("error of FFR")
    axes[0].legend()
    figure.savefig(path, dpi=150, bbox_inches="tight")


def factor(rows):
    """Largest of OpenFOAM's CPU seconds over ours at no less error than ours, mesh and solve: {our row: factor}."""
    found = {}
    for own in (r for r in rows if r["solver"] == "vci" and "error" in r):
        worse = [r for r in rows if r["solver"] == "OpenFOAM" and abs(r.get("error", 1)) >= abs(own["error"])]
        best = [r for r in rows if r["solver"] == "OpenFOAM" and abs(r.get("error", 1)) < abs(own["error"])]
        rivals = best or worse[-1:]
        if rivals:
            ratio = min(sum(r[k] for k in TIMES) for r in rivals) / sum(own[k] for k in TIMES)
            found[own["resolution"]] = (ratio, bool(best))
    return found


@guarded
def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder of table, figure and the runs")
    parser.add_argument("--edges", nargs="+", type=float, default=OPENFOAM_EDGES, help="of OpenFOAM's meshes, mm")
    parser.add_argument(
        "--rings", nargs="+", type=int, default=(ADAPTIVE, *RINGS), help=f"of our only mesh; {ADAPTIVE}: default"
    )
    options = parser.parse_args()
    missing = openfoam_case.missing_programs()
    if missing:
        raise InputError("OpenFOAM is not installed", "PATH", ", ".join(missing), "apt-get install openfoam")
    options.out.mkdir(parents=True, exist_ok=True)
    truth, rows = reference(), []
    print(f"reference: FFR {truth:.5f}", file=sys.stderr)
    jobs = [(openfoam, edge, f"openfoam_{edge}") for edge in options.edges]
    jobs += [(ours, rings, f"vci_{rings}") for rings in options.rings]
    for job, setting, name in jobs:
        rows.append(job(setting, options.out / name))
        if "ffr" in rows[-1]:
            rows[-1]["error"] = rows[-1]["ffr"] - truth
        print(rows[-1], file=sys.stderr)
    for resolution, (ratio, reached) in factor(rows).items():
        least = "" if reached else " (more: OpenFOAM's finest is not as near)"
        print(f"vci, {resolution}: OpenFOAM takes {ratio:.1f} times as long for this error{least}", file=sys.stderr)
    with (options.out / "benchmark.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, options.out / "benchmark.png")


if __name__ == "__main__":
    main()
