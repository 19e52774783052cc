"""Estimates of answers beside the next finer mesh: python3 tests/verification/flow/finer_mesh.py --out DIR STATE ...

STATE is results/cases/<case>/flow/<state>, with the meshes and the answer of `flow solve`. The search for it goes
on with a tolerance of 0, to the mesh after the one that answered. After the finest mesh of the study this is one with a
ring more. If no flow is found there, the search starts anew, from rest on the coarsest mesh. Writes
DIR/finer_mesh.csv, a row for each state: FFR and estimate of the answer, FFR on the finer mesh, and the difference.
Rows of earlier runs stay unless they are run again.
"""

import argparse
import csv
import json
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).resolve().parents[3])]

import growth  # noqa: E402

from common.errors import guarded  # noqa: E402

MESHES = ("mesh_coarsest.msh", "mesh_coarse.msh", "mesh.msh")  # of the study, the coarsest first
COLUMNS = ("state", "rings", "eps", "ffr", "estimate", "finer_rings", "finer_eps", "finer_ffr", "difference", "cpu_s")


def read(path):
    """Content of a JSON file."""
    return json.loads(path.read_text())


def anatomy_of(state):
    """Folder of the anatomy of a state's lumen. state: folder of its flow."""
    case = state.parents[1]
    return case / "anatomy" if state.name == "pre" else case / state.name / "anatomy"


def meshes_of(state):
    """Names of the meshes that `flow mesh` made of a state, the coarsest first; it may leave out coarser ones."""
    return [mesh for mesh in MESHES if (state / mesh).stat().st_size]


def finer_row(state, out):
    """Row of the table. state: folder of the solved state; out: folder for the finer mesh and its flow."""
    case, answer, report = state.parents[1], read(state / "ffr.json"), read(state / "mesh.json")
    anatomy = anatomy_of(state)
    line, settings = anatomy / "centreline.vtp", ["--settings", case / "settings" / "flow.json"]
    made = meshes_of(state)
    rings = {mesh: part["rings"] for mesh, part in zip(made, [*report.get("coarse", []), report])}
    number = made.index(answer["mesh"])
    passed = [state / mesh for mesh in made[: number + 1]]
    name = f"{case.name}_{state.name}"
    folder = out / name
    folder.mkdir(parents=True, exist_ok=True)
    parts = [*report.get("coarse", []), report]
    if number + 1 < len(made):
        finer, finer_rings, finer_report = state / made[number + 1], rings[made[number + 1]], folder / "finer.json"
        # `flow solve` takes the report whose cells are those of its meshes
        finer_report.write_text(json.dumps({**report, **parts[number + 1], "coarse": parts[: number + 1]}))
    else:
        finer, finer_rings, finer_report = folder / "finer.msh", rings[made[-1]] + 1, folder / "finer.json"
        sizes, ratio = ["--rings", finer_rings], finer_rings / rings[made[-1]]
        sizes += ["--cells-per-radius", ratio * report["settings"]["cells_per_radius"]]
        for kind in ("throat", "plain"):
            sizes += [f"--stations-{kind}", report["settings"][f"stations_{kind}"] / ratio]
        written = ["--out", finer, "--json", finer_report]
        growth.command(folder, "mesh", anatomy / "lumen.vtp", "--centreline", line, *settings, *sizes, *written)
        finer_report.write_text(json.dumps({**read(finer_report), "coarse": parts}))
    inputs = ["--boundary", state.parent / "boundary.json", "--centreline", line, "--mesh-report", finer_report]
    for start in (["--start", state, line], []):
        chosen = [*settings, "--ffr-tolerance", 0, *start]
        growth.command(folder, "solve", finer, "--coarse", *passed, *inputs, *chosen, "--out", ".")
        found = read(folder / "ffr.json")
        last = found["meshes"][-1]
        if last["mesh"] == finer.name and last["status"] != "no flow" or answer["artificial_viscosity"] > 0:
            break  # a flow with artificial viscosity is no start, so this search was from rest
    row = {
        "state": name.replace("_", " "),
        "rings": rings[answer["mesh"]],
        "eps": f"{answer['artificial_viscosity']:.2g}",
        "ffr": f"{answer['ffr']:.5f}",
        "estimate": f"{answer['error_estimate']['ffr']:.5f}" if answer["error_estimate"] else "unknown",
        "finer_rings": finer_rings,
        "cpu_s": f"{found['cpu_seconds']:.0f}",
    }
    if last["mesh"] != finer.name or last["status"] == "no flow":
        return row | {"finer_ffr": "no flow"}
    row |= {"finer_ffr": f"{last['ffr']:.5f}", "difference": f"{last['ffr'] - answer['ffr']:+.5f}"}
    return row | ({"finer_eps": f"{found['artificial_viscosity']:.2g}"} if found["mesh"] == finer.name else {})


@guarded
def run_states(description, file, columns, row_of):
    """Command line of a benchmark with a row for each state: updates the table after each, and keeps other rows.

    file: name of the table; row_of(state, out) -> row (dict) of a state's folder, `state` its name.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("states", nargs="+", type=pathlib.Path, metavar="STATE")
    parser.add_argument("--out", required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    table, rows = arguments.out / file, {}
    if table.is_file():
        with table.open(newline="") as stored:
            rows = {row["state"]: row for row in csv.DictReader(stored)}
    for state in arguments.states:
        row = row_of(state.resolve(), arguments.out.resolve())
        print(row, flush=True)
        rows[row["state"]] = row
        growth.write(table, columns, [rows[key] for key in sorted(rows)])


if __name__ == "__main__":
    run_states(__doc__.splitlines()[0], "finer_mesh.csv", COLUMNS, finer_row)
