"""agreement.csv: how well predicted and computed values agree with true or measured ones, over the cohort.

The published agreement stands beside them.
"""

import dataclasses
import json
import pathlib

import pandas as pd

from common.patient.states import COMPARISONS, MEASURED
from reports.study.bland_altman import Agreement, bland_altman
from reports.study.inclusion import patient_groups
from reports.measuring.pressure_wire import same_decision_share, wire_pair
from reports.inputs.reading import number

PUBLISHED_FILE = pathlib.Path(__file__).with_name("published.json")
# comparisons (a, b) like the published one: the lumen after virtual PCI minus the lumen in an image after PCI
PUBLISHED_COMPARISONS = (("ct_vci", "ct"), ("vci", "post"))

# name in agreement.csv -> where a state's value is in metrics.json
QUANTITIES = {
    "ffr": "ffr.distal",
    "mean_area": "area.mean_mm2",
    "minimum_area": "area.minimum_mm2",
    "mean_curvature": "curvature.mean_per_mm",
}
UNITS = {"ffr": "1", "mean_area": "mm2", "minimum_area": "mm2", "mean_curvature": "1/mm"}
COLUMNS = ["patients", "quantity", "unit", "error", "comparison"] + [
    field.name for field in dataclasses.fields(Agreement)
]
COLUMNS += ["same_decision", "largest_estimate"]
PUBLISHED_COLUMNS = ["published_n", "published_bias", "published_sd", "published_loa_lower", "published_loa_upper"]


def published_results():
    """The published agreement and seconds (dict): the content of reports/study/published.json.

    provenance: which values were read where (see published_provenance). decimals: how many the source prints, in all
    values.
    """
    return json.loads(PUBLISHED_FILE.read_text())


def published_provenance(name):
    """Where the published values under `name` were read, in words: "from the abstract of the article, ...".

    name: keys of published.json joined by points, such as "seconds.stage". Raises KeyError if the file does not say.
    """
    for source in published_results()["provenance"].values():
        if any(f"{name}.".startswith(f"{values}.") for values in source["values"]):
            return source["words"]
    raise KeyError(name)


def paired_values(documents, quantity, a, b):
    """(case names, values in state a, values in state b) for the metrics documents that have both states.

    If b is `measured`, the values are FFR computed at the wire's sensor and the wire's FFR. For FFR, cases without a
    flow are left out.
    """
    cases, values_a, values_b = [], [], []
    for document in documents:
        states = document["states"]
        if b == MEASURED:
            pair = wire_pair(document, a) if quantity == "ffr" else None
            if pair:
                cases.append(document["case"])
                values_a.append(pair[0])
                values_b.append(pair[1])
        elif a in states and b in states:
            if quantity == "ffr" and None in (states[a]["ffr"], states[b]["ffr"]):
                continue
            cases.append(document["case"])
            values_a.append(number(states, f"{a}.{QUANTITIES[quantity]}", f"metrics of {document['case']}"))
            values_b.append(number(states, f"{b}.{QUANTITIES[quantity]}", f"metrics of {document['case']}"))
    return cases, values_a, values_b


def agreement_table(documents):
    """DataFrame of agreement.csv: a row for each group of patients, comparison and quantity with at least one case."""
    rows = [{"patients": name, **row} for name, found in patient_groups(documents) for row in agreement_rows(found)]
    table = pd.DataFrame(rows, columns=COLUMNS + PUBLISHED_COLUMNS)
    return table.astype({"published_n": "Int64"})


def agreement_rows(documents):
    """The rows (dicts) of agreement.csv for the metrics documents of one group of patients."""
    rows, published = [], published_results()
    for a, b, error in COMPARISONS:
        for quantity in QUANTITIES:
            cases, values_a, values_b = paired_values(documents, quantity, a, b)
            if not cases:
                continue
            source = published["quantities"].get(quantity)
            row = {"quantity": quantity, "unit": UNITS[quantity], "error": error}
            row["comparison"] = f"{a}_minus_{b}"
            row.update(dataclasses.asdict(bland_altman(values_a, values_b)))
            if quantity == "ffr":
                row["same_decision"] = same_decision_share(values_a, values_b)
                row["largest_estimate"] = largest_estimate([one for one in documents if one["case"] in cases], (a, b))
            if (a, b) in PUBLISHED_COMPARISONS and source:
                row["published_n"] = published["n"]
                row.update({f"published_{key}": source[key] for key in ("bias", "sd", "loa_lower", "loa_upper")})
            rows.append(row)
    return rows


def largest_estimate(documents, states):
    """The largest error estimate of the FFRs computed in these states; None if an FFR has no estimate."""
    entries = [document["states"][state]["ffr"] for document in documents for state in states if state != MEASURED]
    estimates = [entry.get("error_estimate") for entry in entries]
    return None if None in estimates else max(estimates)
