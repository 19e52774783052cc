"""Sensitivity of areas to two settings without a measured value: the contact distance and the margin of the region.

/usr/bin/python3 -m vci.benchmarks.sensitivity --out results/sensitivity

Runs the generated scenes CASES of vci.benchmarks.benchmark, with one setting at a time changed from its default.
sensitivity.csv has a row for each run. The row gives by how much the mean and the minimal area of the reported segment
change, in percent of the areas with default settings. Runs follow one another.
"""

import argparse
import csv
import json
import pathlib
import sys

from common.documents import schema
from common.errors import ComputationError, guarded
from vci.benchmarks.benchmark import generated_scene, run_outcome

EDGE_MM = 0.6  # edge length of the lumen's triangles
CASES = ("straight", "curved 0.12 per mm", "eccentric")
VARIED_SETTINGS = {"contact_distance_mm": (0.00625, 0.0125, 0.025), "region_margin_mm": (1.0, 3.0, 6.0, 12.0)}
AREA_NAMES = ("mean_csa", "mla")
COLUMNS = ("setting", "value", "case", "mean_csa_mm2", "mla_mm2", "mean_csa_change_percent", "mla_change_percent")
COLUMNS += ("steps", "cpu_seconds")


def run_scene(program, case, numerics, folder):
    """Runs the scene `case` with the settings `numerics`, and returns the result of benchmark.run_outcome().

    Raises ComputationError if the scene is refused.
    """
    folder.mkdir(parents=True, exist_ok=True)
    scene = generated_scene(case, EDGE_MM, folder)
    scene["numerics"] = scene["numerics"] | numerics
    (folder / "scene.json").write_text(json.dumps(scene))
    outcome = run_outcome(program, folder / "scene.json")
    if outcome["outcome"] != "balanced":
        raise ComputationError("a scene of the sensitivity did not balance", case, numerics, outcome["reason"])
    return outcome


def sensitivity_rows(program, out):
    """Yields the rows of sensitivity.csv, scene by scene. program: path of vci. out: folder for the scenes."""
    numerics = schema.read("deployment")["properties"]["numerics"]["properties"]
    for case in CASES:
        name = "".join(c if c.isalnum() else "_" for c in case)
        default_outcome = run_scene(program, case, {}, out / name / "default")
        for setting, values in VARIED_SETTINGS.items():
            for value in values:
                is_default = value == numerics[setting]["default"]
                outcome = (
                    default_outcome
                    if is_default
                    else run_scene(program, case, {setting: value}, out / name / f"{setting}_{value}")
                )
                yield {"setting": setting, "value": value, "case": case} | {
                    key: outcome[key] for key in ("mean_csa_mm2", "mla_mm2", "steps", "cpu_seconds")
                } | {
                    f"{key}_change_percent": 100 * (outcome[f"{key}_mm2"] / default_outcome[f"{key}_mm2"] - 1)
                    for key in AREA_NAMES
                }


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.benchmarks.sensitivity", description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of the program vci")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for sensitivity.csv and the scenes")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    with (options.out / "sensitivity.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for row in sensitivity_rows(options.build / "vci", options.out):
            writer.writerow(row)
            file.flush()
            print(", ".join(f"{key} {value}" for key, value in row.items()), file=sys.stderr)


if __name__ == "__main__":
    main()
