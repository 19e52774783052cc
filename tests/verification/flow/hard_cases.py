"""Hard cases of the flow solver as a table: python3 tests/verification/flow/hard_cases.py --out DIR [CASE ...].

A state of a study's case, as a deployed lumen, is one more: --state results/cases/<case>/<state>.

Writes DIR/hard_cases.csv: case, outcome (converged, converged with eddy viscosity, unsteady, refused), FFR, error
estimate, FFR of the axisymmetric model and of the 1D network, residual in N, eddy viscosity left, dofs of the mesh
that answered, factorizations on all meshes, CPU seconds, peak memory. A case is meshed and solved by `python3 -m flow`
with default settings; rows of cases that are not run again stay.
"""

import argparse
import csv
import json
import pathlib
import shutil
import subprocess
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "unit" / "flow")]

import tubes  # noqa: E402

PA_PER_MMHG = 133.322
MAP, VENOUS, FLOW = 93 * PA_PER_MMHG, 5 * PA_PER_MMHG, 200e-6 / 60  # Pa, Pa, m3/s at hyperaemia
RADIUS, EDGE = 1.6, 0.4  # mm
COLUMNS = ("case", "outcome", "ffr", "estimate", "ffr_axisymmetric", "ffr_1d", "residual_n", "eddy", "dofs")
COLUMNS += ("factorizations", "cpu_s", "mib")


def document(branches, shares, probe_mm):
    """boundary.json: outlet i at hyperaemia draws shares[i] of FLOW; FFR on the main branch at probe_mm."""
    outlets = [
        {
            "name": f"outlet{k + 1}",
            "region_id": k + 2,
            "branch": branch.name,
            "flow_m3_per_s": share * FLOW,
            "resistance_pa_s_per_m3": (MAP - VENOUS) / (share * FLOW),
        }
        for k, (branch, share) in enumerate(zip(branches, shares))
    ]
    probe = {"name": "distal", "branch": "main", "s_mm": probe_mm, "point_mm": branches[0].point(probe_mm).tolist()}
    return {
        "map_pa": MAP,
        "venous_pressure_pa": VENOUS,
        "density_kg_per_m3": 1060.0,
        "viscosity_pa_s": 0.004,
        "outlets": outlets,
        "probes": [probe],
    }


def _tube(radius, length, probe_mm, axis=None, edge=EDGE):
    surface, branches = tubes.tube(length, radius, edge, axis), [tubes.line(length, radius, axis)]
    return surface, branches, None, document(branches, [1.0], probe_mm)


def single(reduction, outlet_mm=50.0):
    """Cosine lesion 15-25 mm, the outlet at outlet_mm."""
    return _tube(tubes.lesion(RADIUS, reduction, 20, 10), outlet_mm, min(45.0, outlet_mm - 2.0))


def tandem():
    """Two lesions of 60 %, 5 mm between them."""
    first, second = tubes.lesion(RADIUS, 0.6, 15, 10), tubes.lesion(RADIUS, 0.6, 30, 10)
    return _tube(lambda s: np.minimum(first(s), second(s)), 60.0, 55.0)


def eccentric():
    """Lesion of 62 % whose axis is off the vessel's by nine tenths of what it takes from the radius."""
    radius = tubes.lesion(RADIUS, 0.62, 20, 10)
    return _tube(radius, 50.0, 45.0, lambda s, a, b: np.stack([s, a + 0.9 * (RADIUS - radius(s)), b], axis=-1))


def throat_re_1500():
    """Lesion of 50 % at 808 mL/min of hyperaemic flow: a Reynolds number of about 1,500 at the throat."""
    radius = tubes.lesion(RADIUS, 0.5, 20, 10)
    branches = [tubes.line(60.0, radius)]
    return tubes.tube(60.0, radius, EDGE), branches, None, document(branches, [4.04], 55.0)


def sharp_bend():
    """Lesion of 50 %, 10 mm long, that ends where the vessel turns by 90 degrees at a bend radius of 1.6 diameters."""
    start, bend = 20.0, 5.0

    def axis(s, a, b):
        angle = np.clip((s - start) / bend, 0, np.pi / 2)
        after = np.clip(s - start - bend * np.pi / 2, 0, None)
        x = np.minimum(s, start) + (bend - a) * np.sin(angle)
        y = bend - (bend - a) * np.cos(angle) + after
        return np.stack([x, y, b], axis=-1)

    return _tube(tubes.lesion(RADIUS, 0.5, 15, 10), 45.0, 40.0, axis)


def fork(shares, **sizes):
    """A straight vessel with one side branch; shares: of the flow, main first."""
    sizes = {"length": 24.0, "at": 10.0, "side_length": 10.0, **sizes}
    surface, branches = tubes.fork(**sizes)
    return surface, branches, {"side1": ("main", sizes["at"])}, document(branches, shares, sizes["length"] - 4.0)


