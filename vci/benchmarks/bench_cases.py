"""Runs a synthetic case by the study's commands: vessel, lumen, plan, deployment engine and finite-element truth."""

import dataclasses
import json
import pathlib
import sys

import numpy as np

from vci.benchmarks.device_shapes import diameters
from vci.benchmarks.programs import reason_of, run

PYTHON = "/usr/bin/python3"
DEVICES = "config/devices"
# Settings of the finite-element truth, which are coarser than the study's. The mean error of its areas is below 1 %
# (data_synthetic/measured.md).
REFERENCE = {"slice_spacing_mm": 1.0, "elements_around": 16, "elements_through": 4, "check_slices": 0}


@dataclasses.dataclass(frozen=True)
class Outcome:
    """The results of a case in its folder, or the reason for which a command refused it.

    plan: the plan. engine: the engine's deployment.json. truth: the truth's reference.json. refused: empty if none did.
    """

    folder: pathlib.Path
    plan: dict = None
    engine: dict = None
    truth: dict = None
    refused: str = ""


def treat(case_file, folder, build, change=lambda plan: None, edge=0.4):
    """Runs the case in the YAML file `case_file` by engine and truth, and returns its Outcome.

    folder: for all files. build: folder of the programs vci and lumen. change: function that edits the plan before
    engine and truth use it. edge: edge length of the lumen's triangles, mm.
    """
    folder.mkdir(parents=True, exist_ok=True)
    settings, plan_file = folder / "reference_settings.json", folder / "vci" / "plan.json"
    settings.write_text(json.dumps(REFERENCE))
    prepare = [
        [PYTHON, "-m", "data_synthetic", "generate", case_file, "--out", folder / "source"],
        [build / "lumen", "process", folder / "source/lumen.vtp", "--units", "mm", "--edge", edge]
        + ["--out", folder / "anatomy"],
        [PYTHON, "-m", "anatomy", "plan", case_file, "--anatomy", folder / "anatomy", "--devices", DEVICES]
        + ["--out", plan_file],
    ]
    compute = [
        [build / "vci", "deploy", plan_file, "--out", folder / "engine"],
        [PYTHON, "-m", "data_synthetic", "reference", "--scene", plan_file, "--anatomy", folder / "anatomy"]
        + ["--truth", folder / "source/truth.json", "--settings", settings, "--out", folder / "reference"],
    ]
    for command in prepare + compute:
        if command is compute[0]:
            plan = json.loads(plan_file.read_text())
            change(plan)
            plan_file.write_text(json.dumps(plan))
        code, messages, _ = run(command)
        if code:
            print(f"{folder.name}: {reason_of(messages)}", file=sys.stderr)
            return Outcome(folder, refused=reason_of(messages))
    engine, truth = folder / "engine/deployment.json", folder / "reference/reference.json"
    return Outcome(folder, plan, json.loads(engine.read_text()), json.loads(truth.read_text()))


def chart_diameter(plan, device, pressure_bar):
    """Diameter in mm by the chart of a balloon, or of a stent's delivery balloon, at a pressure (bar)."""
    entry = plan["devices"][device]
    chart = plan["devices"][entry["balloon"]]["chart"] if "balloon" in entry else entry["chart"]
    return float(np.interp(pressure_bar, chart["pressure_bar"], chart["diameter_mm"]))


def circle(area_mm2):
    """Diameter in mm of the circle with this area."""
    return float(np.sqrt(4 * area_mm2 / np.pi))


def uses(plan, *actions):
    """[(name of the step, use of a device)] of the plan's steps with one of these actions."""
    return [(step["name"], use) for step in plan["procedure"] if step["action"] in actions for use in step["devices"]]


def stented_slices(truth):
    """The slices of the truth (reference.json) that lie within stents, with their radii (mm) at each step."""
    return [one for one in truth["slices"] if one["stented"]]


def after_stenting(outcome):
    """{model: {below_chart_percent, recoil_mm, short_of_chart_mm, expansion_percent}} of one stented case.

    The models are engine and truth. below_chart_percent: by how much the smallest final diameter in the stent is below
    the chart diameter of the largest balloon. recoil_mm: mean decrease of the stent's diameter since its inflation (in
    the truth, its widest). short_of_chart_mm: the delivery balloon's chart diameter minus its smallest diameter when
    inflated. expansion_percent: smallest area in the stent over the healthy area.
    """
    plan, engine, truth = outcome.plan, outcome.engine, outcome.truth
    widest = max(
        chart_diameter(plan, use["device"], use["pressure_bar"]) for _, use in uses(plan, "stent", "postdilatation")
    )
    name, use = uses(plan, "stent")[0]
    chart = chart_diameter(plan, use["device"], use["pressure_bar"])
    half = 0.5 * plan["devices"][use["device"]]["length_mm"]
    along, inflated = diameters(outcome.folder / "engine/devices" / f"{name}_balloon.vtp")
    worst = min(engine["stents"], key=lambda stent: stent["minimal_stent_area_mm2"])
    healthy = worst["minimal_stent_area_mm2"] / worst["expansion_index"]
    slices = stented_slices(truth)
    at_step = [next(h for h in one["history"] if h["step"] == name)["inflated_radius_mm"] for one in slices]
    lost = [max(h["inflated_radius_mm"] for h in one["history"]) - one["history"][-1]["radius_mm"] for one in slices]
    left = {"engine": engine["minimal_stent_area_mm2"], "truth": truth["minimal_lumen_area_in_stent_mm2"]}
    values = {
        key: {
            "below_chart_percent": 100 * (1 - circle(area) / widest),
            "expansion_percent": 100 * area / healthy,
        }
        for key, area in left.items()
    }
    values["engine"]["recoil_mm"] = worst["inflated_diameter_mm"] - worst["final_diameter_mm"]
    values["truth"]["recoil_mm"] = 2 * float(np.mean(lost))
    values["engine"]["short_of_chart_mm"] = chart - float(inflated[np.abs(along) < half].min())
    values["truth"]["short_of_chart_mm"] = chart - 2 * min(at_step)
    return values


def inflated_expansion(outcome, healthy_diameter_mm):
    """{model: area in percent of the healthy area} for the models engine and truth.

    The area is the smallest along the cylinder of the predilatation's balloon, while this balloon is inflated.
    """
    name, use = uses(outcome.plan, "predilatation")[0]
    half = 0.5 * outcome.plan["devices"][use["device"]]["length_mm"]
    along, inflated = diameters(outcome.folder / "engine/devices" / f"{name}_balloon.vtp")
    radii = [
        next(h for h in one["history"] if h["step"] == name)["inflated_radius_mm"]
        for one in outcome.truth["slices"]
        if abs(one["s_mm"] - use["centre_s_mm"]) < half
    ]
    found = {"engine": float(inflated[np.abs(along) < half].min()), "truth": 2 * min(radii)}
    return {key: 100 * (diameter / healthy_diameter_mm) ** 2 for key, diameter in found.items()}
