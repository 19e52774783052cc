"""tests/verification/other_tables.py: the tables of docs/other-patients.md, from small files of results."""

import json
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "verification")]

import other_tables  # noqa: E402
from page_tables import TABLE_MARKS  # noqa: E402


def test_a_row_a_state_with_both_branches_and_empty_where_no_flow_is_known(tmp_path):
    (tmp_path / "study").mkdir()
    columns = [f"{state}_{area}_area_mm2" for state in ("pre", "vci", "post") for area in ("mean", "minimum")]
    (tmp_path / "study" / "cohort.csv").write_text(f"case,{','.join(columns)}\nculotte_lad,6,2,9,8,9.5,8.25\n")
    flow = tmp_path / "cases" / "culotte_lad" / "flow"
    probes = [{"name": "distal", "ffr": 0.7, "error_estimate": 0.004}, {"name": "side1", "ffr": 0.65}]
    for state, found in (("pre", probes), ("vci", probes[:1])):
        (flow / state).mkdir(parents=True)
        (flow / state / "ffr.json").write_text(json.dumps({"probes": found}))
    assert other_tables.lumens(tmp_path, "ivus_plaque") is None
    lines = other_tables.lumens(tmp_path, "culotte_lad").splitlines()
    assert lines[0] == "| state | FFR, `distal` | FFR, `side1` | mean area, mm2 | smallest area, mm2 |"
    assert lines[2:] == [
        "| pre | 0.700 ± 0.0040 | 0.650 | 6.00 | 2.00 |",
        "| vci | 0.700 ± 0.0040 |  | 9.00 | 8.00 |",
        "| post |  |  | 9.50 | 8.25 |",
    ]


def test_the_page_has_a_table_of_each_case():
    found = {name for _, name, _ in TABLE_MARKS.findall(other_tables.PAGE.path.read_text())}
    assert found == set(other_tables.CASES)
