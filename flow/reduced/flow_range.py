"""Range of FFR over plausible hyperaemic flows, and outlet resistances for a measured inflow, both by the 1D network.

A loss is 1 - FFR at the probe `distal`. The network is calibrated on the answer of the solve: its loss at another flow
is multiplied by the ratio of the answer's loss to the network's, both at the planned flow.
"""

import copy

import numpy as np
from scipy.optimize import brentq

from common.errors import InputError
from flow.physics.units import M3_PER_S_PER_ML_PER_MIN, M_PER_MM, PA_PER_MMHG

# Least loss (1 - FFR) of the network for which losses are compared by their ratio. A ratio of smaller losses would be
# noise, so their difference is used.
LEAST_LOSS = 1e-3
# Plausible variations round a measured inflow: (name, flow over the measured one, mmHg added to MAP, exponent of the
# diameters in the flow split, None for the exponent of the settings). Repeated measurements of a coronary flow differ
# by about a tenth, and a cuff may be off by 10 mmHg. Exponent 2 splits by area, 3 by Murray's law. Chosen, not fitted.
INFLOW_VARIATIONS = (
    ("measured flow -10 %", 0.9, 0.0, None),
    ("measured flow +10 %", 1.1, 0.0, None),
    ("pressure -10 mmHg", 1.0, -10.0, None),
    ("pressure +10 mmHg", 1.0, 10.0, None),
    ("split by diameter^2", 1.0, 0.0, 2.0),
    ("split by diameter^3", 1.0, 0.0, 3.0),
)
LARGEST_DIVISOR = 50.0  # outlet resistances are divided by at most this factor to let a measured inflow pass


def scale_flow(document, factor):
    """Copy of the boundary values `document`: planned flows times `factor`, resistances divided by it."""
    other = copy.deepcopy(document)
    for outlet in other["outlets"]:
        outlet["flow_m3_per_s"] *= factor
        outlet["resistance_pa_s_per_m3"] /= factor
    other["q_hyperaemic_m3_per_s"] *= factor
    return other


def apply_variation(document, variation):
    """Copy of the boundary values `document` for the entry `variation` of plausible_flows.

    The entry holds a factor on the planned flow, or MAP and resistances of its own.
    """
    if "resistances_pa_s_per_m3" not in variation:
        return scale_flow(document, variation["factor"])
    other = copy.deepcopy(document) | {"map_pa": variation["map_pa"]}
    for outlet, resistance in zip(other["outlets"], variation["resistances_pa_s_per_m3"]):
        outlet["resistance_pa_s_per_m3"] = resistance
    return other


def plausible_around_inflow(document, network_at, exponent):
    """Entry plausible_flows of boundary.json for a measured inflow: [{what, map_pa, resistances_pa_s_per_m3}].

    document: boundary values before `fit_resistances`. network_at(document) -> Network of the vessel before the
    procedure. exponent: exponent of the diameters in the flow split. INFLOW_VARIATIONS varies the inflow, the aortic
    pressure and the split. The left ventricular mass is not varied, since it serves only to estimate the flow. A flow
    that the vessel does not let pass is left out.
    """
    found = []
    for what, factor, pressure, power in INFLOW_VARIATIONS:
        if power is not None and (len(document["outlets"]) == 1 or power == exponent):
            continue
        other = scale_flow(document, factor)
        other["map_pa"] += pressure * PA_PER_MMHG
        driving = (other["map_pa"] - other["venous_pressure_pa"]) / (
            document["map_pa"] - document["venous_pressure_pa"]
        )
        weights = np.array([outlet["diameter_mm"] ** (power or exponent) for outlet in other["outlets"]])
        for outlet, part in zip(other["outlets"], weights / weights.sum()):
            before = outlet["flow_m3_per_s"]
            outlet["flow_m3_per_s"] = float(part * other["q_hyperaemic_m3_per_s"])
            outlet["resistance_pa_s_per_m3"] *= driving * before / outlet["flow_m3_per_s"]
        try:
            other = fit_resistances(other, network_at)
        except InputError:
            continue
        resistances = [float(outlet["resistance_pa_s_per_m3"]) for outlet in other["outlets"]]
        found.append({"what": what, "map_pa": other["map_pa"], "resistances_pa_s_per_m3": resistances})
    return found


def ffr_range(answer_ffr, document, network_at, probe):
    """{low, high, at: [{what, factor, ffr}]}: FFR at the probe over the plausible flows of the boundary values.

    answer_ffr: FFR at the planned flow. network_at(document) -> flow.reduced.network.Network; probe: (branch, s_mm).
    None where the boundary values have no plausible flows.
    """
    flows = document.get("plausible_flows", [])
    if not flows:
        return None
    base = loss_at(network_at(document), probe)
    at = []
    for one in flows:
        loss = loss_at(network_at(apply_variation(document, one)), probe)
        lost = (1 - answer_ffr) * loss / base if base > LEAST_LOSS else 1 - answer_ffr + loss - base
        shown = {key: one[key] for key in ("what", "factor") if key in one}
        at.append(shown | {"ffr": float(np.clip(1 - lost, 0, 1))})
    values = [answer_ffr, *(entry["ffr"] for entry in at)]
    return {"low": float(min(values)), "high": float(max(values)), "at": at}


def loss_at(network, probe):
    """1 - FFR by a flow.reduced.network.Network at a probe (branch, s_mm)."""
    s, pressure = network.pressures(network.solve())[probe[0]]
    return 1 - float(np.interp(probe[1] * M_PER_MM, s, pressure)) / network.document["map_pa"]


def fit_resistances(document, network_at):
    """Copy of the boundary values with the resistances at which the network's inflow is the planned flow.

    The planned flow was measured in this vessel, whose narrowings lose pressure too. So the resistances must be lower
    than R_i = (MAP - P_v) / Q_i. network_at(document) -> Network of the vessel. Raises InputError where the inflow is
    too small even with resistances LARGEST_DIVISOR times lower.
    """
    wanted = document["q_hyperaemic_m3_per_s"]

    def lacking(log_factor):
        return float(np.sum(network_at(scale_flow(document, np.exp(log_factor))).solve())) / wanted - 1

    if lacking(np.log(LARGEST_DIVISOR)) < 0:
        most = (1 + lacking(np.log(LARGEST_DIVISOR))) * wanted / M3_PER_S_PER_ML_PER_MIN
        remedy = "is the flow of this vessel, before the intervention, and in mL/min?"
        where = "patient.hyperaemic_inflow_ml_per_min"
        raise InputError("the vessel does not let the measured flow pass", where, f"at most {most:.0f} mL/min", remedy)
    factor = np.exp(brentq(lacking, np.log(0.5), np.log(LARGEST_DIVISOR), xtol=1e-6))
    found = scale_flow(document, factor)
    for outlet, planned in zip(found["outlets"], document["outlets"]):
        outlet["flow_m3_per_s"] = planned["flow_m3_per_s"]
    return found | {"q_hyperaemic_m3_per_s": wanted}
