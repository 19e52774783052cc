"""The tables of flow/measured.md are made from the files of the benchmarks and of the study."""

import json
import pathlib
import sys

import pytest

from common.errors import InputError

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "verification" / "flow"))

import measured_tables  # noqa: E402
from page_tables import TABLE_MARKS, Page, merged  # noqa: E402

ROW = "| {} |  |  |  |  |\n"
TEXT = "before\n<!-- table: flow_hard_cases -->\nold\n<!-- end -->\nafter\n"


def _write(folder, leave_out=()):
    columns = [name for name in measured_tables.TABLES["flow_hard_cases"][1] if name not in leave_out]
    row = {name: "" for name in columns} | {"case": "single_62", "error": "0.00131"}
    folder = folder / "benchmarks" / "flow_hard_cases"
    folder.mkdir(parents=True)
    lines = [",".join(columns), ",".join(row[name] for name in columns)]
    (folder / "hard_cases.csv").write_text("\n".join(lines) + "\n")


def test_a_table_is_that_of_the_file(tmp_path):
    _write(tmp_path)
    lines = measured_tables.PAGE.filled(TEXT, tmp_path).splitlines()
    assert lines[0] == "before" and lines[-1] == "after" and "old" not in lines
    assert lines[2].startswith("| case | error |")
    assert lines[4].startswith("| single_62 |") and "| +0.0013 |" in lines[4]
    assert len(lines) == 7


def test_a_benchmark_that_was_not_run_leaves_its_table(tmp_path):
    assert measured_tables.PAGE.filled(TEXT, tmp_path) == TEXT


def _page_with_rows(*cases):
    """A page whose table flow_hard_cases has a row for each case, with no figures."""
    columns = list(measured_tables.TABLES["flow_hard_cases"][1].values())
    head = f"| {' | '.join(columns)} |\n| {' | '.join(['---'] * len(columns))} |\n"
    return TEXT.replace("old\n", head + "".join(ROW.format(case) for case in cases))


def _cases_of(page):
    return [line.split(" | ")[0][2:] for line in page.splitlines()[4:-2]]


def test_rows_that_were_not_run_again_stay_in_their_order(tmp_path):
    _write(tmp_path)
    page = measured_tables.PAGE.filled(_page_with_rows("zeta", "single_62", "alpha"), tmp_path)
    assert _cases_of(page) == ["zeta", "single_62", "alpha"]
    assert "| +0.0013 |" in page.splitlines()[5] and page.count("+0.0013") == 1, "the new row replaces the old one"
    assert measured_tables.PAGE.filled(page, tmp_path) == page, "once more changes nothing"
    page = measured_tables.PAGE.filled(_page_with_rows("zeta", "alpha"), tmp_path)
    assert _cases_of(page) == ["zeta", "alpha", "single_62"], "a further row comes last"


def test_rows_of_other_columns_or_of_a_table_without_a_key_do_not_stay(tmp_path):
    _write(tmp_path)
    text = _page_with_rows("zeta", "single_62").replace("| estimate |", "| bound |")
    assert _cases_of(measured_tables.PAGE.filled(text, tmp_path)) == ["single_62"]
    page = Page("flow", measured_tables.TABLES, {})
    assert _cases_of(page.filled(_page_with_rows("zeta"), tmp_path)) == ["single_62"]


def test_rows_are_told_apart_by_as_many_cells_as_the_table_needs():
    head = ["| case | solver | error |", "| --- | --- | --- |"]
    old, new = [*head, "| a | x | 1 |", "| a | y | 1 |"], [*head, "| a | y | 2 |", "| b | y | 2 |"]
    rows = merged(old, new, 2).splitlines()[2:]
    assert rows == ["| a | x | 1 |", "| a | y | 2 |", "| b | y | 2 |"]
    assert merged(old, new, 1).splitlines()[2:] == ["| a | y | 2 |", "| b | y | 2 |"]


def test_no_two_rows_of_the_page_have_the_same_key():
    text = (ROOT / "flow" / "measured.md").read_text()
    tables = {found.group(2): found.group(0).splitlines()[1:-1] for found in TABLE_MARKS.finditer(text)}
    for name, cells in measured_tables.KEYS.items():
        assert merged(tables[name], tables[name][:2], cells).splitlines() == tables[name], name


def test_a_file_without_a_column_is_refused(tmp_path):
    _write(tmp_path, ["estimate"])
    with pytest.raises(InputError, match="estimate"):
        measured_tables.PAGE.filled(TEXT, tmp_path)


def _write_state(folder, case, state, **changes):
    answer = {"dofs": 9, "ffr": 0.71234, "error_estimate": {"ffr": 0.0014}, "artificial_viscosity": 0}
    powers = {"friction_w": 0.9, "grad_div_w": 0.1, "artificial_w": 0.25, "backflow_w": 0.0}
    answer |= {
        "energy": powers,
        "mesh": "mesh.msh",
        "meshes": [],
        "models": {},
        "cpu_seconds": 119.4,
        "peak_memory_mib": 1519.2,
        **changes,
    }
    path = folder / "cases" / case / "flow" / state / "ffr.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(answer))
    _finish_study(folder, "lad01", "lad02")


