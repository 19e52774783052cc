"""Hard cases of the flow solver as a table: python3 tests/verification/flow/hard_cases.py --out DIR all | CASE ...

With --state results/cases/<case>/<state> a state of a study's case is solved too, for example a deployed lumen.

Writes DIR/hard_cases.csv: case, outcome (converged, converged with artificial viscosity, refused), FFR, its reference
and error, the error estimate, FFR of the reduced models, residual in N, artificial viscosity left, dofs of the mesh
that gave the answer, factorizations on all meshes, CPU seconds of the solve, peak memory. Only straight tubes have a
reference. It is from axisymmetric.py, which shares no code with the solver. A case is meshed and solved by
`python3 -m flow` with default settings. Rows of earlier runs stay unless they are run again.
"""

import argparse
import csv
import dataclasses
import json
import pathlib
import shutil
import subprocess
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [
    str(ROOT),
    str(ROOT / "tests" / "unit" / "flow"),
    str(ROOT / "tests" / "support"),
    str(pathlib.Path(__file__).parent),
]

import axisymmetric  # noqa: E402
import tubes  # noqa: E402

from common.errors import error_summary  # noqa: E402
from places import lone_environment  # noqa: E402

PA_PER_MMHG = 133.322
MAP, VENOUS, FLOW = 93 * PA_PER_MMHG, 5 * PA_PER_MMHG, 200e-6 / 60  # Pa, Pa, m3/s at hyperaemia
RADIUS, EDGE = 1.6, 0.4  # mm
REFERENCE_CELLS = (120, 12)  # along and across. FFR of the single lesions is within 2e-5 of the published values.
COLUMNS = ("case", "outcome", "ffr", "reference", "error", "estimate", "ffr_axisymmetric", "ffr_1d", "residual_n")
COLUMNS += ("artificial", "dofs", "factorizations", "cpu_s", "mib")


@dataclasses.dataclass
class Tube:
    """A straight tube. radius: function of s, both in mm; length, throat and probe in mm; share: flow over FLOW.

    throat: where the mesh of the reference is finest. reference_length: length of the tube in the reference. It is
    longer than `length` if the vessel is cut off at the outlet.
    """

    radius: object
    length: float
    throat: float
    probe: float
    share: float = 1.0
    reference_length: float = 0.0

    def case(self):
        """(Surface, branches, parents, document)."""
        branches = [tubes.centre_branch(self.length, self.radius)]
        surface = tubes.tube(self.length, self.radius, EDGE)
        return surface, branches, None, document(branches, [self.share], self.probe)

    def reference(self, flow):
        """FFR of the axisymmetric solution; flow: a guess of the inflow in m3/s."""
        _, _, _, boundary = self.case()
        length = max(self.length, self.reference_length)
        tube = axisymmetric.Tube(self.radius, length, self.throat, boundary, REFERENCE_CELLS)
        return tube.ffr(flow, self.probe)


def document(branches, shares, probe_mm):
    """Content of boundary.json: at hyperaemia outlet i draws shares[i] of FLOW. FFR is read at probe_mm of `main`."""
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


def single_lesion(reduction, outlet_mm=50.0):
    """Cosine lesion at 15-25 mm of a vessel that is 50 mm long, cut off at outlet_mm."""
    radius = tubes.lesion(RADIUS, reduction, 20, 10)
    return Tube(radius, outlet_mm, 20.0, min(45.0, outlet_mm - 2.0), reference_length=50.0)


def tandem_lesions():
    """Two lesions of 60 %, 5 mm between them."""
    first, second = tubes.lesion(RADIUS, 0.6, 15, 10), tubes.lesion(RADIUS, 0.6, 30, 10)
    return Tube(lambda s: np.minimum(first(s), second(s)), 60.0, 22.5, 55.0)


def throat_re_1500():
    """Lesion of 50 % at 808 mL/min of hyperaemic flow: a Reynolds number of about 1,500 at the throat."""
    return Tube(tubes.lesion(RADIUS, 0.5, 20, 10), 60.0, 20.0, 55.0, 4.04)


STRAIGHT = {
    **{f"single_{percent}": single_lesion(percent / 100) for percent in (62, 75, 80, 85, 90)},
    "tandem_60": tandem_lesions(),
    "outlet_2d_behind_62": single_lesion(0.62, 25 + 4 * RADIUS),
    "throat_re_1500": throat_re_1500(),
}


