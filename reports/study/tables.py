"""The tables of results/study: which command writes each of them, and how it is read back."""

import pandas as pd

from reports.inputs.reading import require_file

WRITTEN_BY = {
    "agreement": "reports agreement",
    "cohort": "reports cohort",
    "contrast": "reports contrast",
    "differences": "reports differences",
    "half_maximum": "reports agreement",  # of the metrics in the lumens at half maximum
    "inclusion": "reports patients",
    "nearer": "reports nearer",
    "patients": "reports patients",
    "seconds": "reports seconds",
    "timings": "reports timings",
}


def study_table(study_dir, name):
    """The DataFrame of <name>.csv in the folder results/study; without rows if there was nothing to compare.

    name: a key of WRITTEN_BY. Raises InputError, which names the command that writes it, for a missing file.
    """
    return pd.read_csv(require_file(study_dir / f"{name}.csv", WRITTEN_BY[name]))
