"""FFR of a lumen by the 1D network, calibrated on the 3D answers of the same patient before and after the procedure.

A loss is 1 - FFR at the probe `distal`. The network leaves out bends and developing velocity profiles, so its loss in a
lumen is converted to a loss of the 3D model. For losses up to that after the planned procedure the two are
proportional. From there to the loss before the procedure the conversion is interpolated linearly. For larger losses it
is proportional again. This works because the network's error is similar in similar lumens.

The error is the largest difference to the 3D answers in the patient's other lumens after a procedure, which the
calibration does not use. It is at least the largest error estimate of all 3D answers.
"""

import dataclasses

import numpy as np

from common.errors import InputError
from flow.geometry.centreline import Branch
from flow.reduced import flow_range, network
from whatif.case import BEFORE, PLANNED

OTHERS = ("reference", "rc", "rc_stent", "ct", "ct_vci", "ct_rc", "post")
PROBE = "distal"


def network_loss(lumen, document, expansion_loss):
    """1 - FFR at the probe `distal` by the network. lumen: (anatomy.json, sections); document: of boundary.json."""
    anatomy, sections = lumen
    probe = next(one for one in document["probes"] if one["name"] == PROBE)
    place = axis_of(sections, probe["branch"]).project(np.array(probe["point_mm"]))[0]
    model = network.Network(anatomy, sections, document, expansion_loss)
    return flow_range.loss_at(model, (probe["branch"], place))


def axis_of(sections, branch):
    """The flow.geometry.centreline.Branch through a branch's sections."""
    rows = sections[sections["branch"] == branch].sort_values("s_mm")
    points = rows[["x_mm", "y_mm", "z_mm"]].to_numpy(float)
    return Branch(branch, 0, points, rows["s_mm"].to_numpy(float), np.sqrt(rows["area_mm2"].to_numpy(float) / np.pi))


@dataclasses.dataclass(frozen=True)
class Calibration:
    """Points for converting a loss of the network to a loss of the 3D model, and the error of the FFR so found.

    model, solved: losses (1 - FFR) of the network and of the 3D model in the same lumens, from 0 upwards.
    """

    model: np.ndarray
    solved: np.ndarray
    error: float
    states: tuple  # states whose 3D answers gave the error

    def ffr(self, loss):
        """FFR, at least 0, of a lumen in which the network has the given loss."""
        last = self.solved[-1] * loss / self.model[-1]
        within = float(np.interp(loss, self.model, self.solved))
        return max(0.0, 1.0 - (within if loss <= self.model[-1] else float(last)))


def points_of(planned, before):
    """(model, solved) of a Calibration.

    planned, before: (loss of the network, loss of the 3D model) after the planned procedure and before it. A point is
    left out if one of its losses does not exceed that of the last point: a lesion without pressure loss calibrates
    nothing. Raises InputError if neither point is left.
    """
    points = [(0.0, 0.0)]
    for point in (planned, before):
        if point[0] > points[-1][0] and point[1] > points[-1][1]:
            points.append(point)
    if len(points) == 1:
        raise InputError("no loss of pressure to calibrate on", "ffr.json of pre and vci", planned, "nothing to vary")
    return (np.array(column) for column in zip(*points))


def calibrate(case, states=OTHERS):
    """Calibration of a Case on its states `pre` and `vci`. The error is measured in those of `states` in OTHERS.

    Raises InputError if a file is missing, or if neither `pre` nor `vci` has a pressure loss.
    """
    wanted = [BEFORE, PLANNED, *(state for state in states if state in OTHERS)]
    answers = {state: case.answer(state) for state in wanted}
    losses = {
        state: (
            network_loss(case.lumen(case.anatomy(state)), case.boundary, case.flow.expansion_loss),
            1 - answer["ffr"],
        )
        for state, answer in answers.items()
    }
    model, solved = points_of(losses[PLANNED], losses[BEFORE])
    found = Calibration(model, solved, 0.0, ())
    others = tuple(state for state in losses if state in OTHERS)
    missed = [abs(found.ffr(losses[state][0]) - answers[state]["ffr"]) for state in others]
    own = [estimate_of(answer) for answer in answers.values()]
    return Calibration(model, solved, max(missed + [value for value in own if value is not None], default=0.0), others)


def estimate_of(answer):
    """The error estimate of an ffr.json; None if the model gives none."""
    return (answer.get("error_estimate") or {}).get("ffr")
