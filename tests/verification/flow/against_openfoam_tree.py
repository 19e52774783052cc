"""FFR of states of a tree beside OpenFOAM: python3 tests/verification/flow/against_openfoam_tree.py --out DIR STATE ...

STATE is results/cases/<case>/flow/<state>, with the meshes and the answer of `flow solve`. simpleFoam gets the flows
of that answer. Its FFR is 1 minus its pressure drop from the inlet to the probe `distal`, divided by the mean arterial
pressure. So both programs give FFR at the same flows and at the same point. Writes DIR/tree.csv, a row for each state
and mesh. The change from the coarser to the finer mesh shows simpleFoam's own error. Rows of earlier runs stay unless
they are run again.
"""

import argparse
import csv
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(pathlib.Path(__file__).parent)]

import openfoam_run  # noqa: E402
import openfoam_tree  # noqa: E402

from common.errors import InputError, guarded  # noqa: E402
from flow.geometry.surface import INLET  # noqa: E402

MESHES = ("mesh_coarse.msh", "mesh.msh")
COLUMNS = ("state", "mesh", "cells", "volume_percent", "iterations", "fall_pa", "our_fall_pa", "ffr")
COLUMNS += ("our_ffr", "our_estimate", "difference", "scatter", "mesh_cpu_s", "cpu_s", "our_cpu_s")


class State:
    """A solved state of a case: its folder, its boundary.json and ffr.json, and the volume of its meshed lumen."""

    def __init__(self, folder):
        self.folder, self.name = folder, f"{folder.parents[1].name} {folder.name}"
        self.boundary, self.answer, report = (
            json.loads(path.read_text())
            for path in (folder.parent / "boundary.json", folder / "ffr.json", folder / "mesh.json")
        )
        self.volume_mm3 = report["volume_mm3"]

    def flows(self):
        """{region_id: flow in m3/s}: inflow at the inlet, outflow at the outlets, None at the main branch's outlet."""
        found = {one["name"]: one["flow_m3_per_s"] for one in self.answer["outlets"]}
        outlets = {
            one["region_id"]: None if one["branch"] == "main" else found[one["name"]]
            for one in self.boundary["outlets"]
        }
        return {INLET: self.answer["inlet_flow_m3_per_s"], **outlets}


def row(state, mesh, folder):
    """Row of the table for a State; simpleFoam gets one polyhedron for each node of the mesh file `mesh`."""
    document, answer, probe = state.boundary, state.answer, state.answer["probes"][0]
    if document["viscosity"] is not None:
        raise InputError("only Newtonian blood is compared", state.name, document["viscosity"], "leave viscosity_model")
    made = openfoam_tree.mesh(folder, state.folder / mesh)
    values = document["density_kg_per_m3"], document["viscosity_pa_s"]
    found = openfoam_tree.solve(folder, state.flows(), probe["point_mm"], *values)
    map_pa = document["map_pa"]
    ffr = 1 - found["fall_pa"] / map_pa
    return {
        "state": state.name,
        "mesh": mesh,
        "cells": made["cells"],
        "volume_percent": f"{100 * (made['volume_mm3'] / state.volume_mm3 - 1):.2f}",
        "iterations": found["iterations"],
        "fall_pa": f"{found['fall_pa']:.0f}",
        "our_fall_pa": f"{(1 - answer['ffr']) * map_pa:.0f}",
        "ffr": f"{ffr:.4f}",
        "our_ffr": f"{answer['ffr']:.4f}",
        "our_estimate": f"{answer['error_estimate']['ffr']:.4f}",
        "difference": f"{ffr - answer['ffr']:+.4f}",
        "scatter": f"{found['scatter_pa'] / map_pa:.5f}",
        "mesh_cpu_s": f"{made['mesh_cpu_s']:.0f}",
        "cpu_s": f"{found['solve_cpu_s']:.0f}",
        "our_cpu_s": f"{answer['cpu_seconds']:.0f}",
    }


def key(entry):
    return entry["state"], entry["mesh"]


@guarded
def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("states", nargs="+", type=pathlib.Path, metavar="STATE")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder of the table and the runs")
    parser.add_argument("--meshes", nargs="*", default=MESHES, help="of each state, whose nodes get a cell each")
    options = parser.parse_args()
    missing = openfoam_run.missing_programs()
    if missing:
        raise InputError("OpenFOAM is not installed", "PATH", ", ".join(missing), "apt-get install openfoam")
    options.out.mkdir(parents=True, exist_ok=True)
    states, table, rows = [State(folder.resolve()) for folder in options.states], options.out / "tree.csv", {}
    if table.is_file():
        with table.open(newline="") as file:
            rows = {key(old): old for old in csv.DictReader(file)}
    for mesh in options.meshes:
        for state in states:
            new = row(state, mesh, options.out / f"{state.name.replace(' ', '_')}_{pathlib.Path(mesh).stem}")
            print(new, file=sys.stderr, flush=True)
            rows[key(new)] = new
            with table.open("w", newline="") as file:
                writer = csv.DictWriter(file, COLUMNS)
                writer.writeheader()
                writer.writerows(sorted(rows.values(), key=lambda entry: (entry["state"], int(entry["cells"]))))


if __name__ == "__main__":
    main()
