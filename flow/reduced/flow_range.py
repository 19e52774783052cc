"""FFR's range over the flows that are plausible, and resistances for a measured inflow, by the 1D network.

The network is calibrated on the answer: its loss of FFR at the probe `distal` at another flow is multiplied by what the
answer's loss is over the network's at the planned flow.
"""

import copy

import numpy as np
from scipy.optimize import brentq

from common.errors import InputError

LEAST_LOSS = 1e-3  # of FFR: below it losses are compared by difference, their ratio says nothing
FASTEST = 50.0  # times the planned flow up to which a measured one is looked for


def scaled(document, factor):
    """Boundary values with `factor` times the planned flow: resistances divided by it."""
    other = copy.deepcopy(document)
    for outlet in other["outlets"]:
        outlet["flow_m3_per_s"] *= factor
        outlet["resistance_pa_s_per_m3"] /= factor
    other["q_hyperaemic_m3_per_s"] *= factor
    return other


def of_answer(answer_ffr, document, network_at, probe):
    """{low, high, at: [{what, factor, ffr}]} of FFR at the probe, or None where boundary values name no other flow.

    answer_ffr: of the planned flow. network_at(document) -> flow.reduced.network.Network; probe: (branch, s_mm).
    """
    flows = document.get("plausible_flows", [])
    if not flows or any(outlet.get("pressure_pa") is not None for outlet in document["outlets"]):
        return None
    base = _loss(network_at(document), probe)
    at = []
    for one in flows:
        loss = _loss(network_at(scaled(document, one["factor"])), probe)
        lost = (1 - answer_ffr) * loss / base if base > LEAST_LOSS else 1 - answer_ffr + loss - base
        at.append(one | {"ffr": float(np.clip(1 - lost, 0, 1))})
    values = [answer_ffr, *(entry["ffr"] for entry in at)]
    return {"low": float(min(values)), "high": float(max(values)), "at": at}


def _loss(network, probe):
    flows = network.solve()
    s, pressure = network.pressures(flows, network.inlet_pa)[probe[0]]
    return 1 - float(np.interp(probe[1] * 1e-3, s, pressure)) / network.inlet_pa


def with_inflow(document, network_at):
    """Boundary values whose resistances let the planned flow, measured in this narrowed vessel, pass the network.

    Raises InputError where the network's narrowing does not let so much pass at any resistance.
    """
    wanted = document["q_hyperaemic_m3_per_s"]

    def lacking(log_factor):
        return float(np.sum(network_at(scaled(document, np.exp(log_factor))).solve())) / wanted - 1

    if lacking(np.log(FASTEST)) < 0:
        most = (1 + lacking(np.log(FASTEST))) * wanted * 6e7
        remedy = "is the flow of this vessel, before the intervention, and in mL/min?"
        where = "patient.hyperaemic_inflow_ml_per_min"
        raise InputError("the vessel does not let the measured flow pass", where, f"at most {most:.0f} mL/min", remedy)
    factor = np.exp(brentq(lacking, np.log(0.5), np.log(FASTEST), xtol=1e-6))
    found = scaled(document, factor)
    for outlet, planned in zip(found["outlets"], document["outlets"]):
        outlet["flow_m3_per_s"] = planned["flow_m3_per_s"]
    return found | {"q_hyperaemic_m3_per_s": wanted}