CASES = {
    **{f"single_{percent}": lambda percent=percent: single(percent / 100) for percent in (62, 75, 80, 85, 90)},
    "tandem_60": tandem,
    "eccentric_62": eccentric,
    "outlet_2d_behind_62": lambda: single(0.62, 25 + 4 * RADIUS),
    "outlets_0.7_and_4_mm": lambda: fork([1 - 0.0116, 0.0116], radius=2.0, side_radius=0.35, edge_mm=0.3),
    "resistances_1_to_100": lambda: fork([100 / 101, 1 / 101]),
    "sharp_bend_50": sharp_bend,
    "throat_re_1500": throat_re_1500,
}
STATE_FILES = ("lumen.vtp", "centreline.vtp", "sections.csv", "anatomy.json")


def write(name, folder):
    """Writes the lumen of a case and its boundary values to `folder`."""
    surface, branches, parents, boundary = CASES[name]()
    tubes.write_case(folder, surface, branches, parents)
    (folder / "boundary.json").write_text(json.dumps(boundary))


def copy(state, folder):
    """Copies the lumen of a state of a study's case (`pre`, the folder beside it, has the case's own anatomy)."""
    folder.mkdir(parents=True, exist_ok=True)
    anatomy = state.parent / "anatomy" if state.name == "pre" else state / "anatomy"
    for file in [anatomy / name for name in STATE_FILES] + [state.parent / "flow" / "boundary.json"]:
        shutil.copy(file, folder / file.name)


def outcome(answer):
    """What became of a case, in words: answer is the document of ffr.json."""
    if answer["unsteady"]:
        begin, end = answer["unsteady"]["window_s"]
        return f"unsteady: mean over {end - begin:.2f} s, amplitude {answer['unsteady']['ffr_amplitude']:.4f}"
    return "converged with eddy viscosity" if answer["jet_mixing"] else "converged"


def run(name, folder):
    """Row of the table for the case whose lumen is in `folder`, meshed and solved there."""
    line, meshes = ["--centreline", "centreline.vtp"], ["mesh.msh", "--coarse", "mesh_coarse.msh"]
    (folder / "ffr.json").unlink(missing_ok=True)
    for command in (["mesh", "lumen.vtp", *line, "--out", *meshes], ["solve", *meshes, *line, "--out", "."]):
        if command[0] == "solve":
            command += ["--boundary", "boundary.json"]
        with open(folder / f"{command[0]}.log", "w") as log:
            environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "OMP_NUM_THREADS": "1"}
            done = subprocess.run(
                [sys.executable, "-m", "flow", *command], cwd=folder, stderr=log, stdout=log, env=environment
            )
        if done.returncode != 0:
            reason = (folder / f"{command[0]}.log").read_text().strip().splitlines()[-1]
            return {"case": name, "outcome": f"{command[0]} refused, exit {done.returncode}: {reason}"}
    answer = json.loads((folder / "ffr.json").read_text())
    eddy, axisymmetric = answer["jet_mixing"], answer["models"]["axisymmetric"]["ffr"]
    return {
        "case": name,
        "outcome": outcome(answer),
        "ffr": f"{answer['ffr']:.4f}",
        "estimate": f"{answer['error_estimate']['ffr']:.4f}" if answer["error_estimate"] else "unknown",
        "ffr_axisymmetric": "none" if axisymmetric is None else f"{axisymmetric:.4f}",
        "ffr_1d": f"{answer['models']['network']['ffr']:.4f}",
        "residual_n": f"{answer['residual_absolute']:.0e}",
        "eddy": f"{eddy:g}",
        "dofs": answer["dofs"],
        "factorizations": sum(mesh.get("factorizations", 0) for mesh in answer["meshes"]),
        "cpu_s": f"{answer['cpu_seconds']:.0f}",
        "mib": f"{answer['peak_memory_mib']:.0f}",
    }


def main():
    """Runs the named cases, or all, and updates the table after each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(CASES)} (default: all)")
    parser.add_argument("--state", action="append", default=[], type=pathlib.Path, help="results/cases/<case>/<state>")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder of the table and the cases' files")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.cases) - set(CASES))
    if unknown:
        parser.error(f"no such case: {', '.join(unknown)}")
    arguments.out.mkdir(parents=True, exist_ok=True)
    table = arguments.out / "hard_cases.csv"
    rows = {}
    if table.is_file():
        with open(table, newline="") as file:
            rows = {row["case"]: row for row in csv.DictReader(file)}
    states = {f"{state.parent.name}_{state.name}": state for state in arguments.state}
    for name in [*(arguments.cases or ([] if states else CASES)), *states]:
        folder = arguments.out / name
        copy(states[name], folder) if name in states else write(name, folder)
        rows[name] = run(name, folder)
        print(rows[name], flush=True)
        with open(table, "w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows[name] for name in [*CASES, *sorted(set(rows) - set(CASES))] if name in rows)


if __name__ == "__main__":
    main()
