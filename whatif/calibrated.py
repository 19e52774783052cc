"""FFR of a lumen by the 1D network, calibrated on the 3D answers of the same patient before and after the procedure.

A loss is 1 - FFR at the probe `distal`. The network leaves out bends and developing velocity profiles, so its loss in a
lumen is converted to a loss of the 3D model. Two points are known: the losses of both models after the planned
procedure, and before it. Up to the first point the two losses are taken as proportional. From there to the second point
the conversion is interpolated linearly. Beyond it they are proportional again. This works because the network's error
is similar in similar lumens.

The error is the largest difference from the 3D answers in the patient's other lumens after a procedure, which the
calibration does not use. It is at least the largest error estimate of all 3D answers.
"""

import dataclasses

import numpy as np

from common.errors import InputError
from common.patient.states import STATES
from flow.geometry.centreline import Branch
from flow.reduced import flow_range, network
from whatif.case import BEFORE, PLANNED

VALIDATION_STATES = tuple(state for state in STATES if state not in (BEFORE, PLANNED))
PROBE = "distal"


def network_loss(lumen, boundary, expansion_loss):
    """1 - FFR at the probe `distal` by the network. lumen: as from Case.lumen; boundary: content of boundary.json."""
    anatomy, sections = lumen
    probe = next(one for one in boundary["probes"] if one["name"] == PROBE)
    s_mm = branch_axis(sections, probe["branch"]).project(np.array(probe["point_mm"]))[0]
    model = network.Network(anatomy, sections, boundary, expansion_loss)
    return flow_range.loss_at(model, (probe["branch"], s_mm))


def branch_axis(sections, branch):
    """The flow.geometry.centreline.Branch through the centres of a branch's sections, with their radii."""
    rows = sections[sections["branch"] == branch].sort_values("s_mm")
    points = rows[["x_mm", "y_mm", "z_mm"]].to_numpy(float)
    return Branch(branch, 0, points, rows["s_mm"].to_numpy(float), np.sqrt(rows["area_mm2"].to_numpy(float) / np.pi))


@dataclasses.dataclass(frozen=True)
class Calibration:
    """Points for converting a loss of the network to a loss of the 3D model, and the error of the resulting FFR.

    network_losses, losses_3d: losses (1 - FFR) of the network and of the 3D model in the same lumens, from 0 upwards.
    """

    network_losses: np.ndarray
    losses_3d: np.ndarray
    error: float
    states: tuple  # states whose 3D answers gave the error

    def ffr(self, loss):
        """FFR, at least 0, of a lumen in which the network has the given loss."""
        extrapolated = self.losses_3d[-1] * loss / self.network_losses[-1]
        interpolated = float(np.interp(loss, self.network_losses, self.losses_3d))
        return max(0.0, 1.0 - (interpolated if loss <= self.network_losses[-1] else float(extrapolated)))


def calibration_points(planned, before):
    """(network_losses, losses_3d) of a Calibration.

    planned, before: (loss of the network, loss of the 3D model) after the planned procedure and before it. A point is
    left out unless both of its losses exceed those of the point before: a lesion without pressure loss calibrates
    nothing. Raises InputError if neither point is left.
    """
    points = [(0.0, 0.0)]
    for point in (planned, before):
        if point[0] > points[-1][0] and point[1] > points[-1][1]:
            points.append(point)
    if len(points) == 1:
        raise InputError("no loss of pressure to calibrate on", "ffr.json of pre and vci", planned, "nothing to vary")
    return (np.array(column) for column in zip(*points))


def calibrate(case, states=VALIDATION_STATES):
    """Calibration of a Case on its states `pre` and `vci`, with the error found in further `states`.

    Only `states` that are also in VALIDATION_STATES count. Raises InputError if a file is missing, or if neither `pre`
    nor `vci` has a pressure loss.
    """
    wanted = [BEFORE, PLANNED, *(state for state in states if state in VALIDATION_STATES)]
    answers = {state: case.flow_result(state) for state in wanted}
    losses = {
        state: (
            network_loss(case.lumen(case.anatomy(state)), case.boundary, case.flow_settings.expansion_loss),
            1 - answer["ffr"],
        )
        for state, answer in answers.items()
    }
    model, solved = calibration_points(losses[PLANNED], losses[BEFORE])
    calibration = Calibration(model, solved, 0.0, ())
    others = tuple(state for state in losses if state in VALIDATION_STATES)
    deviations = [abs(calibration.ffr(losses[state][0]) - answers[state]["ffr"]) for state in others]
    estimates = [error_estimate(answer) for answer in answers.values()]
    return Calibration(
        model, solved, max(deviations + [value for value in estimates if value is not None], default=0.0), others
    )


def error_estimate(answer):
    """The error estimate of an ffr.json; None if the model gives none."""
    return (answer.get("error_estimate") or {}).get("ffr")