def _bent(radius, length, probe_mm, axis):
    branches = [tubes.centre_branch(length, radius, axis)]
    return tubes.tube(length, radius, EDGE, axis), branches, None, document(branches, [1.0], probe_mm)


def eccentric():
    """Lesion of 62 % off the vessel's axis, by nine tenths of the local loss of radius."""
    radius = tubes.lesion(RADIUS, 0.62, 20, 10)
    return _bent(radius, 50.0, 45.0, lambda s, a, b: np.stack([s, a + 0.9 * (RADIUS - radius(s)), b], axis=-1))


def sharp_bend():
    """Lesion of 50 %, 10 mm long, that ends where the vessel turns by 90 degrees at a bend radius of 1.6 diameters."""
    start, bend = 20.0, 5.0

    def axis(s, a, b):
        angle = np.clip((s - start) / bend, 0, np.pi / 2)
        after = np.clip(s - start - bend * np.pi / 2, 0, None)
        x = np.minimum(s, start) + (bend - a) * np.sin(angle)
        y = bend - (bend - a) * np.cos(angle) + after
        return np.stack([x, y, b], axis=-1)

    return _bent(tubes.lesion(RADIUS, 0.5, 15, 10), 45.0, 40.0, axis)


def fork(shares, **sizes):
    """A straight vessel with one side branch; shares: outlets' shares of the flow, main first."""
    sizes = {"length": 24.0, "at": 10.0, "side_length": 10.0, **sizes}
    surface, branches = tubes.fork(**sizes)
    return surface, branches, {"side1": ("main", sizes["at"])}, document(branches, shares, sizes["length"] - 4.0)


# side branches: place on the main branch, radius and length in mm, angle to the main branch and turn about its axis in
# degrees
SIDE_BRANCHES = ((12.0, 0.8, 10.0, 60.0, 0.0), (42.0, 1.2, 12.0, 55.0, 160.0), (50.0, 0.9, 10.0, 50.0, 70.0))
SIDE_BRANCHES += ((58.0, 1.0, 10.0, 60.0, 250.0),)
SPLIT_EXPONENT = 2.55  # an outlet's flow is proportional to its diameter to this power


def five_outlets():
    """A vessel 70 mm long and 4 mm wide with SIDE_BRANCHES and a lesion of 55 %.

    The lesion is 10 mm long and lies between the first two side branches. FFR is read 10 mm behind it. To make it, the
    wall's points of the straight vessel are moved towards the axis.
    """
    length, radius, first, last = 70.0, 2.0, 17.0, 27.0
    surface, branches = tubes.branched(radius, length, SIDE_BRANCHES, EDGE)
    narrowed = tubes.lesion(radius, 0.55, 0.5 * (first + last), last - first)
    points = surface.points.copy()
    within = (points[:, 0] > first) & (points[:, 0] < last) & (np.hypot(*points[:, 1:].T) < 1.001 * radius)
    points[within, 1:] *= (narrowed(points[within, 0]) / radius)[:, None]
    branches[0] = tubes.centre_branch(length, narrowed)
    wide = np.array([branch.radius_mm[-1] for branch in branches]) ** SPLIT_EXPONENT
    parents = {branch.name: ("main", side[0]) for branch, side in zip(branches[1:], SIDE_BRANCHES)}
    return (
        dataclasses.replace(surface, points=points),
        branches,
        parents,
        document(branches, wide / wide.sum(), last + 10.0),
    )


CASES = {  # the cases that take longest come last
    **{name: tube.case for name, tube in STRAIGHT.items() if name != "throat_re_1500"},
    "outlets_0.7_and_4_mm": lambda: fork([1 - 0.0116, 0.0116], radius=2.0, side_radius=0.35, edge_mm=0.3),
    "resistances_1_to_100": lambda: fork([100 / 101, 1 / 101]),
    "sharp_bend_50": sharp_bend,
    "throat_re_1500": STRAIGHT["throat_re_1500"].case,
    "five_outlets_55": five_outlets,
    "eccentric_62": eccentric,
}
ALL_CASES = "all"
COARSE_MESHES = ("mesh_coarsest.msh", "mesh_coarse.msh")  # files for the coarse meshes of the default
STATE_FILES = ("lumen.vtp", "centreline.vtp", "sections.csv", "anatomy.json")


