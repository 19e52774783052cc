"""Does the steps of a procedure in the three-dimensional solid.

treatment.procedure does the same steps in one slice.
"""

import sys

import numpy as np

from common.errors import InputError

from ..slices import slices
from ..solid import tissue
from ..treatment.procedure import transfer_to_stent, deflate
from .mesh import Tube
from .model import TubeModel


def enclosed_area(a_mm, b_mm):
    """Areas (n,) in mm2 of n smooth closed curves. a_mm, b_mm (n, m): coordinates at m evenly spaced parameters.

    Derivatives along the curves are spectral (by FFT).
    """
    wave = 1j * np.fft.rfftfreq(a_mm.shape[1], 1 / a_mm.shape[1])
    slope_a, slope_b = (np.fft.irfft(wave * np.fft.rfft(v, axis=1), a_mm.shape[1], axis=1) for v in (a_mm, b_mm))
    return np.pi * np.mean(a_mm * slope_b - b_mm * slope_a, axis=1)


def station_positions(breaks_mm, element_mm):
    """Arc lengths of corners and middles of elements of about element_mm, with a corner at each of breaks_mm."""
    found = [np.array([breaks_mm[0]])]
    for a, b in zip(breaks_mm[:-1], breaks_mm[1:]):
        count = 2 * max(int(np.ceil((b - a) / element_mm)), 1)
        found.append(np.linspace(a, b, count + 1)[1:])
    return np.concatenate(found)


