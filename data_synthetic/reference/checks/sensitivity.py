"""Measures how the reference depends on each constant that is a choice; one constant is varied at a time.

The area is the mean of three slices, at the quarters of the stented stretch. The curvature is the mean over the stented
lumen's centres after the stent has straightened the vessel, by the beams. The slices' stiffness as parts of the vessel
and their resistance to the stent are computed once, and then varied by a factor.
"""

import csv
import dataclasses
import pathlib
import sys

import numpy as np

from common.documents import config
from common.errors import InputError
from common.files import replacing

from .. import run
from ..slices import slices
from ..slices.lumen import solve_lumen
from ..straightening.stent_in_vessel import straighten
from .straightening_in_solid import mean_curvature

SLICE_CONSTANTS = (
    "stent_stiffness_mpa_per_mm",
    "wall_c10_mpa",
    "wall_c20_mpa",
    "bulk_modulus_mpa",
    "support_mpa_per_mm",
)
SLICE_FACTORS, BEAM_FACTORS = (0.5, 2.0), (0.25, 0.5, 2.0, 4.0)
STENT_BENDING, SUPPORT = "stent bending_stiffness_n_mm2", "support_mpa_per_mm"
VESSEL, CONTACT = "vessel's bending and shear stiffness", "sections' resistance to the stent"
SLICE_POSITIONS = (0.25, 0.5, 0.75)  # places of the slices, as shares of the stented stretch's length


def write_sensitivity(scene_path, truth_path, out, settings_path=None):
    """Writes `out`/sensitivity.csv, a row for each constant and factor. Raises InputError, ComputationError."""
    scene, settings = run.load_scene(scene_path), config.load_section(settings_path, "reference")
    patient, steps = run.read_patient_and_steps(scene, scene_path, truth_path)
    stents = [step.stent for step in steps if step.stent]
    if not stents:
        raise InputError("no stent in the scene", f"{scene_path}: procedure", "none", "a plan with a stent")
    rows = _area_rows(patient, steps, stents, settings) + _curvature_rows(patient, steps, stents, settings)
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


def stiffer_law(law, factor):
    """The SidewaysLaw whose force and wall's bending are those of `law`, multiplied by a factor."""
    return dataclasses.replace(
        law, force_n_per_mm=factor * law.force_n_per_mm, wall_bending_n_mm2=factor * law.wall_bending_n_mm2
    )


def _curvature_rows(patient, steps, stents, settings):
    axis, span, name = patient.branch.axis, stented_span(stents), "curvature_per_mm"
    solved = solve_lumen(slices.slice_model(settings), patient, steps, settings)
    foundation = solved.foundation_n_per_mm2

    def curvature(vessel=1.0, contact=1.0, support=1.0, stent=1.0):
        """Mean curvature in 1/mm with each stiffness multiplied by a factor."""
        sections = solved.sections
        changed = dataclasses.replace(
            sections,
            bending_n_mm2=vessel * sections.bending_n_mm2,
            shear_n=vessel * sections.shear_n,
            laws=[(s, stiffer_law(law, contact)) for s, law in sections.laws],
        )
        stiffer = [dataclasses.replace(one, bending_n_mm2=stent * one.bending_n_mm2) for one in stents]
        bent = straighten(axis, stiffer, changed, support * foundation)
        return mean_curvature(axis, bent.s_mm, bent.lumen_shift(), span)

    base = curvature()
    before = mean_curvature(axis, solved.straightening.s_mm, 0 * solved.straightening.vessel_mm, span)
    rows = [_result_row(name, "no stent", 0, 1, before, base), _result_row(name, "none", 1, 1, base, base)]
    constants = (
        ("support", SUPPORT, settings["support_mpa_per_mm"]),
        ("vessel", VESSEL, 1),
        ("contact", CONTACT, 1),
        ("stent", STENT_BENDING, stents[0].bending_n_mm2),
    )
    for factor in BEAM_FACTORS:
        for key, constant, value in constants:
            rows.append(_result_row(name, constant, factor * value, factor, curvature(**{key: factor}), base))
    return rows
