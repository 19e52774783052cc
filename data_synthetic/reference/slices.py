"""The slices: where they lie, one of them solved, and the lumen's deformation from all of them."""

import sys

import numpy as np

from . import deformation, procedure, tissue
from .slice_model import SliceModel


class Patient:
    """The diseased branch, from which slices are cut, among all `branches`."""

    def __init__(self, branch, branches, wall_thickness_mm):
        self.branch, self.branches, self.wall_mm = branch, branches, wall_thickness_mm

    def place(self, model, s_mm):
        """Puts the model on the section at s_mm."""
        inner, outer = tissue.rays(self.branch, self.wall_mm, s_mm, model.annulus.theta_rad)

        def material(angle, radius):
            return tissue.constants(self.branch, np.full_like(radius, s_mm), angle, radius)

        model.place(inner, outer, material)


def slice_positions(axis_length_mm, steps, spacing_mm, margin_mm):
    """Arc lengths (free slices (n,), [(start, end, held slices)]): even, with one at each end of a stented span."""
    low = min(step.balloon.reach()[0] for step in steps) - margin_mm
    high = max(step.balloon.reach()[1] for step in steps) + margin_mm
    low, high = max(low, 0.5), min(high, axis_length_mm - 0.5)
    spans = _union([(step.stent.start_s_mm, step.stent.end_s_mm) for step in steps if step.stent])

    def even(a, b):
        return np.linspace(a, b, max(int(np.ceil((b - a) / spacing_mm)), 2) + 1)

    held = [(a, b, even(a, b)) for a, b in spans]
    # Without the stent slices matter outside the spans only, and at their ends.
    free, start = [], low
    for a, b in spans:
        free += [even(start, a)] if a - start > 0.05 else [[a]]
        start = b
    free += [even(start, high)] if high - start > 0.05 else [[start]]
    return np.unique(np.concatenate(free).round(9)), held


def _union(spans):
    merged = []
    for a, b in sorted(spans):
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
    """(lumen displacement (m, 2), record) of one slice."""
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
    """(LumenDeformation, records, arc lengths of the slices without a stent (n,)) from all slices of the branch."""
    free_s, spans = slice_positions(
        patient.branch.axis.length_mm, steps, settings["slice_spacing_mm"], settings["margin_mm"]
    )
    total = len(free_s) + sum(len(s) for _, _, s in spans)
    print(f"{total} slices on {patient.branch.name}", file=sys.stderr)
    records = []

    def span(positions, stented):
        displacements = []
        for s in positions:
            moved, record = solve(model, patient, steps, s, settings, stented)
            displacements.append(moved)
            records.append(record)
            print(
                f"slice {len(records)}/{total}: s {s:.2f} mm, radius {record['radius_before_mm']:.3f} -> "
                f"{np.sqrt(record['area_mm2'] / np.pi):.3f} mm, {record['iterations']} iterations",
                file=sys.stderr,
            )
        coupling = settings["edge_decay_mm"] if stented else 0.0
        return deformation.SpanField(positions, model.annulus.theta_rad, np.array(displacements), coupling)

    free = span(free_s, False)
    held = [span(s, True) for _, _, s in spans]
    return deformation.LumenDeformation(free, held, settings["edge_decay_mm"]), records, free_s
