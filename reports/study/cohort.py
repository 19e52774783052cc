"""cohort.csv: a row for each case, with patient, lesion, procedure, deployment and the values of each state."""

import pandas as pd

from common.patient.states import STATES

PATIENT_KEYS = ("lvm_g", "sbp_mmhg", "dbp_mmhg", "map_pa", "q_hyperaemic_ml_per_min")
LESION_KEYS = ("branch", "diameter_stenosis_percent", "area_stenosis_percent", "mla_mm2", "reference_diameter_mm")
DEPLOYMENT_KEYS = (
    "minimal_stent_area_mm2",
    "minimal_lumen_area_in_stent_mm2",
    "expansion_index",
    "recoil_percent",
    "foreshortening_percent",
    "seconds",
)
STATE_VALUES = {
    "ffr_distal": ("ffr", "distal"),
    "ffr_past_segment": ("ffr", "past_segment"),
    "mean_area_mm2": ("area", "mean_mm2"),
    "minimum_area_mm2": ("area", "minimum_mm2"),
    "mean_curvature_per_mm": ("curvature", "mean_per_mm"),
}


def describe_device(use):
    """A device and its pressure in words, as clinicians write them: "3.50x18 mm stent at 11 bar"."""
    return f"{use['nominal_diameter_mm']:.2f}x{use['length_mm']:g} mm {use['kind']} at {use['pressure_bar']:g} bar"


def describe_procedure(procedure):
    """All steps of a procedure in one line."""
    return "; ".join(
        f"{step['action'].replace('_', ' ')}: " + " + ".join(describe_device(use) for use in step["devices"])
        for step in procedure
    )


def cohort_table(documents):
    """DataFrame of cohort.csv from the metrics documents, in their order; missing values are empty."""
    rows = []
    for document in documents:
        row = {"case": document["case"], "kind": document["kind"]}
        row.update({key: document["patient"].get(key) for key in PATIENT_KEYS})
        lesion, deployment = document["lesion"] or {}, document["deployment"] or {}
        row.update({f"lesion_{key}": lesion.get(key) for key in LESION_KEYS})
        row["procedure"] = describe_procedure(document["procedure"])
        row["segment_length_mm"] = document["segment"]["s_end_mm"] - document["segment"]["s_start_mm"]
        row.update({f"deployment_{key}": deployment.get(key) for key in DEPLOYMENT_KEYS})
        for state in STATES:
            values = document["states"].get(state)
            for name, (group, key) in STATE_VALUES.items():
                row[f"{state}_{name}"] = None if values is None or values[group] is None else values[group][key]
        measured = document.get("measured") or {}
        row.update({f"measured_{key}": measured.get(key) for key in ("ffr_pre", "ffr_post")})
        rows.append(row)
    return pd.DataFrame(rows)