def write(name, folder):
    """Writes the lumen of a case and its boundary values to `folder`."""
    surface, branches, parents, boundary = CASES[name]()
    tubes.write_case(folder, surface, branches, parents)
    (folder / "boundary.json").write_text(json.dumps(boundary))


def copy_state(state, folder):
    """Copies the files of a state of a study's case. The anatomy of the state `pre` is that of the case itself."""
    folder.mkdir(parents=True, exist_ok=True)
    anatomy = state.parent / "anatomy" if state.name == "pre" else state / "anatomy"
    for file in [anatomy / name for name in STATE_FILES] + [state.parent / "flow" / "boundary.json"]:
        shutil.copy(file, folder / file.name)


def run(name, folder):
    """Row of the table for the case whose lumen is in `folder`, meshed and solved there."""
    line, meshes = ["--centreline", "centreline.vtp"], ["mesh.msh", "--coarse", *COARSE_MESHES]
    (folder / "ffr.json").unlink(missing_ok=True)
    for command in (["mesh", "lumen.vtp", *line, "--out", *meshes], ["solve", *meshes, *line, "--out", "."]):
        if command[0] == "solve":
            command += ["--boundary", "boundary.json"]
        with open(folder / f"{command[0]}.log", "w") as log:
            line_run = [sys.executable, "-m", "flow", *command]
            done = subprocess.run(line_run, cwd=folder, stderr=log, stdout=log, env=lone_environment())
        if done.returncode != 0:
            reason = error_summary((folder / f"{command[0]}.log").read_text())
            return {"case": name, "outcome": f"{command[0]} refused, exit {done.returncode}: {reason}"}
    answer = json.loads((folder / "ffr.json").read_text())
    return {"case": name, "outcome": answer["status"], **answer_columns(answer), **reference_columns(name, answer)}


def answer_columns(answer):
    """Columns of the table that a document of ffr.json fills."""
    axisymmetric_ffr, estimate = answer["models"]["axisymmetric"]["ffr"], answer["error_estimate"]
    return {
        "ffr": f"{answer['ffr']:.4f}",
        "estimate": f"{estimate['ffr']:.4f}" if estimate else "unknown",
        "ffr_axisymmetric": "none" if axisymmetric_ffr is None else f"{axisymmetric_ffr:.4f}",
        "ffr_1d": f"{answer['models']['network']['ffr']:.4f}",
        "residual_n": f"{answer['residual_absolute']:.0e}",
        "artificial": f"{answer['artificial_viscosity']:.2g}",
        "dofs": answer["dofs"],
        "factorizations": sum(mesh.get("factorizations", 0) for mesh in answer["meshes"]),
        "cpu_s": f"{answer['cpu_seconds']:.0f}",
        "mib": f"{answer['peak_memory_mib']:.0f}",
    }


def reference_columns(name, answer):
    """Columns `reference` and `error` of a straight tube."""
    if name not in STRAIGHT:
        return {}
    reference = STRAIGHT[name].reference(answer["inlet_flow_m3_per_s"])
    return {"reference": f"{reference:.4f}", "error": f"{answer['ffr'] - reference:+.4f}"}


def main():
    """Runs the named cases, or all, and updates the table after each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(CASES)}; {ALL_CASES}: each of them")
    parser.add_argument("--state", action="append", default=[], type=pathlib.Path, help="results/cases/<case>/<state>")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder of the table and the cases' files")
    arguments = parser.parse_args()
    chosen = list(CASES) if ALL_CASES in arguments.cases else arguments.cases
    unknown = sorted(set(chosen) - set(CASES))
    if unknown:
        parser.error(f"no such case: {', '.join(unknown)}")
    arguments.out.mkdir(parents=True, exist_ok=True)
    table = arguments.out / "hard_cases.csv"
    rows = {}
    if table.is_file():
        with open(table, newline="") as file:
            rows = {row["case"]: row for row in csv.DictReader(file)}
    states = {f"{state.parent.name}_{state.name}": state for state in arguments.state}
    for name in [*states, *chosen]:
        folder = arguments.out / name
        copy_state(states[name], folder) if name in states else write(name, folder)
        rows[name] = run(name, folder)
        print(rows[name], flush=True)
        with open(table, "w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows[name] for name in [*CASES, *sorted(set(rows) - set(CASES))] if name in rows)


if __name__ == "__main__":
    main()
