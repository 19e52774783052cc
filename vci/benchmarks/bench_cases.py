"""Runs the study's commands on a synthetic case: vessel, lumen, plan, deployment engine and finite-element truth."""

import dataclasses
import json
import pathlib
import sys

import numpy as np

from common.documents import plan_reader
from common.errors import error_summary
from vci.benchmarks.device_shapes import ring_diameters
from vci.benchmarks.programs import run_program

PYTHON = "/usr/bin/python3"
DEVICES_FOLDER = "config/devices"
# Settings of the finite-element truth, coarser than those of the study. The mean error of the areas is still below 1 %
# (data_synthetic/measured.md).
TRUTH_SETTINGS = {"slice_spacing_mm": 1.0, "elements_around": 16, "elements_through": 4, "check_slices": 0}


@dataclasses.dataclass(frozen=True)
class CaseOutcome:
    """The results of a case, or the reason for which a command refused it.

    folder: folder with all files of the case. plan, engine, truth: contents of plan.json, deployment.json and
    reference.json. refusal: the reason; empty if no command refused the case. If only the truth was refused, the
    engine's results are there.
    """

    folder: pathlib.Path
    plan: dict = None
    engine: dict = None
    truth: dict = None
    refusal: str = ""


def prepare_plan(case_file, folder, build, edge=0.4):
    """Makes vessel, lumen and plan of a case in `folder`. Returns (plan's file, None), or (None, reason of refusal).

    case_file: YAML file of the case. build: folder of the program lumen. edge: edge length (mm) of the lumen's
    triangles.
    """
    plan_file = folder / "vci" / "plan.json"
    commands = [
        [PYTHON, "-m", "data_synthetic", "generate", case_file, "--out", folder / "source"],
        [build / "lumen", "process", folder / "source/lumen.vtp", "--units", "mm", "--edge", edge]
        + ["--out", folder / "anatomy"],
        [PYTHON, "-m", "anatomy", "plan", case_file, "--anatomy", folder / "anatomy", "--devices", DEVICES_FOLDER]
        + ["--out", plan_file],
    ]
    refusal = first_refusal(commands, folder.name)
    return (None, refusal) if refusal else (plan_file, None)


def first_refusal(commands, case):
    """Runs commands until one is refused. Prints and returns the reason; None if all commands succeed."""
    for command in commands:
        code, messages, _ = run_program(command)
        if code:
            print(f"{case}: {error_summary(messages)}", file=sys.stderr)
            return error_summary(messages)
    return None


def run_engine_and_truth(case_file, folder, build, edit_plan=lambda plan: None):
    """Runs engine and truth on the case in the YAML file `case_file`, and returns the CaseOutcome.

    folder: folder for all files. build: folder of the programs vci and lumen. edit_plan: function that edits the plan
    before engine and truth use it.
    """
    plan_file, refusal = prepare_plan(case_file, folder, build)
    if refusal:
        return CaseOutcome(folder, refusal=refusal)
    settings_file = folder / "reference_settings.json"
    settings_file.write_text(json.dumps(TRUTH_SETTINGS))
    plan = json.loads(plan_file.read_text())
    edit_plan(plan)
    plan_file.write_text(json.dumps(plan))
    commands = [
        [build / "vci", "deploy", plan_file, "--out", folder / "engine"],
        [PYTHON, "-m", "data_synthetic", "reference", "--scene", plan_file, "--anatomy", folder / "anatomy"]
        + ["--truth", folder / "source/truth.json", "--settings", settings_file, "--out", folder / "reference"],
    ]
    results, files = [], (folder / "engine/deployment.json", folder / "reference/reference.json")
    for command, file in zip(commands, files):
        if refusal := first_refusal([command], folder.name):
            return CaseOutcome(folder, plan, *results, refusal=refusal)
        results.append(json.loads(file.read_text()))
    return CaseOutcome(folder, plan, *results)


def chart_diameter(plan, device, pressure_bar):
    """Diameter in mm by the chart of a balloon, or of a stent's delivery balloon, at a pressure (bar)."""
    chart = plan_reader.inflating_balloon(plan["devices"], device)["chart"]
    return float(np.interp(pressure_bar, chart["pressure_bar"], chart["diameter_mm"]))


def circle_diameter(area_mm2):
    """Diameter in mm of the circle with this area."""
    return float(np.sqrt(4 * area_mm2 / np.pi))


def device_uses(plan, *actions):
    """[(name of the step, use of a device)] of the plan's steps with one of these actions."""
    return [(step["name"], use) for step in plan["procedure"] if step["action"] in actions for use in step["devices"]]


