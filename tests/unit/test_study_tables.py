"""tests/verification/study_tables.py: the tables of docs/nine-patients.md, from small files of results/study."""

import pathlib
import sys

import pytest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "verification")]

import study_tables  # noqa: E402

COHORT = """case,pre_ffr_distal,reference_ffr_distal,vci_ffr_distal,rc_ffr_distal,{areas},deployment_expansion_index
a,0.70,0.90,0.91,0.92,{values},0.8
b,0.72,0.94,,0.96,{values},
"""
AREAS = [f"{state}_{area}_area_mm2" for state in ("pre", "reference", "vci", "rc") for area in ("mean", "minimum")]
AREAS += [f"{state}_mean_curvature_per_mm" for state in ("pre", "reference", "vci", "rc")]


@pytest.fixture
def results(tmp_path):
    (tmp_path / "study").mkdir()
    values = ",".join(str(1.5 + k) for k in range(len(AREAS)))
    (tmp_path / "study" / "cohort.csv").write_text(COHORT.format(areas=",".join(AREAS), values=values))
    return tmp_path


def test_a_row_a_patient_and_empty_where_nothing_is_known(results):
    lines = study_tables.patients(results).splitlines()
    assert len(lines) == 4
    assert lines[2].startswith("| a | 0.700 | 0.900 | 0.910 | 0.920 | 3.50 | 5.50 | 7.50 | 4.50 | 6.50 | 8.50 | 0.80 |")
    assert lines[3].startswith("| b | 0.720 | 0.940 |  | 0.960 |") and lines[3].endswith("|  |")


def test_mean_and_deviation_of_those_that_have_a_value(results):
    ffr = study_tables.spread(results).splitlines()[2]
    assert ffr.startswith("| FFR | 0.710 ± 0.014 | 0.920 ± 0.028 | 0.910 |")


@pytest.mark.parametrize(
    "value, said", [("0.00079", "+0.00079"), ("-0.0126", "-0.013"), ("0.31", "+0.310"), ("0", "0.000")]
)
def test_a_small_bias_has_two_digits(value, said):
    assert study_tables.format_small(value, 3) == said


def test_the_page_has_a_place_for_each_table_and_keeps_what_was_not_run(tmp_path):
    text = study_tables.PAGE.path.read_text()
    assert study_tables.PAGE.names(text) == set(study_tables.TABLE_FUNCTIONS)
    assert study_tables.PAGE.filled(text, tmp_path) == text
