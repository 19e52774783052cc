"""Straightening by the reference's beams and by a solid in three dimensions: the command `straightening-3d`."""

import json
import logging
import pathlib
import sys
import time

import numpy as np
from scipy.interpolate import make_lsq_spline

from common.documents import config
from common.errors import ComputationError
from common.files import write_json

from .. import run
from ..slices import slices
from ..slices.lumen import solve_lumen
from ..straightening import beams
from ..tube.straightened import StraightenedTube
from .against_solid import parse_mesh, slice_areas

KNOT_SPACING_MM = 2.0  # shifts are smoothed by cubic splines with knots at this spacing
STENT_END_MM = 1.0  # this stretch at each end of the stent is left out of the mean curvature


def mean_curvature(axis, s_mm, shift_mm, span_mm):
    """Mean curvature (1/mm), between the arc lengths span_mm, of an axis (Curve) that is shifted sideways.

    shift_mm (n, 3): shifts at arc lengths s_mm (n,). They are smoothed, since a second derivative magnifies the
    differences between neighbouring stations.
    """
    inner = np.arange(s_mm[0] + KNOT_SPACING_MM, s_mm[-1] - 0.5 * KNOT_SPACING_MM, KNOT_SPACING_MM)
    smooth = make_lsq_spline(s_mm, shift_mm, np.concatenate([[s_mm[0]] * 4, inner, [s_mm[-1]] * 4]), 3)
    s = np.linspace(span_mm[0] + STENT_END_MM, span_mm[1] - STENT_END_MM, 201)
    first, second = axis.frame(s)[0] + smooth(s, 1), beams.curvature_vectors(axis, s) + smooth(s, 2)
    size = np.linalg.norm(first, axis=1)
    return float((np.linalg.norm(np.cross(first, second), axis=1) / size**3).mean())


def compare(scene_path, truth_path, out, meshes, settings_path=None):
    """Writes `out`/straightening_vs_3d.json: curvature along the stent before, by the beams and by solids.

    There are two curvatures: that of the lumen's centres, and that of the stent. Areas of the lumen along the
    stent and at its two ends show how the stent presses the wall aside; `before` is before it straightens the vessel.

    meshes: meshes of the solid as texts for `against_solid.parse_mesh`, coarse to fine. A mesh whose solid does not
    converge stands under `unsolved`. Returns the document. Raises InputError; ComputationError if no mesh converges.
    """
    logging.disable(logging.INFO)
    parsed_meshes = [parse_mesh(text) for text in meshes]
    scene, settings = run.load_scene(scene_path), config.load_section(settings_path, "reference")
    patient, steps = run.read_patient_and_steps(scene, scene_path, truth_path)
    stents, axis, solids = [step.stent for step in steps if step.stent], patient.branch.axis, []
    unsolved = []
    for text, mesh in zip(meshes, parsed_meshes):
        try:
            solids.append(_solve_solid(text, mesh, patient, steps, settings))
        except ComputationError as error:
            unsolved.append({"mesh": text, "message": str(error)})
            print(error, file=sys.stderr)
            if len(unsolved) == len(meshes):
                raise
    span = slices.stented_spans(steps)[0]
    along = np.linspace(*span, 201)
    start = time.perf_counter()
    solved = solve_lumen(slices.slice_model(settings), patient, steps, settings)
    bent = solved.straightening
    document = {
        "schema": "vci-straightening-vs-3d-2",
        "case": scene.get("case"),
        "settings": settings,
        "stented_span_mm": [float(end) for end in span],
        "stent_bending_n_mm2": max(one.bending_n_mm2 for one in stents),
        "foundation_n_per_mm2": float(solved.foundation_n_per_mm2),
        "curvature_before_per_mm": mean_curvature(axis, bent.s_mm, 0 * bent.vessel_mm, span),
        "beams": {
            "seconds": round(time.perf_counter() - start, 1),
            "curvature_per_mm": mean_curvature(axis, bent.s_mm, bent.lumen_shift(), span),
            "stent_curvature_per_mm": mean_curvature(axis, bent.s_mm[bent.stented], bent.stent_mm, span),
            "largest_shift_mm": float(np.linalg.norm(bent.lumen_shift(), axis=1).max()),
            "areas_mm2": _stent_areas(slice_areas(solved.field, patient.branch, along)),
        },
        "solids": solids,
        "unsolved": unsolved,
    }
    write_json(pathlib.Path(out) / "straightening_vs_3d.json", document)
    shown = {"before": document["curvature_before_per_mm"], "beams": document["beams"]["curvature_per_mm"]}
    print(json.dumps(shown | {one["mesh"]: one["curvature_per_mm"] for one in solids}, indent=1))
    return document


def _solve_solid(text, mesh, patient, steps, settings):
    """Entry (dict) of straightening_vs_3d.json for the solid of a mesh, which is named `text`."""
    start = time.perf_counter()
    tube = StraightenedTube(patient, steps, settings, mesh)
    tube.run()
    axis, span, s = patient.branch.axis, tube.stented_span, tube.tube.station_s_mm
    inside = np.flatnonzero((s > span[0] - 1e-6) & (s < span[1] + 1e-6))
    along = np.linspace(*span, 201)
    before = np.interp(along, s, tube.area_profile()[1])
    shift, stent_shift = tube.straighten()
    return {
        "mesh": text,
        "degrees_of_freedom": tube.model.degrees_of_freedom(),
        "seconds": round(time.perf_counter() - start, 1),
        "curvature_per_mm": mean_curvature(axis, s, shift, span),
        "stent_curvature_per_mm": mean_curvature(axis, s[inside], stent_shift, span),
        "largest_shift_mm": float(np.linalg.norm(shift, axis=1).max()),
        "areas_before_mm2": _stent_areas(before),
        "areas_mm2": _stent_areas(np.interp(along, s, tube.area_profile()[1])),
        "s_mm": s.round(6).tolist(),
        "shift_mm": shift.round(6).tolist(),
    }


def _stent_areas(area_mm2):
    """{mean and ends} of the lumen's areas (n,) along the stent."""
    return {"mean": float(area_mm2.mean()), "ends": area_mm2[[0, -1]].tolist()}
