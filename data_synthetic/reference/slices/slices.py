"""Positions of the slices, the solution of one slice, and the lumen's deformation from all slices."""

import sys

import numpy as np

from ..solid import tissue
from ..surface import deformation
from ..treatment import procedure
from . import own_error
from .model import SliceModel

REFINEMENTS = 3  # rounds in which slices are added
NEAREST_MM = 0.09  # no slice is added nearer than this to another


class Patient:
    """A virtual patient: the diseased `branch` that is cut into slices, all `branches`, and the wall's thickness.

    wall_mm: thickness of the healthy wall outside the plaque.
    """

    def __init__(self, branch, branches, wall_thickness_mm):
        self.branch, self.branches, self.wall_mm = branch, branches, wall_thickness_mm

    def place(self, model, s_mm):
        """Places a SliceModel on the section at arc length s_mm, with its shape and tissues, at rest."""
        inner, outer = tissue.rays(self.branch, self.wall_mm, s_mm, model.annulus.theta_rad)

        def material(angle, radius):
            return tissue.constants(self.branch, np.full_like(radius, s_mm), angle, radius)

        model.place(inner, outer, material)


def slice_positions(axis_length_mm, steps, spacing_mm, margin_mm):
    """Arc lengths in mm: (slices without a stent (n,), [(start, end, slices with the stent)] for each stented span).

    They are evenly spaced, with one at each end of a stented span.
    """
    low = min(step.balloon.reach()[0] for step in steps) - margin_mm
    high = max(step.balloon.reach()[1] for step in steps) + margin_mm
    low, high = max(low, 0.5), min(high, axis_length_mm - 0.5)

    def even(a, b):
        return np.linspace(a, b, max(int(np.ceil((b - a) / spacing_mm)), 2) + 1)

    held = [(a, b, even(a, b)) for a, b in spans(steps)]
    # Slices without the stent are needed only outside the spans and at their ends.
    free, start = [], low
    for a, b, _ in held:
        free += [even(start, a)] if a - start > 0.05 else [[a]]
        start = b
    free += [even(start, high)] if high - start > 0.05 else [[start]]
    return np.unique(np.concatenate(free).round(9)), held


def spans(steps):
    """[(start, end)] of the stretches (mm of arc length) that the stents of the steps hold, overlapping ones joined."""
    merged = []
    for a, b in sorted((step.stent.start_s_mm, step.stent.end_s_mm) for step in steps if step.stent):
        if merged and a <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(b, merged[-1][1]))
        else:
            merged.append((a, b))
    return merged


def model_of(settings, refine=1):
    return SliceModel(
        settings["elements_around"] * refine,
        settings["elements_through"] * refine,
        settings["wall_c10_mpa"],
        settings["wall_c20_mpa"],
        settings["bulk_modulus_mpa"],
        settings["support_mpa_per_mm"],
    )


def solve(model, patient, steps, s_mm, settings, stented):
    """Takes the model through the procedure at arc length s_mm: (displacement (2 around, 2) mm of the lumen, record).

    The record (dict) is the slice's entry in reference.json. stented: whether stents hold at this slice.
    """
    patient.place(model, s_mm)
    history = procedure.treat(model, steps, s_mm, settings, stented, patient.branch.name)
    record = {
        "s_mm": round(float(s_mm), 4),
        "stented": bool(stented),
        "radius_before_mm": float(patient.branch.radius(np.array(float(s_mm)))),
        "history": history,
        "area_mm2": float(model.lumen_area()),
        "iterations": model.iterations,
    }
    return model.lumen_displacement(), record


def lumen_field(model, patient, steps, settings):
    """(LumenDeformation, records, arc lengths of the slices without a stent (n,)) from all slices of the branch.

    Stented spans get more slices where evenly spaced ones do not resolve the area (`own_error.missed`).
    """
    free_s, stretches = slice_positions(
        patient.branch.axis.length_mm, steps, settings["slice_spacing_mm"], settings["margin_mm"]
    )
    records = []

    def solved(s, stented):
        moved, record = solve(model, patient, steps, s, settings, stented)
        records.append(record)
        print(
            f"slice {len(records)}: s {s:.2f} mm, radius {record['radius_before_mm']:.3f} -> "
            f"{np.sqrt(record['area_mm2'] / np.pi):.3f} mm, {record['iterations']} iterations",
            file=sys.stderr,
        )
        return moved, record["area_mm2"]

    def span(positions, stented):
        found = {float(s): solved(s, stented) for s in positions}
        for _ in range(REFINEMENTS if stented else 0):
            s = np.array(sorted(found))
            area = np.array([found[x][1] for x in s])
            error = own_error.missed(s, area, settings["edge_decay_mm"])
            added = between(s, error > settings["slice_tolerance_percent"])
            if not len(added):
                break
            found.update({float(x): solved(x, stented) for x in added})
        s = np.array(sorted(found))
        coupling = settings["edge_decay_mm"] if stented else 0.0
        return deformation.SpanField(s, model.annulus.theta_rad, np.array([found[x][0] for x in s]), coupling)

    print(
        f"{len(free_s)} slices on {patient.branch.name}, {sum(len(s) for _, _, s in stretches)} stented",
        file=sys.stderr,
    )
    free = span(free_s, False)
    held = [span(s, True) for _, _, s in stretches]
    return deformation.LumenDeformation(free, held, settings["edge_decay_mm"]), records, free_s


def between(s_mm, coarse):
    """Arc lengths (k,) of new slices, halfway from each slice that is `coarse` (n,) to its neighbours.

    A new slice is left out if it would lie within NEAREST_MM of a neighbour.
    """
    beside = np.flatnonzero(coarse[1:] | coarse[:-1])
    beside = beside[np.diff(s_mm)[beside] > 2 * NEAREST_MM]
    return 0.5 * (s_mm[beside] + s_mm[beside + 1])
