"""FFR of a lumen by the 1D network, calibrated on the 3D answers of the same patient before and after the procedure.

Losses are of FFR at the probe `distal`, 1 - FFR. What the network loses in a lumen is carried to what the 3D model
would lose: in proportion up to the planned procedure's, linearly from there to the loss before it, in proportion
beyond. The network misses bends and developing profiles; it misses alike in lumens that are alike.

The error is what the calibration misses in the patient's other lumens after a procedure, those with a 3D answer that it
was not made of; at least the largest error estimate of all 3D answers.
"""

import dataclasses

import numpy as np

from common.errors import InputError
from flow.reduced import network
from whatif.case import BEFORE, PLANNED

OTHERS = ("reference", "rc", "rc_stent", "ct", "ct_vci", "ct_rc", "post")
PROBE = "distal"


def network_loss(lumen, document, expansion_loss):
    """1 - FFR at the probe `distal` by the network. lumen: (anatomy.json, sections); document: of boundary.json."""
    anatomy, sections = lumen
    model = network.Network(anatomy, sections, document, expansion_loss)
    probe = next(one for one in document["probes"] if one["name"] == PROBE)
    flows = model.solve()
    s, pressure = model.pressures(flows, model.inlet_pa)[probe["branch"]]
    return 1 - float(np.interp(_nearest(sections, probe) * 1e-3, s, pressure)) / model.inlet_pa


def _nearest(sections, probe):
    """Arc length in mm of the section of the probe's branch that is nearest to it, between sections by projection."""
    rows = sections[sections["branch"] == probe["branch"]].sort_values("s_mm")
    points, s = rows[["x_mm", "y_mm", "z_mm"]].to_numpy(float), rows["s_mm"].to_numpy()
    start, span = points[:-1], np.diff(points, axis=0)
    share = np.einsum("ij,ij->i", np.array(probe["point_mm"]) - start, span) / np.einsum("ij,ij->i", span, span)
    share = np.clip(share, 0.0, 1.0)
    apart = np.linalg.norm(start + share[:, None] * span - probe["point_mm"], axis=1)
    k = int(apart.argmin())
    return float(s[k] + share[k] * (s[k + 1] - s[k]))


@dataclasses.dataclass(frozen=True)
class Calibration:
    """model, solved: losses of the network and of the 3D model, ascending, (0, 0) first; error: in FFR."""

    model: np.ndarray
    solved: np.ndarray
    error: float
    states: tuple  # of the 3D answers that the error was measured in

    def ffr(self, loss):
        """FFR for the network's loss; 0 at least."""
        last = self.solved[-1] * loss / self.model[-1]
        within = float(np.interp(loss, self.model, self.solved))
        return max(0.0, 1.0 - (within if loss <= self.model[-1] else float(last)))


def points_of(planned, before):
    """(model, solved) of a Calibration from (network's, 3D) losses after the planned procedure and before it.

    A point that is no further than the one before it is left out: a lesion that took no pressure tells nothing.
    """
    points = [(0.0, 0.0)]
    for point in (planned, before):
        if point[0] > points[-1][0] and point[1] > points[-1][1]:
            points.append(point)
    if len(points) == 1:
        raise InputError("no loss of pressure to calibrate on", "ffr.json of pre and vci", planned, "nothing to vary")
    return (np.array(column) for column in zip(*points))


def calibrate(case, states=OTHERS):
    """Calibration of a Case on `pre` and `vci`; its error by the other ones of `states`. Raises InputError."""
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
    """The error estimate of an ffr.json; None where the model gives none."""
    return (answer.get("error_estimate") or {}).get("ffr")
