"""Uncertain inputs of the flow, each with its range, and boundary values for any choice of inputs.

Ventricular mass varies by a fifth and hyperaemia by one standard deviation, as in flow.inputs.hyperaemia. A blood
pressure by cuff may be wrong by 10 mmHg. The exponent by which flow is split goes from 2 (by area) to 3 (Murray's law).
An outlet's diameter varies by a tenth, about a voxel of CT. If the flow was measured, it varies by a tenth, and mass,
hyperaemia and territory do not count.
"""

import copy
import dataclasses

from flow.inputs import boundary, hyperaemia
from flow.reduced import flow_range, network

TERRITORIES = ("lad", "lcx", "rca")
PER_CENT = 100


@dataclasses.dataclass(frozen=True)
class Input:
    """An uncertain input. low, planned, high: its values in `unit`; label: its name in words.

    scale: `linear` or `log`, the scale on which samples are uniform.
    """

    name: str
    label: str
    low: float
    planned: float
    high: float
    unit: str
    scale: str = "linear"


def uncertain_inputs(patient, settings, outlets):
    """[Input] of a patient's flow. settings: section `flow` of the settings; outlets: number of outlets."""
    inputs = [Input("blood_pressure", "blood pressure", -10.0, 0.0, 10.0, "mmHg")]
    if patient.get("hyperaemic_inflow_ml_per_min") is not None:
        inputs.append(Input("flow", "measured flow", -10.0, 0.0, 10.0, "%"))
    else:
        if patient.get("cardiac_output_l_per_min") is None:
            inputs.append(
                Input(
                    "mass",
                    "left ventricular mass",
                    -PER_CENT * hyperaemia.MASS_ERROR,
                    0.0,
                    PER_CENT * hyperaemia.MASS_ERROR,
                    "%",
                )
            )
        spread = PER_CENT * hyperaemia.FLOW_PER_GRAM_SD / hyperaemia.FLOW_PER_GRAM
        inputs.append(Input("hyperaemia", "response to adenosine, 1 SD", -spread, 0.0, spread, "%"))
        inputs += _territory_input(patient, settings)
    if outlets > 1:
        inputs.append(Input("split_exponent", "exponent of the split", 2.0, settings.split_exponent, 3.0, ""))
        inputs.append(Input("outlet_diameter", "main outlet's diameter", -10.0, 0.0, 10.0, "%"))
    return inputs


def _territory_input(patient, settings):
    """[Input] of the change of flow in per cent, by the territory that the vessel may feed; or [].

    It goes from the smallest to the largest plausible change.
    """
    changes = [
        PER_CENT * (entry["factor"] - 1)
        for entry in hyperaemia.plausible_flows(patient, settings.hyperaemia_fraction)
        if entry["what"].startswith("territory") and entry["what"].split()[1] in (*TERRITORIES, "-1", "+1")
    ]
    return (
        [Input("territory", "territory that the vessel feeds", min(changes), 0.0, max(changes), "%")] if changes else []
    )


def boundary_with_inputs(case, patient, measured, values):
    """The content of boundary.json of a case (whatif.case.Case) with some inputs at other values.

    patient, measured: as from whatif.case.read_patient. values: {name of an Input: value in its unit}; inputs that are
    not named stay as planned.
    """
    patient, settings, anatomy = (
        copy.deepcopy(patient),
        copy.copy(case.flow_settings),
        copy.deepcopy(case.anatomy_before),
    )
    for key in ("sbp_mmhg", "dbp_mmhg"):
        patient[key] += values.get("blood_pressure", 0.0)
    if "mass" in values:
        patient["lvm_g"] *= 1 + values["mass"] / PER_CENT
    if "flow" in values:
        patient["hyperaemic_inflow_ml_per_min"] *= 1 + values["flow"] / PER_CENT
    settings.split_exponent = values.get("split_exponent", settings.split_exponent)
    main_outlet = next(end for end in anatomy["ends"] if end["kind"] == "outlet")
    main_outlet["diameter_mm"] *= 1 + values.get("outlet_diameter", 0.0) / PER_CENT
    document = boundary.make(anatomy, case.centrelines, patient, settings, measured)
    if patient.get("hyperaemic_inflow_ml_per_min") is not None:
        lumen = case.lumen(case.anatomy())
        return flow_range.fit_resistances(document, lambda d: network.Network(*lumen, d, settings.expansion_loss))
    factor = 1.0
    for name in ("hyperaemia", "territory"):
        factor *= 1 + values.get(name, 0.0) / PER_CENT
    return flow_range.scale_flow(document, factor)