def stented_slices(truth):
    """The slices of the truth (reference.json) that lie within stents, with their radii (mm) at each step."""
    return [section for section in truth["slices"] if section["stented"]]


def stenting_figures(outcome):
    """{model: {figure: value}} of one stented case. The models are engine and truth.

    below_chart_percent: by how much the smallest final diameter in the stent is below the chart diameter of the largest
    balloon. area_of_chart_percent: the smallest final area over that of a circle of the chart diameter. recoil_mm: mean
    diameter of the inflated stent minus mean final diameter (in the truth each slice at its widest inflation).
    short_of_chart_mm: the delivery balloon's chart diameter minus its smallest diameter when inflated.
    expansion_percent: smallest area in the stent over the healthy area there. gain_mm: mean increase of the lumen's
    diameter along the stents.
    """
    plan, engine, truth = outcome.plan, outcome.engine, outcome.truth
    widest = max(
        chart_diameter(plan, use["device"], use["pressure_bar"])
        for _, use in device_uses(plan, "stent", "postdilatation")
    )
    name, use = device_uses(plan, "stent")[0]
    chart = chart_diameter(plan, use["device"], use["pressure_bar"])
    half = 0.5 * plan["devices"][use["device"]]["length_mm"]
    along, inflated = ring_diameters(outcome.folder / "engine/devices" / f"{name}_balloon.vtp")
    worst = min(engine["stents"], key=lambda stent: stent["minimal_stent_area_mm2"])
    healthy = worst["minimal_stent_area_mm2"] / worst["expansion_index"]
    slices = stented_slices(truth)
    inflated_radii = [
        next(h for h in section["history"] if h["step"] == name)["inflated_radius_mm"] for section in slices
    ]
    recoils = [
        max(h["inflated_radius_mm"] for h in section["history"]) - section["history"][-1]["radius_mm"]
        for section in slices
    ]
    smallest_areas = {"engine": engine["minimal_stent_area_mm2"], "truth": truth["minimal_lumen_area_in_stent_mm2"]}
    values = {
        key: {
            "below_chart_percent": 100 * (1 - circle_diameter(area) / widest),
            "area_of_chart_percent": 100 * (circle_diameter(area) / widest) ** 2,
            "expansion_percent": 100 * area / healthy,
        }
        for key, area in smallest_areas.items()
    }
    values["engine"]["recoil_mm"] = worst["inflated_diameter_mm"] - worst["final_diameter_mm"]
    values["truth"]["recoil_mm"] = 2 * float(np.mean(recoils))
    values["engine"]["short_of_chart_mm"] = chart - float(inflated[np.abs(along) < half].min())
    values["truth"]["short_of_chart_mm"] = chart - 2 * min(inflated_radii)
    areas = [(a["area_mm2"], b["area_mm2"]) for a, b in zip(engine["csa_profile"], engine["csa_profile_before"])]
    gains = [circle_diameter(after) - circle_diameter(before) for after, before in areas if after and before]
    values["engine"]["gain_mm"] = float(np.mean(gains))
    gains = [circle_diameter(section["area_mm2"]) - 2 * section["radius_before_mm"] for section in slices]
    values["truth"]["gain_mm"] = float(np.mean(gains))
    return values


def balloon_figures(outcome):
    """{model: {figure: value}} of a case that is treated by one balloon. The models are engine and truth.

    inflated_mm, final_mm: diameter in the balloon's middle, of the inflated balloon and of the lumen at the end. A
    model that was refused is left out.
    """
    if outcome.plan is None:
        return {}
    [(name, use)] = device_uses(outcome.plan, "predilatation")
    place = use["centre_s_mm"]
    figures = {}
    if outcome.engine:
        along, diameters = ring_diameters(outcome.folder / "engine/devices" / f"{name}_balloon.vtp")
        profile = [(row["s_mm"], row["area_mm2"]) for row in outcome.engine["csa_profile"] if row["area_mm2"]]
        area = float(np.interp(place, *zip(*profile)))
        inflated = float(np.interp(0.0, along, diameters))
        figures["engine"] = {"inflated_mm": inflated, "final_mm": circle_diameter(area)}
    if outcome.truth:
        [step] = min(outcome.truth["slices"], key=lambda section: abs(section["s_mm"] - place))["history"]
        figures["truth"] = {"inflated_mm": 2 * step["inflated_radius_mm"], "final_mm": 2 * step["radius_mm"]}
    return figures