def _finish_study(folder, *cases):
    (folder / "study").mkdir(exist_ok=True)
    (folder / "study" / "cohort.csv").write_text("\n".join(["case", *cases]) + "\n")


def test_a_table_over_the_study_has_its_cases_alone(tmp_path):
    text = TEXT.replace("flow_hard_cases", "study")
    _write_state(tmp_path, "lad01", "pre")
    _write_state(tmp_path, "quick_branch", "pre")
    lines = measured_tables.PAGE.filled(text, tmp_path).splitlines()
    assert len(lines) == 7 and lines[4].startswith("| lad01 |")
    (tmp_path / "study" / "cohort.csv").unlink()
    assert measured_tables.PAGE.filled(text, tmp_path) == text, "a study that is not finished has no table"


def test_the_study_has_a_row_for_each_case_with_the_worst_state_after(tmp_path):
    text = TEXT.replace("flow_hard_cases", "study")
    assert measured_tables.PAGE.filled(text, tmp_path) == text
    _write_state(tmp_path, "lad01", "ct", error_estimate={"ffr": 0.0021}, cpu_seconds=40)
    estimate = {"ffr": 0.0014, "artificial_viscosity": -0.0004}
    _write_state(tmp_path, "lad01", "pre", error_estimate=estimate, artificial_viscosity=0.01)
    _write_state(tmp_path, "lad01", "vci", peak_memory_mib=1600)
    _write_state(tmp_path, "lad02", "vci", error_estimate=None)
    lines = measured_tables.PAGE.filled(text, tmp_path).splitlines()
    assert lines[2].startswith("| case | FFR before | estimate |") and len(lines) == 8
    assert lines[4] == "| lad01 | 0.7123 | 0.0014 | 0.01 | 0.0006 | 8.0 | 119 | 0.0021 | 119 | 1600 |"
    assert lines[5] == "| lad02 |  |  |  |  |  |  | unknown | 119 | 1519 |"
    (tmp_path / "cases" / "lad01" / "flow" / "pre" / "ffr.json").write_text("{}")
    with pytest.raises(InputError, match="not an answer of the flow solver"):
        measured_tables.PAGE.filled(text, tmp_path)


def test_an_estimate_is_judged_by_the_next_finer_mesh(tmp_path):
    text = TEXT.replace("flow_hard_cases", "coverage")
    assert measured_tables.PAGE.filled(text, tmp_path) == text
    sequence = [(0.70, 0.02), (0.71, 0.001), (0.712, 0.001)]
    meshes = [{"ffr": ffr, "error_estimate": estimate} for ffr, estimate in sequence] + [{"status": "no flow"}]
    _write_state(tmp_path, "lad01", "pre", meshes=meshes)
    _write_state(tmp_path, "lad01", "vci", meshes=meshes[:1])
    lines = measured_tables.PAGE.filled(text, tmp_path).splitlines()
    assert lines[4] == "| trees before PCI, meshes passed over | next finer mesh | 2 | 1 | 0.5 |" and len(lines) == 7
    _write_finer(tmp_path)
    lines = measured_tables.PAGE.filled(text, tmp_path).splitlines()
    assert lines[5] == "| trees before PCI, answers | next finer mesh | 1 | 1 | 4.0 |"
    assert lines[6] == "| trees after PCI, answers | next finer mesh | 1 | 0 | 0.4 |", "no finer flow, no pair"


def test_an_audit_says_whether_the_steady_answer_is_the_mean(tmp_path):
    keys = {"ffr_steady": 0.7253, "ffr_mean": 0.7239, "ffr_mean_half_width_95": 0.0002, "ffr_least": 0.7224}
    keys |= {"ffr_most": 0.7254, "time_units": 20.0, "start_up_units": 3.2, "steps": 700, "agrees": True}
    path = tmp_path / "cases" / "lcx01" / "flow" / "pre" / "audit.json"
    assert measured_tables.audit(tmp_path) is None
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(keys))
    row = "| lcx01 | pre | 0.7253 | 0.7239 ± 0.0002 | 0.7224 | 0.7254 | 20 | 3.2 | 700 | yes |"
    assert measured_tables.audit(tmp_path).splitlines()[2] == row
    path.write_text(json.dumps(keys | {"agrees": None}))
    assert measured_tables.audit(tmp_path).splitlines()[2].endswith("| not settled |")


def _write_finer(folder):
    path = folder / "benchmarks" / "flow_finer_mesh" / "finer_mesh.csv"
    path.parent.mkdir(parents=True)
    columns = list(measured_tables.TABLES["flow_finer_mesh"][1])
    values = [("a pre", "0.0040", "-0.00100"), ("a vci", "0.0020", "+0.00500"), ("b vci", "0.0030", "")]
    rows = [dict(zip(("state", "estimate", "difference"), value)) for value in values]
    lines = [",".join(row.get(name, "") for name in columns) for row in rows]
    path.write_text("\n".join([",".join(columns), *lines]) + "\n")


def test_the_page_names_tables_that_there_are():
    names = measured_tables.PAGE.names((ROOT / "flow" / "measured.md").read_text())
    assert names == {*measured_tables.TABLES, *measured_tables.FUNCTIONS}
