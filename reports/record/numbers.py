"""report.json: every number of the page's summary in one file, from the study's tables, without durations."""

import pandas as pd

from common.files import sha256
from common.patient.states import STATES
from reports.inputs.reading import require_file, read_json
from reports.page.evidence import evidence_rows, read_test_results
from reports.study.agreement import published_results
from reports.study.cohort import STATE_VALUES
from reports.study.inclusion import EXCLUDED, INCLUDED
from reports.study.tables import study_table
from reports.whatif.tables import read_intervals, read_ranking, records

SCHEMA = "vci-report-1"
TABLES = ("agreement", "half_maximum", "nearer", "contrast", "differences", "inclusion", "patients")


def report_numbers(case_files, study_dir, cohort, junit, failed=()):
    """The document of report.json. Raises InputError if a table or another file is missing.

    case_files: CaseFiles of the study; junit: files of test results; failed: entries of failed.json.
    """
    tables = {name: study_table(study_dir, name) for name in TABLES}
    provenance = require_file(study_dir / "provenance.json", "workflow provenance")
    tests = [
        {key: row[key] for key in ("kind", "part", "tests", "passed", "failed", "skipped")}
        for row in evidence_rows(read_test_results(junit))
    ]
    return {
        "schema": SCHEMA,
        "cohort": cohort or None,
        "cases": [files.case for files in case_files],
        "failed": list(failed),
        "source": published_results(),
        "provenance_sha256": sha256(provenance),
        "software": read_json(provenance, "workflow provenance")["software"],
        "states": state_means(rows_of_group(study_dir, INCLUDED)),
        "states_excluded": state_means(rows_of_group(study_dir, EXCLUDED)),
        **{name: records(found) for name, found in tables.items()},
        "plans": {files.case: read_ranking(files.folder) for files in case_files},
        "sensitivity": {files.case: interval_rows(files.folder) for files in case_files},
        "evidence": {
            **{key: sum(row[key] for row in tests) for key in ("passed", "failed", "skipped")},
            "tests": tests,
        },
    }


def rows_of_group(study_dir, name):
    """The rows of cohort.csv that belong to a group of patients (`name`: INCLUDED or EXCLUDED)."""
    cohort, patients = study_table(study_dir, "cohort"), study_table(study_dir, "patients")
    chosen = patients["case"][patients["included"].eq(True)]
    return cohort[cohort["case"].isin(chosen) == (name == INCLUDED)]


def state_means(cohort):
    """{state: {quantity: {n, mean, sd}}} over the cases of cohort.csv; sd with n - 1, None for a single case."""
    found = {}
    for state in STATES:
        for name in STATE_VALUES:
            values = cohort.get(f"{state}_{name}", pd.Series(dtype=float)).dropna().astype(float)
            if len(values):
                sd = float(values.std(ddof=1)) if len(values) > 1 else None
                found.setdefault(state, {})[name] = {"n": len(values), "mean": float(values.mean()), "sd": sd}
    return found


def interval_rows(folder):
    """The rows of a case's intervals, from Latin hypercube samples. `source`: what was varied, flow or deployment."""
    return [row for found in read_intervals(folder).values() for row in records(found)]
