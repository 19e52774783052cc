"""The lumen after the procedure from all slices of a branch, and the straightening of the vessel."""

import sys
from dataclasses import dataclass

import numpy as np

from ..straightening import beams, stent_in_vessel
from ..surface import deformation
from . import error_estimate, sideways, slices

MOST_REFINEMENTS = 3  # slices are added in at most this many rounds
LEAST_SPACING_MM = 0.09  # no slice is added nearer than this to another


@dataclass(frozen=True)
class SolvedLumen:
    """The result of all slices.

    field: deformation of the lumen. records: entries (dict) of the slices in reference.json. straightening: by the
    beams, from `sections` and the support foundation_n_per_mm2.
    """

    field: deformation.LumenDeformation
    records: list
    straightening: stent_in_vessel.Straightening
    sections: stent_in_vessel.VesselSections
    foundation_n_per_mm2: float


class _TreatedSlices:
    """Evenly spaced slices after the procedure, and what they say of the vessel as a beam.

    unstented, opened: {s_mm: displacement of the lumen}, of the slices without a stent and with it. stented: {s_mm:
    (state of the model, record)}. records: those of the slices without a stent. stiffness: {s_mm: (E I, shear
    stiffness)}. laws: [(s_mm, SidewaysLaw)].
    """

    def __init__(self, model, patient, steps, settings, unstented_s, stented_s):
        self.unstented, self.opened, self.stented = {}, {}, {}
        self.records, self.stiffness, self.laws = [], {}, []
        print(f"{len(unstented_s)} slices on {patient.branch.name}, {len(stented_s)} stented", file=sys.stderr)
        for s in map(float, unstented_s):
            self.unstented[s], record = slices.solve_slice(model, patient, steps, s, settings, False)
            self.records.append(record)
            self.stiffness[s] = model.beam_stiffness()
            print_progress(record)
        for s in map(float, stented_s):
            self.opened[s], record = slices.solve_slice(model, patient, steps, s, settings, True)
            self.stented[s] = model.state(), record
            self.stiffness[s] = model.beam_stiffness()
            print_progress(record)
            direction = sideways.bend_direction(patient.branch.axis, s)
            self.laws.append((s, sideways.sideways_law(model, direction, slices.where(patient, s))))

    def sections(self):
        """The VesselSections for the beams."""
        s = np.array(sorted(self.stiffness))
        return stent_in_vessel.VesselSections(s, *np.array([self.stiffness[x] for x in s]).T, self.laws)


def solve_lumen(model, patient, steps, settings):
    """SolvedLumen of the branch. Raises ComputationError.

    Evenly spaced slices go through the procedure. They say how the vessel bends, and how its sections yield to a stent
    that presses sideways. With this the beams find the place of stent and vessel. Then the stented slices are pressed
    by the stent as it lies. A stented span gets more slices where evenly spaced ones do not resolve the area. This is
    judged by `error_estimate.leave_one_out_change`.
    """
    axis = patient.branch.axis
    unstented_s, spans = slices.slice_positions(
        axis.length_mm, steps, settings["slice_spacing_mm"], settings["margin_mm"]
    )
    stented_s = [s for _, _, positions in spans for s in positions]
    treated = _TreatedSlices(model, patient, steps, settings, unstented_s, stented_s)
    sections, records = treated.sections(), list(treated.records)
    middle = 0.5 * (unstented_s[0] + unstented_s[-1])
    foundation = beams.foundation_n_per_mm2(patient.branch, patient.wall_mm, middle, settings)
    stents = [step.stent for step in steps if step.stent]
    straightening = stent_in_vessel.straighten(axis, stents, sections, foundation)

    def pressed_slice(s):
        pressed = straightening.pressed_at(axis, s)
        if s in treated.stented:
            state, record = treated.stented[s]
            patient.place(model, s)
            model.restore(state)
            moved, record = slices.press_slice(model, patient, record, pressed)
        else:
            moved, record = slices.solve_slice(model, patient, steps, s, settings, True, pressed)
            print_progress(record)
        records.append(record)
        return moved, record["area_mm2"]

    theta, decay = model.annulus.theta_rad, settings["edge_decay_mm"]

    def span_field(positions):
        found = refined(positions, pressed_slice, settings)
        moved = np.array([moved for moved, _ in found.values()])
        return deformation.SpanField(list(found), theta, moved, decay)

    def field_of(displacements):
        return deformation.SpanField(list(displacements), theta, np.array(list(displacements.values())))

    field = deformation.LumenDeformation(
        field_of({s: treated.unstented[s] for s in map(float, unstented_s)}),
        [span_field(positions) for _, _, positions in spans],
        decay,
        [field_of({s: treated.opened[s] for s in map(float, positions[[0, -1]])}) for _, _, positions in spans],
        lambda s_mm: straightening.in_section(axis, s_mm)[0],
    )
    return SolvedLumen(field, records, straightening, sections, foundation)


def refined(positions, solve, settings):
    """{s_mm: solve(s_mm)}, ascending, at positions (n,) and where more slices are needed to resolve the area.

    solve(s_mm): function that returns (displacement, area in mm2).
    """
    found = {s: solve(s) for s in map(float, positions)}
    for _ in range(MOST_REFINEMENTS):
        s = np.array(sorted(found))
        area = np.array([found[x][1] for x in s])
        error = error_estimate.leave_one_out_change(s, area, settings["edge_decay_mm"])
        added = midpoints(s, error > settings["slice_tolerance_percent"])
        if not len(added):
            break
        found.update({x: solve(x) for x in map(float, added)})
    return dict(sorted(found.items()))


def print_progress(record):
    """Says on stderr what became of a slice."""
    print(
        f"slice at s {record['s_mm']:.2f} mm: radius {record['radius_before_mm']:.3f} -> "
        f"{np.sqrt(record['area_mm2'] / np.pi):.3f} mm, {record['iterations']} iterations",
        file=sys.stderr,
    )


def midpoints(s_mm, coarse):
    """Arc lengths (k,) of new slices, halfway from each slice with `coarse` (n,) true to its neighbours.

    A new slice is left out if it would lie within LEAST_SPACING_MM of a neighbour.
    """
    intervals = np.flatnonzero(coarse[1:] | coarse[:-1])
    intervals = intervals[np.diff(s_mm)[intervals] > 2 * LEAST_SPACING_MM]
    return 0.5 * (s_mm[intervals] + s_mm[intervals + 1])
