"""FFR of given lumens of a finished case by the calibrated network, for example lumens of another segmentation."""

from common.errors import InputError
from whatif import calibrated
from whatif.case import PLANNED

SCHEMA = "vci-network-ffr-1"
MODEL = "1D network, calibrated"


def ffr_of_lumens(case, names, states):
    """The content of ffr.json for some lumens of a case.

    names: the lumens' folders, relative to the case's folder, each with an `anatomy/`. states: states with a 3D answer,
    in which the error is measured. The entry `at` of each lumen says where its loss lies in the calibration: up to the
    loss after the planned procedure, from there to the loss before it, or beyond. Raises InputError.
    """
    if PLANNED not in states:
        raise InputError("no planned procedure to calibrate on", "--states", " ".join(states), f"name {PLANNED} too")
    calibration, lumens = calibrated.calibrate(case, states), {}
    for name in names:
        lumen = case.lumen(case.folder / name / "anatomy")
        loss = calibrated.network_loss(lumen, case.boundary, case.flow_settings.expansion_loss)
        lumens[name.rpartition("/")[2]] = {
            "ffr": calibration.ffr(loss),
            "at": calibration_range(calibration.network_losses, loss),
        }
    return {
        "schema": SCHEMA,
        "model": MODEL,
        "error": calibration.error,
        "error_from": list(calibration.states),
        "lumens": lumens,
    }


def calibration_range(network_losses, loss):
    """Says where the network's loss lies among the losses of the calibration (`network_losses`, ascending from 0)."""
    if loss > network_losses[-1]:
        return "beyond"
    return "below" if loss <= network_losses[1] else "between"
