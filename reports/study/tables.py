"""The tables of results/study: the command that writes each of them, and a function that reads them."""

import pandas as pd

from reports.inputs.reading import require_file

WRITTEN_BY = {
    "agreement": "reports agreement",
    "cohort": "reports cohort",
    "contrast": "reports contrast",
    "differences": "reports differences",
    "half_maximum": "reports agreement",  # from the metrics of the lumens at half maximum
    "inclusion": "reports patients",
    "nearer": "reports nearer",
    "patients": "reports patients",
    "seconds": "reports seconds",
    "timings": "reports timings",
}


def study_table(study_dir, name):
    """The DataFrame of <name>.csv in the folder results/study. It has no rows if there was nothing to compare.

    name: a key of WRITTEN_BY. Raises InputError for a missing file; the message names the command that writes it.
    """
    return pd.read_csv(require_file(study_dir / f"{name}.csv", WRITTEN_BY[name]))
