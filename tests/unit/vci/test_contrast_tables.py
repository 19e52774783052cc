"""The tables of a cohort's errors in vci/measured.md are those of contrast.csv."""

import importlib.util
import pathlib

import pandas as pd

from reports.study.contrast import COLUMNS

FILE = pathlib.Path(__file__).resolve().parents[2] / "verification" / "vci" / "measured_tables.py"
SPEC = importlib.util.spec_from_file_location("vci_measured_tables", FILE)
TABLES = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(TABLES)

TEXT = "before\n<!-- table: pressures -->\nold\n<!-- end -->\nafter\n"


def _write(folder, *rows):
    (folder / "study").mkdir()
    pd.DataFrame(rows, columns=COLUMNS).to_csv(folder / "study" / "contrast.csv", index=False)


def _row(case, quantity, value, vci, rc):
    return {"case": case, "quantity": quantity, "value": value, "error_vci": vci, "error_rc": rc}


def test_a_case_has_its_errors_without_the_cohorts_prefix(tmp_path):
    areas = [("mean_area", 7.004, 0.052, -0.248), ("minimum_area", 5.9, -0.1, 1.0), ("area_profile", None, 0.2, 0.7)]
    _write(tmp_path, *(_row("pressure_fibrous_6", *area) for area in areas), _row("lad01", "mean_area", 9, 1, 1))
    lines = TABLES.PAGE.filled(TEXT, tmp_path).splitlines()
    assert lines[4] == "| `fibrous_6` | 7.00, 5.90 | 0.20, 0.70 | +0.05, -0.25 | -0.10, +1.00 |  |  |"
    assert len(lines) == 7


def test_a_study_of_other_cases_leaves_the_table(tmp_path):
    assert TABLES.PAGE.filled(TEXT, tmp_path) == TEXT
    _write(tmp_path, _row("lad01", "mean_area", 9, 1, 1))
    assert TABLES.PAGE.filled(TEXT, tmp_path) == TEXT
