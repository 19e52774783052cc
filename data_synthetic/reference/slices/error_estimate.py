"""Estimates the numerical error of the reference's lumen area by elements, by load steps and by the slices' spacing."""

import sys

import numpy as np
from scipy.interpolate import PchipInterpolator

from ..surface import deformation

FEWEST_FOR_SPACING = 5  # slices of a stented span that the estimate by spacing needs
SPAN_MARGIN_MM = 1e-3  # the records round the slices' places


def estimate(records, spans, settings, slice_area):
    """The document `error_estimate` of reference.json; all errors in per cent of a slice's area.

    records: the solved slices. spans: [(start, end)] in mm of the stented spans. slice_area(refinement, settings, s_mm,
    stented): function that solves a slice again with `refinement` times the elements, and returns its area in mm2.

    In the document, `slices` lists the slices that were solved again. step_percent is the change of a slice's area from
    half the load step to the full one. mesh_percent is the change from twice the elements to the usual number, both at
    half the load step. The error by spacing is the change of the area if a slice is left out (`leave_one_out_change`),
    span by span.
    """
    stented = sorted((r for r in records if r["stented"]), key=lambda r: r["s_mm"])
    pool = stented or sorted(records, key=lambda r: r["s_mm"])
    result = {
        "slices": [
            _slice_error(record, settings, slice_area) for record in _checked_slices(pool, settings["check_slices"])
        ]
    }
    for name in ("mesh", "step", "mesh_and_step"):
        if result["slices"]:
            result[f"{name}_area_percent"] = max(abs(entry[f"{name}_percent"]) for entry in result["slices"])
    by_span = []
    for start, end in spans:
        inside = [r for r in stented if start - SPAN_MARGIN_MM <= r["s_mm"] <= end + SPAN_MARGIN_MM]
        if len(inside) >= FEWEST_FOR_SPACING:
            s, area = (np.array([r[key] for r in inside]) for key in ("s_mm", "area_mm2"))
            by_span.append(leave_one_out_change(s, area, settings["edge_decay_mm"]))
    if by_span:
        error = np.concatenate(by_span)
        result["spacing_area_percent"] = {"mean": float(error.mean()), "largest": float(error.max())}
        result["spacing_note"] = "largest change of the area anywhere by leaving out a slice: an upper estimate"
    return result


def _checked_slices(pool, count):
    """`count` slices: the narrowest one before the procedure, then others at even intervals."""
    if count == 0:
        return []
    tightest = int(np.argmin([r["radius_before_mm"] for r in pool]))
    others = np.linspace(0, len(pool) - 1, min(count, len(pool)) + 1).round().astype(int)
    return [pool[i] for i in ([tightest] + [int(i) for i in others if i != tightest])[:count]]


def _slice_error(record, settings, slice_area):
    print(f"error estimate: slice at s {record['s_mm']:.2f} mm, half the step, twice the elements", file=sys.stderr)
    halved = dict(settings, radius_step_mm=0.5 * settings["radius_step_mm"])
    position = (record["s_mm"], record["stented"])
    small_steps, both = slice_area(1, halved, *position), slice_area(2, halved, *position)
    return {
        "s_mm": record["s_mm"],
        "step_percent": 100 * (record["area_mm2"] / small_steps - 1),
        "mesh_percent": 100 * (small_steps / both - 1),
        "mesh_and_step_percent": 100 * (record["area_mm2"] / both - 1),
    }


def leave_one_out_change(s_mm, area_mm2, coupling_mm):
    """Largest change in per cent (n,) of the lumen's area along the span if one slice is left out; 0 for the two ends.

    s_mm, area_mm2 (n,): slices of one span. Between slices the radii of circles of equal area are interpolated and
    coupled along the axis. SpanField does the same with the lumen's displacement. coupling_mm: see SpanField.
    """
    fine = deformation.grid_positions(s_mm)
    coupling = (
        deformation.couple_along_axis(np.eye(len(fine)), fine[1] - fine[0], coupling_mm)
        if coupling_mm
        else np.eye(len(fine))
    )
    radius = np.sqrt(np.asarray(area_mm2) / np.pi)

    def squared_radius(kept):
        return (coupling @ PchipInterpolator(s_mm[kept], radius[kept])(fine)) ** 2

    error, all_slices = np.zeros(len(s_mm)), squared_radius(np.full(len(s_mm), True))
    for i in range(1, len(s_mm) - 1):
        without = squared_radius(np.arange(len(s_mm)) != i)
        error[i] = 100 * np.abs(without / all_slices - 1).max()
    return error
