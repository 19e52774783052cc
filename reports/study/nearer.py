"""nearer.csv: whether VCI or radius correction is nearer to the lumen after PCI, by a paired test over the patients."""

import numpy as np
import pandas as pd
from scipy.stats import wilcoxon

from common.patient.states import AFTER_PCI, COMPARISONS
from reports.study.agreement import QUANTITIES, UNITS, largest_estimate, paired_values
from reports.study.inclusion import patient_groups

SIGNIFICANCE_LEVEL = 0.05  # significance level of each row's test, two-sided
# Fewer patients without a tie cannot show a difference: the smallest possible p of n pairs is 2 / 2^n, 0.0625 for five
# patients and 0.03125 for six.
FEWEST_PATIENTS = 6
RADIUS_CORRECTION = {"vci": "rc", "ct_vci": "ct_rc"}  # predicted by VCI -> by radius correction, from the same lumen
NEARER, FARTHER, UNDECIDED = "nearer", "farther", "no difference shown"
COLUMNS = [
    "patients",
    "quantity",
    "unit",
    "error",
    "truth",
    "n",
    "error_vci",
    "error_rc",
    "patients_vci_nearer",
    "ties",
    "p",
    "vci_is",
]


def nearer_table(documents):
    """DataFrame of nearer.csv: a row for each group of patients, quantity and lumen after PCI.

    A row needs a patient with both predictions. error_vci, error_rc: mean absolute error over the patients. p: by
    Wilcoxon's two-sided signed-rank test of the absolute errors (scipy.stats.wilcoxon); None for fewer than six
    patients that are no ties. ties: patients whose two absolute errors are equal; for FFR, whose two differ by no more
    than the flow's own error.
    """
    rows = [{"patients": name, **row} for name, found in patient_groups(documents) for row in nearer_rows(found)]
    return pd.DataFrame(rows, columns=COLUMNS)


def nearer_rows(documents):
    """The rows (dicts) of nearer.csv for the metrics documents of one group of patients."""
    pairs = [(a, b, error) for a, b, error in COMPARISONS if a in RADIUS_CORRECTION and b in AFTER_PCI]
    rows = []
    for a, truth, kind in pairs:
        for quantity in QUANTITIES:
            vci, rc = (errors_by_case(documents, quantity, state, truth) for state in (a, RADIUS_CORRECTION[a]))
            cases = [case for case in vci if case in rc]
            if cases:
                row = {"quantity": quantity, "unit": UNITS[quantity], "error": kind, "truth": truth}
                compared, noise = (a, RADIUS_CORRECTION[a], truth), np.zeros(len(cases))
                if quantity == "ffr":
                    noise = [flow_error(one, compared) for one in documents if one["case"] in cases]
                rows.append(row | paired_test([vci[case] for case in cases], [rc[case] for case in cases], noise))
    return rows


def errors_by_case(documents, quantity, state, truth):
    """{case: absolute error} of a quantity in a predicted state, against the lumen after PCI (`truth`)."""
    cases, values, true = paired_values(documents, quantity, state, truth)
    return dict(zip(cases, np.abs(np.subtract(values, true))))


def flow_error(document, states):
    """The largest error estimate of a patient's FFRs in these states; infinite if one is not known."""
    largest = largest_estimate([document], states)
    return np.inf if largest is None else largest


def paired_test(vci, rc, noise):
    """The columns of nearer.csv from `n` on. vci, rc: absolute errors (n,) of both methods in the same patients.

    noise (n,): numerical error in each patient. A patient whose two errors differ by no more than this is a tie. The
    test leaves ties out.
    """
    vci, rc = np.asarray(vci, float), np.asarray(rc, float)
    decided = (vci - rc)[np.abs(vci - rc) > noise]
    result = {"n": len(vci), "error_vci": vci.mean(), "error_rc": rc.mean()}
    result |= {"patients_vci_nearer": int((decided < 0.0).sum()), "ties": len(vci) - len(decided), "p": None}
    result["vci_is"] = UNDECIDED
    if len(decided) >= FEWEST_PATIENTS:
        result["p"] = float(wilcoxon(decided).pvalue)
        if result["p"] < SIGNIFICANCE_LEVEL:
            result["vci_is"] = NEARER if np.median(decided) < 0.0 else FARTHER
    return result
