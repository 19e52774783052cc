"""The tables of a cohort's errors in vci/measured.md are those of contrast.csv."""

import importlib.util
import json
import pathlib

import pandas as pd
import pytest

from common.errors import InputError
from reports.study.contrast import COLUMNS
from vci.benchmarks.published import NOT_COMPARED

FILE = pathlib.Path(__file__).resolve().parents[2] / "verification" / "vci" / "measured_tables.py"
SPEC = importlib.util.spec_from_file_location("vci_measured_tables", FILE)
TABLES = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(TABLES)

TEXT = "before\n<!-- table: pressures -->\nold\n<!-- end -->\nafter\n"
EXAMPLE = "<!-- table: contrast_example -->\nold\n<!-- end -->\n"


def _write(folder, *rows):
    (folder / "study").mkdir()
    pd.DataFrame(rows, columns=COLUMNS).to_csv(folder / "study" / "contrast.csv", index=False)


def _row(case, quantity, value, vci, rc, rc_stent=None):
    errors = {"error_vci": vci, "error_rc": rc, "error_rc_stent": rc_stent}
    return {"case": case, "quantity": quantity, "value": value} | errors


def _provenance(folder, **software):
    (folder / "study" / "provenance.json").write_text(json.dumps({"software": software}))


def test_a_case_has_its_errors_without_the_cohorts_prefix(tmp_path):
    areas = [("mean_area", 7.004, 0.052, -0.248), ("minimum_area", 5.9, -0.1, 1.0), ("area_profile", None, 0.2, 0.7)]
    _write(tmp_path, *(_row("pressure_fibrous_6", *area) for area in areas), _row("lad01", "mean_area", 9, 1, 1))
    lines = TABLES.PAGE.filled(TEXT, tmp_path).splitlines()
    assert lines[4] == "| `fibrous_6` | 7.00, 5.90 | 0.20, 0.70 | +0.05, -0.25 | -0.10, +1.00 |  |  |"
    assert len(lines) == 9


def test_the_reading_by_the_stent_alone_stands_in_parentheses(tmp_path):
    areas = [("mean_area", 7.0, 0.1, -0.2, -0.654), ("minimum_area", 5.9, -0.1, 1.0, 0.5)]
    _write(tmp_path, *(_row("pressure_lipid", *area) for area in areas))
    row = TABLES.PAGE.filled(TEXT, tmp_path).splitlines()[4]
    assert row == "| `lipid` | 7.00, 5.90 |  | +0.10, -0.20 (-0.65) | -0.10, +1.00 (+0.50) |  |  |"


def test_the_run_has_its_revision_below_the_table(tmp_path):
    _write(tmp_path, *(_row("pressure_lipid", name, 9, 1, 1) for name in ("mean_area", "minimum_area")))
    assert "\n\nThe revision of this run was not written down.\n" in TABLES.PAGE.filled(TEXT, tmp_path)
    _provenance(tmp_path, revision="0123456789abcdef", modified=False)
    assert "|\n\nRun of revision 01234567.\n<!-- end -->" in TABLES.PAGE.filled(TEXT, tmp_path)
    _provenance(tmp_path, revision="0123456789abcdef", modified=True)
    assert "Run of revision 01234567, with changes that were not committed." in TABLES.PAGE.filled(TEXT, tmp_path)


def test_the_sources_example_stands_beside_the_cases_that_have_its_reading(tmp_path):
    """FFR of the source: 0.86 by radius correction of the stent alone, 0.88 by VCI, 0.89 after PCI."""
    rows = [_row("contrast_bend", "ffr", 0.9, -0.006, 0.002, -0.0301), _row("contrast_taper", "ffr", 0.9, 0.01, 0.02)]
    _write(tmp_path, *rows, _row("contrast_bend", "mean_area", 9, 1, 1, 1))
    lines = TABLES.PAGE.filled(EXAMPLE, tmp_path).splitlines()
    assert lines[3] == "| Lyu et al., figure 8 | 0.89 | 0.86 | 0.88 | -0.03 | -0.01 |"
    assert lines[4] == "| `bend` | 0.9000 | 0.8699 | 0.8940 | -0.0301 | -0.0060 |"
    assert lines[5] == "" and lines[7] == "<!-- end -->"


def test_a_study_of_other_cases_leaves_the_table(tmp_path):
    assert TABLES.PAGE.filled(TEXT + EXAMPLE, tmp_path) == TEXT + EXAMPLE
    _write(tmp_path, _row("lad01", "mean_area", 9, 1, 1), _row("contrast_taper", "ffr", 0.9, 0.01, 0.02))
    assert TABLES.PAGE.filled(TEXT + EXAMPLE, tmp_path) == TEXT + EXAMPLE


def test_a_table_of_an_older_study_is_refused(tmp_path):
    (tmp_path / "study").mkdir()
    (tmp_path / "study" / "contrast.csv").write_text("case,quantity,value,error_vci,error_rc\n")
    with pytest.raises(InputError, match="(?s)lacks columns.*error_rc_stent"):
        TABLES.PAGE.filled(TEXT, tmp_path)


def test_the_page_says_which_published_measurements_are_not_compared(tmp_path):
    """The table on the page is that of the code."""
    page = TABLES.PAGE.path.read_text()
    table = TABLES.not_compared(tmp_path)
    assert f"<!-- table: not_compared -->\n{table}<!-- end -->" in page
    assert table.count("\n") == 2 + len(NOT_COMPARED)
