"""Positions of the slices, the solution of one slice, and the lumen's deformation from all slices."""

import sys

import numpy as np

from ..solid import tissue
from ..surface import deformation
from ..treatment import procedure
from . import error_estimate
from .model import SliceModel

MOST_REFINEMENTS = 3  # slices are added in at most this many rounds
LEAST_SPACING_MM = 0.09  # no slice is added nearer than this to another


class Patient:
    """A virtual patient: the diseased `branch` that is cut into slices, all `branches`, and the wall's thickness.

    wall_mm: thickness in mm of the healthy wall, which lies outside the plaque.
    """

    def __init__(self, branch, branches, wall_thickness_mm):
        self.branch, self.branches, self.wall_mm = branch, branches, wall_thickness_mm

    def place(self, model, s_mm):
        """Places a SliceModel on the section at arc length s_mm, with its shape and tissues, at rest."""
        inner, outer = tissue.inner_outer_radii(self.branch, self.wall_mm, s_mm, model.annulus.theta_rad)

        def material(angle, radius):
            return tissue.material_constants(self.branch, np.full_like(radius, s_mm), angle, radius)

        model.place(inner, outer, material)


def slice_positions(axis_length_mm, steps, spacing_mm, margin_mm):
    """Arc lengths in mm: (slices without a stent (n,), [(start, end, slices with the stent)] for each stented span).

    They are evenly spaced. At each end of a stented span there is a slice of both kinds.
    """
    low = min(step.balloon.reach()[0] for step in steps) - margin_mm
    high = max(step.balloon.reach()[1] for step in steps) + margin_mm
    low, high = max(low, 0.5), min(high, axis_length_mm - 0.5)

    def evenly_spaced(a, b):
        return np.linspace(a, b, max(int(np.ceil((b - a) / spacing_mm)), 2) + 1)

    stented = [(a, b, evenly_spaced(a, b)) for a, b in stented_spans(steps)]
    # Slices without the stent are needed only outside the spans and at their ends.
    unstented, start = [], low
    for a, b, _ in stented:
        unstented += [evenly_spaced(start, a)] if a - start > 0.05 else [[a]]
        start = b
    unstented += [evenly_spaced(start, high)] if high - start > 0.05 else [[start]]
    return np.unique(np.concatenate(unstented).round(9)), stented


def stented_spans(steps):
    """[(start, end)] of the stretches (mm of arc length) that the stents of the steps hold, overlapping ones joined."""
    merged = []
    for a, b in sorted((step.stent.start_s_mm, step.stent.end_s_mm) for step in steps if step.stent):
        if merged and a <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(b, merged[-1][1]))
        else:
            merged.append((a, b))
    return merged


def slice_model(settings, refine=1):
    return SliceModel(
        settings["elements_around"] * refine,
        settings["elements_through"] * refine,
        settings["wall_c10_mpa"],
        settings["wall_c20_mpa"],
        settings["bulk_modulus_mpa"],
        settings["support_mpa_per_mm"],
    )


def solve_slice(model, patient, steps, s_mm, settings, stented):
    """Takes the model through the procedure at arc length s_mm: (displacement (2 around, 2) mm of the lumen, record).

    record: the slice's entry (dict) in reference.json. stented: whether stents hold at this slice.
    """
    patient.place(model, s_mm)
    history = procedure.run_procedure(model, steps, s_mm, settings, stented, patient.branch.name)
    record = {
        "s_mm": round(float(s_mm), 4),
        "stented": bool(stented),
        "radius_before_mm": float(patient.branch.radius(np.array(float(s_mm)))),
        "history": history,
        "area_mm2": float(model.lumen_area()),
        "iterations": model.iterations,
    }
    return model.lumen_displacement(), record


def solve_lumen(model, patient, steps, settings):
    """(LumenDeformation, records, arc lengths of the slices without a stent (n,)) from all slices of the branch.

    A stented span gets more slices where evenly spaced ones do not resolve the area. This is judged by
    `error_estimate.leave_one_out_change`.
    """
    unstented_s, spans = slice_positions(
        patient.branch.axis.length_mm, steps, settings["slice_spacing_mm"], settings["margin_mm"]
    )
    records = []

    def solve_and_record(s, stented):
        moved, record = solve_slice(model, patient, steps, s, settings, stented)
        records.append(record)
        print(
            f"slice {len(records)}: s {s:.2f} mm, radius {record['radius_before_mm']:.3f} -> "
            f"{np.sqrt(record['area_mm2'] / np.pi):.3f} mm, {record['iterations']} iterations",
            file=sys.stderr,
        )
        return moved, record["area_mm2"]

    def span_field(positions, stented):
        found = {float(s): solve_and_record(s, stented) for s in positions}
        for _ in range(MOST_REFINEMENTS if stented else 0):
            s = np.array(sorted(found))
            area = np.array([found[x][1] for x in s])
            error = error_estimate.leave_one_out_change(s, area, settings["edge_decay_mm"])
            added = midpoints(s, error > settings["slice_tolerance_percent"])
            if not len(added):
                break
            found.update({float(x): solve_and_record(x, stented) for x in added})
        s = np.array(sorted(found))
        coupling = settings["edge_decay_mm"] if stented else 0.0
        return deformation.SpanField(s, model.annulus.theta_rad, np.array([found[x][0] for x in s]), coupling)

    print(
        f"{len(unstented_s)} slices on {patient.branch.name}, {sum(len(s) for _, _, s in spans)} stented",
        file=sys.stderr,
    )
    unstented = span_field(unstented_s, False)
    stented_fields = [span_field(s, True) for _, _, s in spans]
    return deformation.LumenDeformation(unstented, stented_fields, settings["edge_decay_mm"]), records, unstented_s


def midpoints(s_mm, coarse):
    """Arc lengths (k,) of new slices, halfway from each slice with `coarse` (n,) true to its neighbours.

    A new slice is left out if it would lie within LEAST_SPACING_MM of a neighbour.
    """
    intervals = np.flatnonzero(coarse[1:] | coarse[:-1])
    intervals = intervals[np.diff(s_mm)[intervals] > 2 * LEAST_SPACING_MM]
    return 0.5 * (s_mm[intervals] + s_mm[intervals + 1])
