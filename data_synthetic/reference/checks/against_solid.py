"""Difference between the slices and a solid in three dimensions: the command `reference-3d`."""

import dataclasses
import json
import logging
import pathlib
import re
import sys
import time

import numpy as np

from common.documents import config
from common.errors import InputError
from common.files import write_json

from .. import run
from ..slices import slices
from ..slices.lumen import solve_lumen
from ..tube.procedure import TreatedTube, enclosed_area

SAMPLE_SPACING_MM = 0.1
STENT_EDGE_MM = 1.5  # areas nearer than this to a stent's end, on either side, are compared separately
LIMP_N_MM2 = 1e-3  # bending stiffness of a stent that follows the vessel; 0 would leave its rotation free
EXCLUDED_END_MM = 1.0  # left out at each end of the computed stretch, where the solid is held


def parse_mesh(text):
    """(elements round, elements through, element length mm) from a text such as 12x4x1.1. Raises InputError."""
    match = re.fullmatch(r"(\d+)x(\d+)x(\d+(?:\.\d+)?)", text)
    mesh = (int(match[1]), int(match[2]), float(match[3])) if match else (0, 0, 0.0)
    if not (6 <= mesh[0] <= 48 and 2 <= mesh[1] <= 12 and 0.2 <= mesh[2] <= 3):
        raise InputError(
            "not a mesh",
            "--meshes",
            text,
            "elements round (6 to 48) x through the wall (2 to 12) x length in mm (0.2 to 3), as 12x4x1.1",
        )
    return mesh


def slice_areas(field, branch, s_mm):
    """Area (n,) in mm2 of the lumen by the slices at arc lengths s_mm (n,)."""
    theta = 2 * np.pi * np.arange(96) / 96
    s, angle = (v.ravel() for v in np.meshgrid(s_mm, theta, indexing="ij"))
    moved = field.in_plane(s, angle) + branch.radius(s)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return enclosed_area(*moved.reshape(len(s_mm), len(theta), 2).transpose(2, 0, 1))


def area_errors(s_mm, area, reference_area, span_mm):
    """Errors in per cent of `area` (n,) against `reference_area` (n,), both in mm2 at arc lengths s_mm (n,).

    Three errors are given: of the area in each region, of the smallest area within the stent, and of the resistance
    (sum of A^-2 of the areas A). span_mm: arc lengths (2,) of the stent's ends.
    """
    error = 100 * (area / reference_area - 1)
    distance_to_edge = np.minimum(np.abs(s_mm - span_mm[0]), np.abs(s_mm - span_mm[1]))
    stented = (s_mm >= span_mm[0]) & (s_mm <= span_mm[1])
    regions = {
        "stent": stented & (distance_to_edge > STENT_EDGE_MM),
        "stent_edges": distance_to_edge <= STENT_EDGE_MM,
        "beyond": ~stented & (distance_to_edge > STENT_EDGE_MM),
    }
    found = {
        f"{name}_area_percent": {
            "mean": float(error[at].mean()),
            "rms": float(np.sqrt(np.mean(error[at] ** 2))),
            "largest": float(error[at][np.argmax(np.abs(error[at]))]),
        }
        for name, at in regions.items()
        if at.any()
    }
    smallest, smallest_reference = area[stented].min(), reference_area[stented].min()
    found["minimal_lumen_area_in_stent_percent"] = float(100 * (smallest / smallest_reference - 1))
    found["resistance_percent"] = float(100 * (np.sum(area**-2.0) / np.sum(reference_area**-2.0) - 1))
    return found


def _with_limp_stents(steps):
    """The steps, with stents that hardly resist bending: in this solid the devices follow the axis, too."""
    return [
        dataclasses.replace(step, stent=dataclasses.replace(step.stent, bending_n_mm2=LIMP_N_MM2))
        if step.stent
        else step
        for step in steps
    ]


def compare(scene_path, truth_path, out, meshes, settings_path=None):
    """Writes `out`/slices_vs_3d.json: the lumen's areas by slices and by the solid, and their differences.

    meshes: meshes of the solid as texts for `parse_mesh`, coarse to fine. The slices are compared with each, and each
    mesh with the one before it. Raises InputError, ComputationError.
    """
    logging.disable(logging.INFO)
    parsed_meshes = [parse_mesh(text) for text in meshes]
    scene, settings = run.load_scene(scene_path), config.load_section(settings_path, "reference")
    patient, steps = run.read_patient_and_steps(scene, scene_path, truth_path)
    start = time.perf_counter()
    solved = solve_lumen(slices.slice_model(settings), patient, _with_limp_stents(steps), settings)
    slice_seconds = time.perf_counter() - start
    first, last = solved.sections.s_mm[[0, -1]]
    s = np.arange(first + EXCLUDED_END_MM, last - EXCLUDED_END_MM, SAMPLE_SPACING_MM)
    area = slice_areas(solved.field, patient.branch, s)
    solids, areas = [], []
    for text, mesh in zip(meshes, parsed_meshes):
        start = time.perf_counter()
        print(f"solid of {text} elements", file=sys.stderr)
        tube = TreatedTube(patient, steps, settings, mesh)
        tube.run()
        areas.append(np.interp(s, *tube.area_profile()))
        solids.append(
            {
                "mesh": text,
                "degrees_of_freedom": tube.model.degrees_of_freedom(),
                "iterations": tube.model.iterations,
                "seconds": round(time.perf_counter() - start, 1),
                "area_mm2": areas[-1].round(6).tolist(),
                "slices_against_it": area_errors(s, area, areas[-1], tube.stented_span),
            }
        )
        if len(areas) > 1:
            solids[-1]["mesh_before_against_it"] = area_errors(s, areas[-2], areas[-1], tube.stented_span)
    document = {
        "schema": "vci-slices-vs-3d-1",
        "case": scene.get("case"),
        "settings": settings,
        "s_mm": s.round(6).tolist(),
        "area_before_mm2": (np.pi * patient.branch.radius(s) ** 2).round(6).tolist(),
        "slices": {
            "count": len(solved.records),
            "seconds": round(slice_seconds, 1),
            "area_mm2": area.round(6).tolist(),
        },
        "solids": solids,
    }
    write_json(pathlib.Path(out) / "slices_vs_3d.json", document)
    print(json.dumps(solids[-1]["slices_against_it"], indent=1))
    return document
