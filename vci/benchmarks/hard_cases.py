"""Generates hard cases of the deployment and runs them one after another. hard_cases.csv has a row for each case.

/usr/bin/python3 -m vci.benchmarks.hard_cases --out results/hard_cases [--only NAME ...] [--scenes SCENE.json ...]
    [--first-steps 0.27 0.34]

Each case ends in force balance, or is refused with a reason. The column `within_limits` tells whether the mean
penetration is at most MEAN_LIMIT_MM and the worst at most WORST_LIMIT_MM. Runs follow one another on one thread.
`cpu_seconds` are those of the whole program.

With --first-steps each case also runs with these lengths of the first solver step. Runs that differ only in it should
end in the same lumen. first_steps.csv has a row for each case: how many were refused, and how far the others differ.
"""

import argparse
import contextlib
import csv
import json
import pathlib
import resource
import sys

from common.errors import ComputationError, InputError, error_summary, guarded
from common.files import write_json
from vci.benchmarks.programs import culotte_scene, run_program
from vci.benchmarks.scenes import Tube, write_scene

COLUMNS = "case,outcome,reason,residual,mean_penetration_mm,worst_penetration_mm,within_limits"
COLUMNS += ",steps,cpu_seconds,minimal_area_mm2"
FIRST_STEP_COLUMNS = "case,runs,refused,folded,fewest_steps,most_steps,worst_penetration_mm"
FIRST_STEP_COLUMNS += ",mean_area_spread_percent,minimal_area_spread_percent"


def calcium_wall(stiffness_ratio):
    """Wall settings with calcium that never yields, `stiffness_ratio` times as stiff as the healthy wall (0.8 MPa)."""
    return {"plaque": {"calcified": {"youngs_modulus_mpa": 0.8 * stiffness_ratio, "yield_strain": None}}}


MEAN_LIMIT_MM = 0.05 * 0.0125  # largest mean penetration of a good run: a twentieth of contact_distance_mm
WORST_LIMIT_MM = 0.05  # largest penetration of any vertex in a good run
MAXIMAL_STEPS = 500  # limit of steps in a stage; cases that balance need about a third of it
NO_BALANCE = 3  # exit code of vci deploy if a stage does not reach force balance
OWN_FIRST_STEP = "first step x1000"  # the case that is about the first step
ECCENTRIC = {"eccentricity": 0.8, "calcium_deg": 90}
CASES = {
    "ordinary": (Tube(), {}),
    "stenosis 90 %": (Tube(stenosis=0.9), {}),
    "calcium x1000, eccentric, 0.5 mm": (Tube(**ECCENTRIC), {"wall": calcium_wall(1000)}),
    "calcium x1000, eccentric, 0.25 mm": (Tube(edge=0.25, **ECCENTRIC), {"wall": calcium_wall(1000)}),
    "calcium x1000, concentric, 0.5 mm": (Tube(calcium_deg=360), {"wall": calcium_wall(1000)}),
    "calcium x1000, concentric, 0.25 mm": (Tube(edge=0.25, calcium_deg=360), {"wall": calcium_wall(1000)}),
    "90 %, eccentric, calcium x1000": (Tube(stenosis=0.9, **ECCENTRIC), {"wall": calcium_wall(1000)}),
    "90 %, eccentric, calcium x1000, 0.4 mm": (Tube(stenosis=0.9, edge=0.4, **ECCENTRIC), {"wall": calcium_wall(1000)}),
    "80 %, eccentric, calcium x30": (Tube(stenosis=0.8, **ECCENTRIC), {"wall": calcium_wall(30)}),
    "oversizing 1.4": (Tube(), {"size": 1.4}),
    "curvature 0.3 /mm": (Tube(curvature=0.3), {}),
    "mesh jittered by 25 %": (Tube(jitter=0.25), {}),
    "slivers": (Tube(sliver=0.75), {}),
    "jittered by 25 %, with slivers": (Tube(jitter=0.25, sliver=0.5), {}),  # with sliver=0.6 triangles fold over
    OWN_FIRST_STEP: (Tube(), {"numerics": {"initial_step_ms": 300, "maximal_step_ms": 300}}),
    "25 bar": (Tube(), {"pressures": (10, 11, 25)}),
    "overlapping stents": (Tube(length=36), {"shifts": (-4.5, 4.5)}),
    "folded balloons": (
        Tube(stenosis=0.6, eccentricity=0.8),
        {"folding": {}, "numerics": {"maximal_steps_per_stage": 1500}},
    ),
    "kissing balloons": (Tube(), {"kissing": 0.6, "pressures": (10, 11, 12)}),
}
# How many steps of the shipped bifurcation's procedure are run; None: all. The first two steps place a stent across the
# side branch and dilate it in the main branch (proximal optimisation). Further steps place a second stent through the
# first one's side, and inflate kissing balloons.
BIFURCATION_STEPS = {"stent across a side branch": 2, "culotte": None}
BIFURCATION_EDGE_MM = 0.4  # edge length of the bifurcation's lumen
CASE_NAMES = (*CASES, *BIFURCATION_STEPS)


