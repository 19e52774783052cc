"""The rows of agreement, nearer and contrast by group of patients, with the names, digits and units of the page."""

from reports.page.digits import MOST_DIGITS, decimals
from reports.study.contrast import AREA_PROFILE
from reports.study.inclusion import GROUPS, meets_criterion

QUANTITY_NAMES = {
    "ffr": "FFR",
    "mean_area": "Mean CSA",
    "minimum_area": "Smallest CSA",
    "mean_curvature": "Mean curvature",
}
CONTRAST_NAMES = QUANTITY_NAMES | {AREA_PROFILE: "CSA along the stent, rms"}
QUANTITY_DIGITS = {"ffr": 3, "mean_area": 2, "minimum_area": 2, "mean_curvature": 3}  # least number of decimals
UNITS = {"1": "", "mm2": "mm²", "1/mm": "/mm"}
# prediction -> {error that depends on how the CT is segmented: comparison in agreement.csv that shows it}
SEGMENTATION_COMPARISONS = {
    "vci": {"imaging_before": "ct_vci_minus_vci", "imaging_after": "ct_minus_reference", "clinical": "ct_vci_minus_ct"},
    "rc": {"imaging_before": "ct_rc_minus_rc", "imaging_after": "ct_minus_reference", "clinical": "ct_rc_minus_ct"},
}


def agreement_groups(agreement, nearer, half_maximum):
    """[{name, rows, nearer, segmentations}] for each group of patients that has rows in agreement.csv.

    agreement, nearer, half_maximum: rows of the tables of these names. segmentations: result of `segmentation_rows`.
    """
    found = []
    for name in GROUPS:
        rows, others = (
            [row for row in agreement_rows(table) if row["patients"] == name] for table in (agreement, half_maximum)
        )
        if rows:
            of_nearer = nearer_rows([row for row in nearer if row["patients"] == name])
            found.append(
                {"name": name, "rows": rows, "nearer": of_nearer, "segmentations": segmentation_rows(rows, others)}
            )
    return found


def segmentation_rows(rows, others):
    """Errors by two segmentations of the CT: [{prediction, name, unit, method, errors {error: (own, other)}}].

    rows, others: rows of agreement.csv and half_maximum.csv for one group of patients; without others the result is
    empty. own, other: the row of an error by the study's own segmentation and at half maximum, or None. method: the
    row of the error `method`, which does not depend on the CT.
    """
    own, other = ({(row["quantity"], row["comparison"]): row for row in table} for table in (rows, others))
    found = []
    for prediction, comparisons in SEGMENTATION_COMPARISONS.items():
        for quantity, name in QUANTITY_NAMES.items():
            errors = {
                error: (own.get((quantity, comparison)), other.get((quantity, comparison)))
                for error, comparison in comparisons.items()
            }
            known = [row for pair in errors.values() for row in pair if row]
            if any(pair[1] for pair in errors.values()):
                row = {"prediction": prediction, "name": name, "unit": known[0]["unit"], "errors": errors}
                row["method"] = own.get((quantity, f"{prediction}_minus_reference"))
                found.append(row)
    return found


def agreement_rows(rows):
    """The rows of agreement.csv with the names, digits and units of the page."""
    return [
        {
            **row,
            "name": QUANTITY_NAMES[row["quantity"]],
            "digits": row_digits(row),
            "unit": unit_name(row),
        }
        for row in rows
    ]


def row_digits(row):
    """Number of decimals for bias and sd of a row of agreement.csv.

    It is the usual number of the quantity, or more to show two significant digits of the bias, but at most MOST_DIGITS.
    An sd that is far smaller gets one decimal more, so that a tiny sd does not fill the table with digits.
    """
    least, bias, sd = QUANTITY_DIGITS[row["quantity"]], row["bias"], row["sd"]
    of_bias = max(least, decimals(bias, 2)) if bias else least
    of_sd = min(decimals(sd, 2), of_bias + 1 if bias else MOST_DIGITS) if sd else 0
    return min(MOST_DIGITS, max(of_bias, of_sd))


def unit_name(row):
    """A row's unit as the page writes it."""
    return UNITS[row["unit"] if isinstance(row["unit"], str) else "1"]


def nearer_rows(rows):
    """The rows of nearer.csv with the names and units of the page."""
    return [{**row, "name": QUANTITY_NAMES[row["quantity"]], "unit": unit_name(row)} for row in rows]


def contrast_rows(rows, contexts):
    """The rows of contrast.csv by case: [{name, description, rows}]. contexts: case_context of each case."""
    by_case = []
    for context in contexts:
        of_case = [
            {**row, "name": CONTRAST_NAMES[row["quantity"]], "unit": unit_name(row)}
            for row in rows
            if row["case"] == context["name"]
        ]
        if of_case:
            description = context["metrics"]["patient"].get("description")
            by_case.append({"name": context["name"], "description": description, "rows": of_case})
    return by_case


def excluded_patients(patients):
    """[(case, why it is not included)] of the rows of patients.csv."""
    found = []
    for row in patients:
        if not meets_criterion(row["ffr_criterion"]):
            reason = (
                "FFR before PCI not known"
                if row["ffr_criterion"] is None
                else f"FFR before PCI {row['ffr_criterion']:.2f}"
            )
            found.append((row["case"], reason))
    return found
