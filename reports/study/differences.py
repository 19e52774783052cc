"""Diff^A and Diff^C, equations 24 and 25 of Lyu et al. 2025: differences in area and curvature.

A difference is the value in a predicted lumen minus the value in the lumen after PCI. The tables give it at each
station, for each patient and over the cohort.
"""

import numpy as np
import pandas as pd

from common.patient.states import AFTER_PCI, COMPARISONS, PREDICTED
from reports.study.bland_altman import sample_sd
from reports.study.inclusion import patient_groups

# name of the difference -> (group and key of a state's profile in metrics.json, key in `differences` of metrics.json,
# suffix of the unit)
QUANTITIES = {
    "diff_area": ("area", "profile_mm2", "area_mm2", "mm2"),
    "diff_curvature": ("curvature", "profile_per_mm", "curvature_per_mm", "per_mm"),
}
# Stands in the column `case` of the row with mean and standard deviation over the patients of a group.
COHORT_ROW_NAME = "all cases"


def compared_pairs(documents):
    """The COMPARISONS (a, b, error) of a predicted state a with a state b after PCI that at least one patient has."""
    wanted = [(a, b, error) for a, b, error in COMPARISONS if a in PREDICTED and b in AFTER_PCI]
    return [one for one in wanted if any({one[0], one[1]} <= set(document["states"]) for document in documents)]


def station_differences(document, a, b):
    """DataFrame of one patient with a row for each station: predicted state a minus state b after PCI."""
    states, table = document["states"], {"relative_position": document["stations"]["relative_position"]}
    table["s_mm"] = states[b]["s_mm"]
    for name, (group, profile, _, unit) in QUANTITIES.items():
        first, second = (np.array(states[state][group][profile]) for state in (a, b))
        quantity = name.removeprefix("diff_")
        table[f"{quantity}_a_{unit}"], table[f"{quantity}_b_{unit}"] = first, second
        table[f"{name}_{unit}"] = first - second
    return pd.DataFrame(table)


def station_table(documents):
    """DataFrame of differences_stations.csv: a row for each comparison, patient and station."""
    parts = []
    for a, b, error in compared_pairs(documents):
        for document in documents:
            if {a, b} <= set(document["states"]):
                part = station_differences(document, a, b)
                keys = {"case": document["case"], "error": error, "comparison": f"{a}_minus_{b}"}
                parts.append(pd.concat([pd.DataFrame(keys, index=part.index), part], axis=1))
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=["case", "error", "comparison"])


def difference_table(documents):
    """DataFrame of differences.csv: a row for each patient and comparison.

    After the patients of a comparison comes a row for their group.
    """
    rows = [{"patients": name, **row} for name, found in patient_groups(documents) for row in group_rows(found)]
    return pd.DataFrame(rows, columns=None if rows else ["patients", "case", "error", "comparison"])


def group_rows(documents):
    """The rows (dicts) of differences.csv for the metrics documents of one group of patients."""
    rows = []
    for a, b, error in compared_pairs(documents):
        of_cases = [patient_row(document, a, b) for document in documents if {a, b} <= set(document["states"])]
        keys = {"error": error, "comparison": f"{a}_minus_{b}"}
        rows += [{"case": row.pop("case"), **keys, **row} for row in [*of_cases, cohort_row(of_cases)]]
    return rows


def patient_row(document, a, b):
    """One patient's row: mean, standard deviation, mean size and largest size of the differences over the stations.

    Size means absolute value. The mean is also given in per cent of the mean value after PCI.
    """
    stations = station_differences(document, a, b)
    row = {"case": document["case"], "n": len(stations)}
    for name, (_, _, key, unit) in QUANTITIES.items():
        along = document["differences"][f"{a}_minus_{b}"][key]
        size = stations[f"{name}_{unit}"].abs()
        after = stations[f"{name.removeprefix('diff_')}_b_{unit}"].mean()
        row[f"{name}_mean_{unit}"], row[f"{name}_sd_{unit}"] = along["bias"], along["sd"]
        row[f"{name}_mean_percent"] = 100.0 * along["bias"] / after
        row[f"{name}_mean_size_{unit}"], row[f"{name}_largest_size_{unit}"] = size.mean(), size.max()
    return row


def cohort_row(of_cases):
    """The row of a group, from the rows of its patients: means over the patients, with two exceptions.

    `sd` is the sample standard deviation of the patients' means. `largest` is the largest value at any station.
    """
    row = {"case": COHORT_ROW_NAME, "n": len(of_cases)}
    for key in of_cases[0]:
        values = [one[key] for one in of_cases]
        if "_largest_" in key:
            row[key] = max(values)
        elif "_sd_" in key:
            row[key] = sample_sd([one[key.replace("_sd_", "_mean_")] for one in of_cases])
        elif key not in row:
            row[key] = float(np.mean(values))
    return row
