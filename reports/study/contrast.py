"""contrast.csv: the errors of VCI and of radius correction against the lumen after PCI, case by case."""

import math

import pandas as pd

from common.patient.states import PREDICTED_FROM_PRE, TRUE_STATES
from reports.inputs.reading import number
from reports.study.agreement import QUANTITIES, UNITS
from reports.study.nearer import flow_error

METHODS = PREDICTED_FROM_PRE  # columns of the table: virtual PCI and the radius corrections
METHOD_NAMES = {"vci": "VCI", "rc": "radius correction"}
UNDECIDED, UNKNOWN = "within the flow's error", "the flow's error is not known"
# The error of this quantity is the root mean square of the difference in area along the stent. In a mean, differences
# of both signs would cancel.
AREA_PROFILE = "area_profile"
COLUMNS = ["case", "quantity", "unit", "truth", "value"]
COLUMNS += [f"error_{method}" for method in METHODS] + ["nearer", "nearer_by"]


def contrast_table(documents):
    """DataFrame of contrast.csv from the metrics documents, in their order: a row for each case and quantity.

    value: the quantity in the lumen after PCI. error_*: predicted minus this value, empty if the case has no such
    prediction. The area profile has no value; its error is the root mean square over the stations. nearer_by: the
    difference between the absolute errors of VCI and of radius correction.
    """
    rows = []
    for document in documents:
        truth = next((state for state in TRUE_STATES if state in document["states"]), None)
        if truth is None or "vci" not in document["states"]:
            continue
        for quantity in ("ffr", "mean_area", "minimum_area", AREA_PROFILE, "mean_curvature"):
            row = contrast_row(document, quantity, truth)
            if row["error_vci"] is not None:
                rows.append({"case": document["case"], "quantity": quantity, "truth": truth, **row})
    return pd.DataFrame(rows, columns=COLUMNS)


def contrast_row(document, quantity, truth):
    """A row of contrast.csv (dict) for one case and quantity: the columns from `unit` on."""
    if quantity == AREA_PROFILE:
        errors = {method: profile_error(document, method, truth) for method in METHODS}
        row = {"unit": UNITS["mean_area"], "value": None}
    else:
        value = state_value(document, quantity, truth)
        predicted = {method: state_value(document, quantity, method) for method in METHODS}
        errors = {m: None if None in (value, found) else found - value for m, found in predicted.items()}
        row = {"unit": UNITS[quantity], "value": value}
    row |= {f"error_{method}": error for method, error in errors.items()}
    computed = [state for state in ("vci", "rc", truth) if document["states"].get(state, {}).get("ffr")]
    return row | nearer_method(errors, flow_error(document, computed) if quantity == "ffr" and computed else 0.0)


def state_value(document, quantity, state):
    """A quantity of a state; None if the case lacks the state. FFR is also None if the state has no flow."""
    entry = document["states"].get(state)
    if entry is None or (quantity == "ffr" and entry["ffr"] is None):
        return None
    return number(entry, QUANTITIES[quantity], f"metrics of {document['case']}, {state}")


def profile_error(document, method, truth):
    """Root mean square over the stations of predicted minus true area, mm2; None without this prediction."""
    found = document["differences"].get(f"{method}_minus_{truth}")
    return None if found is None else found["area_mm2"]["rmse"]


def nearer_method(errors, noise):
    """{nearer, nearer_by} of VCI and radius correction. errors: {method: error}. Both are None if an error is missing.

    noise: numerical error of the quantity; infinite if it is not known, as for a reduced model of the flow. If the
    absolute errors differ by no more than `noise`, neither method counts as nearer.
    """
    if errors["vci"] is None or errors["rc"] is None:
        return {"nearer": None, "nearer_by": None}
    advantage_vci = abs(errors["rc"]) - abs(errors["vci"])
    nearer = METHOD_NAMES["vci" if advantage_vci > 0.0 else "rc"]
    if abs(advantage_vci) <= noise:
        nearer = UNDECIDED if math.isfinite(noise) else UNKNOWN
    return {"nearer": nearer, "nearer_by": abs(advantage_vci)}
