"""Expansion of a stent in calcium of several strengths, by which the strength of the default was chosen.

/usr/bin/python3 -m vci.benchmarks.calcium_strength --out results/calcium_strength

The vessels are those of vci.benchmarks.published, with calcium 10 mm long that spans one of three arcs. Each strength
is run with three lengths of the solver's first step: their spread tells how far areas depend on the solver's path.
Fujino 2018 measured by how much the expansion falls with the arc (column `change_percent`).
"""

import argparse
import json
import pathlib
import sys

import numpy as np

from common.errors import ComputationError, error_summary, guarded
from vci.benchmarks import bench_cases
from vci.benchmarks.benchmark import write_table
from vci.benchmarks.programs import run_program
from vci.benchmarks.published import ARCS_DEG, STENTING_PLAN, calcified_case

LENGTH_MM = 10  # length of the calcium
INITIAL_STEPS_MS = (0.27, 0.30, 0.34)  # lengths of the first step; their results show how areas depend on the path
KEYS = ("youngs_modulus_mpa", "yield_strain", "hardening")
DEFAULT = (20.0, 0.065, 0.05)
STRENGTHS = (
    (30.0, None, 0.0),
    (30.0, 0.1, 0.05),
    (20.0, 0.1, 0.05),
    DEFAULT,
    (20.0, 0.06, 0.05),
    (20.0, 0.05, 0.05),
    (12.0, 0.05, 0.05),
)
COLUMNS = [
    *KEYS,
    "strength_mpa",
    *(f"expansion_{arc}_percent" for arc in ARCS_DEG),
    "change_percent",
    "spread_percent",
    "refused",
]


def expansion(build, plan, law, first_step_ms, folder):
    """Smallest stent area over the healthy area (%) with calcium of this law, None if the deployment is refused.

    plan: content of plan.json, whose paths are relative to `folder`. law: values of KEYS. first_step_ms: length of the
    solver's first step.
    """
    scene = plan | {
        "wall": {"plaque": {"calcified": dict(zip(KEYS, law))}},
        "numerics": {"initial_step_ms": first_step_ms},
    }
    scene_file = folder / "scene.json"
    scene_file.write_text(json.dumps(scene))
    code, messages, _ = run_program([build / "vci", "deploy", scene_file, "--out", folder / "engine"])
    if code:
        print(f"{law}, first step {first_step_ms} ms: {error_summary(messages)}", file=sys.stderr)
        return None
    stents = json.loads((folder / "engine" / "deployment.json").read_text())["stents"]
    return 100 * min(stent["expansion_index"] for stent in stents)


def strength_row(law, expansions):
    """A row of the table, for calcium of one `law` (values of KEYS).

    expansions: {arc of calcium in degrees: expansion (%) at each of INITIAL_STEPS_MS, None for a refused deployment}.
    change_percent: change of the expansion for 180 degrees more of calcium, by linear regression over the arcs. It is
    left empty if every deployment at some arc was refused.
    """
    balanced = {arc: [value for value in values if value is not None] for arc, values in expansions.items()}
    row = dict(zip(KEYS, law)) | {"refused": f"{sum(v.count(None) for v in expansions.values())}"}
    row["refused"] += f" of {sum(len(values) for values in expansions.values())}"
    if law[1] is None:
        row["yield_strain"] = "never"
    else:
        row["strength_mpa"] = law[0] * law[1]
    means = {arc: float(np.mean(values)) for arc, values in balanced.items() if values}
    row |= {f"expansion_{arc}_percent": mean for arc, mean in means.items()}
    if means:
        row["spread_percent"] = max(100 * (max(v) / min(v) - 1) for v in balanced.values() if v)
    if len(means) == len(expansions):
        row["change_percent"] = 180 * float(np.polyfit(list(means), list(means.values()), 1)[0])
    return row


def strength_rows(build, folder):
    """Yields the row of each of STRENGTHS. Raises ComputationError if a vessel or its plan cannot be made."""
    plans = {}
    for arc in ARCS_DEG:
        case = calcified_case(folder / f"calcium_{arc}.yaml", arc, LENGTH_MM, STENTING_PLAN)
        plans[arc], refusal = bench_cases.prepare_plan(case, folder / case.stem, build)
        if refusal:
            raise ComputationError("a vessel of the benchmark was not made", case, refusal, "see the message above")
    for law in STRENGTHS:
        expansions = {
            arc: [expansion(build, json.loads(plan.read_text()), law, step, plan.parent) for step in INITIAL_STEPS_MS]
            for arc, plan in plans.items()
        }
        yield strength_row(law, expansions)


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(
        prog="python3 -m vci.benchmarks.calcium_strength", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of vci and lumen")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for strength.csv and the runs")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for row in strength_rows(options.build, options.out / "runs"):
        rows.append(row)
        write_table(rows, COLUMNS, options.out / "strength.csv")
        print(row, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