class TreatedTube:
    """The stretch of a Patient that the steps of a procedure reach, as a solid.

    `run` does the steps; `area_profile` then gives the result. mesh: (elements round the lumen, elements through the
    wall, element length in mm). Raises InputError unless the steps have exactly one stented stretch.
    """

    radial_support = False  # as TubeModel takes it
    least_margin_mm = 0.0  # the solid reaches at least as far beyond the balloons, but not beyond the vessel

    def __init__(self, patient, steps, settings, mesh):
        around, through, element_mm = mesh
        self.branch, self.steps, self.settings = patient.branch, steps, settings
        self.wall_mm = patient.wall_mm
        axis = self.branch.axis
        margin = max(settings["margin_mm"], self.least_margin_mm)
        unstented_s, stented = slices.slice_positions(axis.length_mm, steps, settings["slice_spacing_mm"], margin)
        if len(stented) != 1:
            raise InputError(
                "the solid in three dimensions takes one stented stretch",
                "procedure",
                f"{len(stented)} stretches",
                "a plan with one stent, or stents that overlap",
            )
        self.stented_span = stented[0][:2]
        station_s = station_positions([unstented_s[0], *self.stented_span, unstented_s[-1]], element_mm)
        theta = np.pi * np.arange(2 * around) / around
        inner, outer = tissue.inner_outer_radii(self.branch, patient.wall_mm, station_s[:, None], theta[None])
        self.tube = Tube(axis, station_s, inner, outer, through)

        def material(s, theta, radius):
            return tissue.material_constants(self.branch, s, theta, radius)

        self.model = TubeModel(self.tube, axis, material, settings, self.radial_support)
        self.model.set_loads({"stent_start": self.stented_span[0], "stent_end": self.stented_span[1]})
        self._balloon_stations = np.full(len(station_s), True)  # stations along the present balloon

    def run(self):
        """Does all steps of the procedure. Raises ComputationError if a load step does not converge."""
        stent_radius = np.zeros(len(self.tube.station_s_mm))
        inside = (self.tube.station_s_mm > self.stented_span[0] - 1e-6) & (
            self.tube.station_s_mm < self.stented_span[1] + 1e-6
        )
        stent, model = None, self.model
        for step in self.steps:
            stent = step.stent or stent
            self._inflate(model, step, stent)
            if stent:
                reached = np.minimum(
                    np.sqrt(self.area_profile()[1] / np.pi), step.balloon.radius_at(self.tube.station_s_mm)
                )
                stent_radius = np.where(inside, np.maximum(stent_radius, stent.recoil_share * reached), 0.0)
                model.set_stent_radius(_extend_beyond_stent(stent_radius, inside))
                model.set_loads(
                    {"stent_stiffness": self.settings["stent_stiffness_mpa_per_mm"], "stent_cap": stent.cap_mpa}
                )
                transfer_to_stent(model, step.name)
            else:
                deflate(model, self._least_radius_mm, self.settings["radius_step_mm"], step.name)
            self._print_progress(step.name, "deflated")

    def _inflate(self, model, step, stent):
        """Inflates the step's balloon, inside the Stent `stent` or without one (None)."""
        balloon, radius = step.balloon, step.free_radius(step.balloon.radius_mm, stent)
        self._balloon_stations = np.abs(self.tube.station_s_mm - balloon.centre_s_mm) < 0.5 * balloon.length_mm
        start = max(self._least_radius_mm() - 0.05, 0.0)
        if radius <= start:
            return
        law = {"balloon_stiffness": balloon.stiffness_mpa_per_mm, "balloon_cap": step.cap_mpa(start, stent)}
        places = {
            "balloon_centre": balloon.centre_s_mm,
            "balloon_half_length": 0.5 * balloon.length_mm,
            "balloon_shoulder": balloon.shoulder_mm,
        }
        model.set_loads({"balloon_radius": start, "balloon_share": 1.0, **law, **places})
        count = max(int(np.ceil((radius - start) / self.settings["radius_step_mm"])), 1)
        for value in np.linspace(start, radius, count + 1)[1:]:
            cap = step.cap_mpa(self._least_radius_mm(), stent)
            model.advance({"balloon_radius": float(value), "balloon_cap": cap}, step.name)
            self._print_progress(step.name, f"balloon {value:.3f} mm")

    def _print_progress(self, step, what):
        area = self.area_profile()[1].min()
        print(f"{step}: {what}, smallest area {area:.3f} mm2, {self.model.iterations} iterations", file=sys.stderr)

    def lumen_positions(self):
        """Positions (stations, 2 around, 3) of the lumen's nodes along their section's tangent, normal and binormal."""
        nodes = self.tube.lumen_nodes()
        s = self.tube.station_s_mm
        moved = (self.tube.points_mm + self.model.displacement())[nodes] - self.branch.axis.point(s)[:, None]
        frame = np.stack(self.branch.axis.frame(s), axis=1)
        return np.einsum("skj,smj->smk", frame, moved)

    def lumen_centres(self):
        """Centroids (stations, 3) in mm of the areas in the lumen's sections, in the frame of `lumen_positions`."""
        moved = self.lumen_positions()
        following = np.roll(moved, -1, axis=1)
        twice = moved[..., 1] * following[..., 2] - following[..., 1] * moved[..., 2]
        return ((moved + following) * twice[..., None]).sum(axis=1) / (3 * twice.sum(axis=1))[:, None]

    def _least_radius_mm(self):
        """Least distance (mm) of the lumen from the axis along the present balloon."""
        return float(np.linalg.norm(self.lumen_positions()[self._balloon_stations][..., 1:], axis=2).min())

    def area_profile(self):
        """(arc lengths (stations,) mm, areas (stations,) mm2) of the lumen at the moved stations."""
        moved = self.lumen_positions()
        return self.tube.station_s_mm + moved[..., 0].mean(axis=1), enclosed_area(moved[..., 1], moved[..., 2])


def _extend_beyond_stent(held, inside):
    """The radii `held` (stations,), with those outside the stent replaced by the nearest one inside it.

    The stent holds nothing outside its ends. The values there only serve the interpolation between its last station and
    the next one.
    """
    at = np.flatnonzero(inside)
    return held[np.clip(np.arange(len(held)), at[0], at[-1])]
