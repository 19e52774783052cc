"""patients.csv: the patients, as in supplementary table 1 of Lyu et al. 2025. inclusion.csv: who is included."""

import pandas as pd

from common.patient.states import TRUE_STATES
from reports.inputs.reading import number
from reports.measuring.pressure_wire import FFR_THRESHOLD
from reports.study.cohort import describe_procedure
from reports.study.inclusion import ffr_before, meets_criterion

# With an FFR below this after PCI, patients had more adverse events (Rimac et al., Am Heart J 2017;183:1-9, a
# meta-analysis of 7470 patients).
LOW_FFR_AFTER = 0.90
COLUMNS = ["case", "artery", "branch", "stenosis_percent", "lesion_length_mm", "reference_diameter_mm", "lesions"]
COLUMNS += [
    "plaque",
    "calcium",
    "procedure",
    "ffr_before",
    "ffr_criterion",
    "included",
    "ffr_vci",
    "ffr_after",
    "low_after",
]
STEP_COLUMNS = ["step", "count", "cases"]


def patients_table(documents, cases):
    """DataFrame of patients.csv from the metrics documents. cases: {name: content of the case's file}."""
    return pd.DataFrame([patient_row(one, cases[one["case"]]) for one in documents], columns=COLUMNS)


def patient_row(document, case):
    """One patient's row of patients.csv (dict). FFR is at the distal probe, past the lesion.

    `ffr_after` is the FFR of the first of TRUE_STATES that has one.
    """
    lesion, vessel = document["lesion"] or {}, case.get("vessel", {})
    ffr = {
        state: number(entry, "ffr.distal", f"metrics of {document['case']}, {state}")
        for state, entry in document["states"].items()
        if entry["ffr"]
    }
    after = next((ffr[state] for state in TRUE_STATES if state in ffr), None)
    return {
        "case": document["case"],
        "artery": vessel.get("artery", case["patient"].get("territory", "")),
        "branch": lesion.get("branch"),
        "stenosis_percent": lesion.get("diameter_stenosis_percent"),
        "lesion_length_mm": lesion["s_end_mm"] - lesion["s_start_mm"] if lesion else None,
        "reference_diameter_mm": lesion.get("reference_diameter_mm"),
        "lesions": len(vessel["lesions"]) if vessel else None,
        "plaque": ", ".join(dict.fromkeys(one["plaque"] for one in vessel.get("lesions", []))),
        "calcium": "; ".join(describe_calcium(one["calcium"]) for one in vessel.get("lesions", []) if "calcium" in one),
        "procedure": describe_procedure(document["procedure"]),
        "ffr_before": ffr.get("pre"),
        "ffr_criterion": ffr_before(document),
        "included": meets_criterion(ffr_before(document)),
        "ffr_vci": ffr.get("vci"),
        "ffr_after": after,
        "low_after": None if "vci" not in ffr else ffr["vci"] < LOW_FFR_AFTER,
    }


def describe_calcium(calcium):
    """A sheet of calcium in words, such as "120 degrees over 8 mm"."""
    return f"{calcium['arc_deg']:g} degrees over {calcium['length_mm']:g} mm"


def inclusion_table(patients, states, failed=()):
    """DataFrame of inclusion.csv, the steps of the flow chart.

    patients: result of patients_table. states: {case: names of its states}. failed: names of cases without a result.
    """
    known = patients[patients["ffr_criterion"].notna()]
    included = known[known["included"].astype(bool)]
    names = list(included["case"])
    steps = [
        ("cases of the cohort", [*patients["case"], *failed]),
        ("FFR before PCI not known", [*patients["case"][patients["ffr_criterion"].isna()], *failed]),
        (f"FFR before PCI of {FFR_THRESHOLD:.2f} and more", list(known["case"][~known["included"].astype(bool)])),
        (f"included: FFR before PCI below {FFR_THRESHOLD:.2f}", names),
        ("lumen after PCI known", [case for case in names if set(TRUE_STATES) & set(states[case])]),
        ("seen in CT before and after", [case for case in names if "ct_vci" in states[case]]),
        (
            f"predicted FFR after PCI below {LOW_FFR_AFTER:.2f}",
            list(included["case"][included["low_after"].fillna(False).astype(bool)]),
        ),
    ]
    return pd.DataFrame([(words, len(cases), " ".join(cases)) for words, cases in steps], columns=STEP_COLUMNS)
