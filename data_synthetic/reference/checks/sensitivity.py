"""Measures how the reference depends on each constant that is a choice; one constant is varied at a time.

The area is the mean of three slices, at the quarters of the stented stretch. The curvature is the mean over the stented
axis after the stent has straightened it, computed as a beam. Slices do not depend on the beam's constants. Of the
slices' constants only the support is varied in the beam. The beam's bending stiffness is a constant of its own here.
"""

import csv
import dataclasses
import pathlib
import sys

import numpy as np
from scipy.interpolate import CubicSpline

from common.documents import config
from common.errors import InputError
from common.files import replacing

from .. import run
from ..slices import slices
from ..surface import straightening

SLICE_CONSTANTS = (
    "stent_stiffness_mpa_per_mm",
    "wall_c10_mpa",
    "wall_c20_mpa",
    "bulk_modulus_mpa",
    "support_mpa_per_mm",
)
SLICE_FACTORS, BEAM_FACTORS = (0.5, 2.0), (0.25, 0.5, 2.0, 4.0)
STENT_BENDING, VESSEL_BENDING, SUPPORT = "stent bending_stiffness_n_mm2", "vessel_bending_n_mm2", "support_mpa_per_mm"
SLICE_POSITIONS = (0.25, 0.5, 0.75)  # places of the slices, as shares of the stented stretch's length


def write_sensitivity(scene_path, truth_path, out, settings_path=None):
    """Writes `out`/sensitivity.csv, a row for each constant and factor. Raises InputError, ComputationError."""
    scene, settings = run.load_scene(scene_path), config.load_section(settings_path, "reference")
    patient, steps = run.read_patient_and_steps(scene, scene_path, truth_path)
    stents = [step.stent for step in steps if step.stent]
    if not stents:
        raise InputError("no stent in the scene", f"{scene_path}: procedure", "none", "a plan with a stent")
    rows = _area_rows(patient, steps, stents, settings) + _curvature_rows(patient, stents, settings)
    with replacing(pathlib.Path(out) / "sensitivity.csv") as partial:
        with open(partial, "w", newline="") as handle:
            writer = csv.DictWriter(handle, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    return rows


def stented_span(stents):
    """Arc lengths (mm) from the first stent's start to the last one's end."""
    return min(s.start_s_mm for s in stents), max(s.end_s_mm for s in stents)


def _result_row(quantity, constant, value, factor, result, base):
    change = 100 * (result / base - 1)
    print(f"{constant} x {factor:g}: {quantity} {result:.5g} ({change:+.2f} %)", file=sys.stderr)
    return {
        "constant": constant,
        "value": f"{value:.6g}",
        "factor": f"{factor:g}",
        "quantity": quantity,
        "result": f"{result:.6g}",
        "change_percent": f"{change:.3f}",
    }


def _area_rows(patient, steps, stents, settings):
    low, high = stented_span(stents)

    def area(changed):
        model = slices.slice_model(changed)
        places = [low + share * (high - low) for share in SLICE_POSITIONS]
        return np.mean([slices.solve_slice(model, patient, steps, s, changed, True)[1]["area_mm2"] for s in places])

    base = area(settings)
    rows = [_result_row("area_mm2", "none", 1, 1, base, base)]
    for key in SLICE_CONSTANTS:
        for factor in SLICE_FACTORS:
            value = settings[key] * factor
            rows.append(_result_row("area_mm2", key, value, factor, area({**settings, key: value}), base))
    return rows


def _curvature_rows(patient, stents, settings):
    low, high = stented_span(stents)
    middle = 0.5 * (low + high)
    vessel_bending = straightening.vessel_bending_n_mm2(patient.branch, patient.wall_mm, middle, settings)
    known = {**settings, VESSEL_BENDING: vessel_bending}
    base = mean_curvature(patient, stents, known, (low, high))
    name = "curvature_per_mm"
    rows = [_result_row(name, "no stent", 0, 1, mean_curvature(patient, [], known, (low, high)), base)]
    rows.append(_result_row(name, "none", 1, 1, base, base))
    for factor in BEAM_FACTORS:
        for key in (SUPPORT, VESSEL_BENDING):
            value = known[key] * factor
            found = mean_curvature(patient, stents, {**known, key: value}, (low, high))
            rows.append(_result_row(name, key, value, factor, found, base))
        stiffer = [dataclasses.replace(s, bending_n_mm2=s.bending_n_mm2 * factor) for s in stents]
        found = mean_curvature(patient, stiffer, known, (low, high))
        rows.append(_result_row(name, STENT_BENDING, stiffer[0].bending_n_mm2, factor, found, base))
    return rows


def mean_curvature(patient, stents, settings, span_mm):
    """Mean curvature (1/mm) of the axis between two arc lengths (mm), straightened by the stents."""
    axis, middle = patient.branch.axis, 0.5 * sum(span_mm)
    s, axis_shift = straightening.axis_displacement(patient.branch, patient.wall_mm, stents, middle, settings)
    spline = CubicSpline(s, axis.point(s) + axis_shift)
    positions = np.linspace(*span_mm, 200)
    first, second = spline(positions, 1), spline(positions, 2)
    return float(np.mean(np.linalg.norm(np.cross(first, second), axis=1) / np.linalg.norm(first, axis=1) ** 3))
