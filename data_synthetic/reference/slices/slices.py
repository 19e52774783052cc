"""Positions of the slices, and the solution of one slice."""

import numpy as np

from ..solid import tissue
from ..treatment import procedure
from . import sideways
from .model import SliceModel


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


def solve_slice(model, patient, steps, s_mm, settings, stented, pressed=None):
    """Takes the model through the procedure at arc length s_mm: (displacement (2 around, 2) mm of the lumen, record).

    record: the slice's entry (dict) in reference.json. stented: whether stents hold at this slice. pressed: None, or
    (offset (2,) mm, force (2,) N/mm) by which the stent presses the section sideways afterwards.
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
    if pressed is None:
        return model.lumen_displacement(), record
    return press_slice(model, patient, record, pressed)


def press_slice(model, patient, record, pressed):
    """Presses the slice that `model` has solved sideways: as `solve_slice`, from the record that it has given."""
    offset, force = pressed
    moved = sideways.press(model, offset, force, where(patient, record["s_mm"]))
    return moved, record | {
        "stent_offset_mm": [round(float(part), 4) for part in offset],
        "area_mm2": float(model.lumen_area()),
        "iterations": model.iterations,
    }


def where(patient, s_mm):
    """Name of a slice, for messages."""
    return f"slice at s = {s_mm:.2f} mm of {patient.branch.name}"