def result_row(case, program, scene):
    """Runs a scene and returns its row of hard_cases.csv."""
    code, messages, cpu = run_program([program, "deploy", scene, "--out", scene.parent / "out"])
    row = {"case": case, "cpu_seconds": round(cpu, 2)}
    if code:
        outcome = {2: "input refused", NO_BALANCE: "refused"}.get(code, f"failed with exit code {code}")
        return row | {"outcome": outcome, "reason": error_summary(messages)}
    result = json.loads((scene.parent / "out" / "deployment.json").read_text())
    stages = result["stages"]
    mean, worst = (max(s[key] for s in stages) for key in ("mean_penetration_mm", "max_penetration_mm"))
    exceeded = [name for name, limit in (("mean", mean > MEAN_LIMIT_MM), ("worst", worst > WORST_LIMIT_MM)) if limit]
    return row | {
        "outcome": "balanced",
        "residual": max(s["residual"] for s in stages),
        "mean_penetration_mm": mean,
        "worst_penetration_mm": worst,
        "within_limits": "no: " + ", ".join(exceeded) if exceeded else "yes",
        "steps": sum(s["steps"] for s in stages),
        "minimal_area_mm2": result["minimal_lumen_area_mm2"],
    }


def first_step_row(case, program, scene, first_steps):
    """Runs a scene with each of the first steps (ms) and returns its row of first_steps.csv."""
    settings = json.loads(scene.read_text())
    variant = scene.with_name("first_step.json")
    results = []
    for first_step in first_steps:
        write_json(variant, settings | {"numerics": settings.get("numerics", {}) | {"initial_step_ms": first_step}})
        code, messages, _ = run_program([program, "deploy", variant, "--out", scene.parent / "first_step"])
        if code not in (0, NO_BALANCE):
            raise ComputationError("a hard case was not computed", str(variant), f"exit code {code}", messages.strip())
        if not code:
            results.append(json.loads((scene.parent / "first_step" / "deployment.json").read_text()))
    row = {"case": case, "runs": len(first_steps), "refused": len(first_steps) - len(results)}
    return row | (differences(results) if results else {})


def differences(results):
    """How far the results (deployment.json) of one scene differ: columns of first_steps.csv."""
    areas = [[p["area_mm2"] for p in r["csa_profile"] if p["area_mm2"]] for r in results]
    steps = [sum(s["steps"] for s in r["stages"]) for r in results]
    return {
        "folded": sum(any("folded" in w for w in r["warnings"]) for r in results),
        "fewest_steps": min(steps),
        "most_steps": max(steps),
        "worst_penetration_mm": max(s["max_penetration_mm"] for r in results for s in r["stages"]),
        "mean_area_spread_percent": spread_percent([sum(a) / len(a) for a in areas]),
        "minimal_area_spread_percent": spread_percent([min(a) for a in areas]),
    }


def spread_percent(values):
    """Largest value over the smallest, less 1, in percent."""
    return 100 * (max(values) / min(values) - 1)


def selected_scenes(options):
    """Yields (name, path of the scene file) of the cases to run: the generated ones, then the user's own scenes."""
    unknown = set(options.only or []) - set(CASE_NAMES)
    if unknown:
        raise InputError("no such hard case", "--only", ", ".join(sorted(unknown)), "use " + "; ".join(CASE_NAMES))
    for name in options.only or CASE_NAMES:
        folder = options.out / "".join(c if c.isalnum() else "_" for c in name)
        numerics = {"maximal_steps_per_stage": MAXIMAL_STEPS}
        if name in BIFURCATION_STEPS:
            scene = culotte_scene(options.build, BIFURCATION_EDGE_MM, folder, BIFURCATION_STEPS[name])
            write_json(folder / "scene.json", scene | {"numerics": numerics})
            yield name, folder / "scene.json"
        else:
            tube, scene_options = CASES[name]
            yield name, write_scene(
                folder, tube, **(scene_options | {"numerics": numerics | scene_options.get("numerics", {})})
            )
    for scene in options.scenes:
        yield str(scene), scene


class CsvTable:
    """A CSV file that grows by rows, each of which is printed too."""

    def __init__(self, path, columns):
        self.file = path.open("w", newline="")
        self.writer = csv.DictWriter(self.file, columns.split(","))
        self.writer.writeheader()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.file.close()

    def add(self, row):
        """Writes a row (dict by column)."""
        self.writer.writerow(row)
        self.file.flush()
        print(", ".join(f"{key} {value}" for key, value in row.items()), file=sys.stderr)


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.benchmarks.hard_cases", description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", help="names of cases; all without it")
    parser.add_argument("--scenes", nargs="+", type=pathlib.Path, default=[], help="scenes of your own to add")
    parser.add_argument("--first-steps", nargs="+", type=float, default=[], help="lengths of the first step, ms")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of the program vci")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for hard_cases.csv and the scenes")
    options = parser.parse_args(arguments)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    options.out.mkdir(parents=True, exist_ok=True)
    program, files = options.build / "vci", {"hard_cases.csv": COLUMNS}
    if options.first_steps:
        files["first_steps.csv"] = FIRST_STEP_COLUMNS
    with contextlib.ExitStack() as stack:
        tables = {name: stack.enter_context(CsvTable(options.out / name, columns)) for name, columns in files.items()}
        for name, scene in selected_scenes(options):
            tables["hard_cases.csv"].add(result_row(name, program, scene))
            if options.first_steps and name != OWN_FIRST_STEP:
                tables["first_steps.csv"].add(first_step_row(name, program, scene, options.first_steps))


if __name__ == "__main__":
    main()
