"""The README's tables are those of the benchmarks' files."""

import pathlib
import sys

import pytest

from common.errors import InputError

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "verification" / "flow"))

import readme_tables  # noqa: E402

TEXT = "before\n<!-- table: flow_hard_cases -->\nold\n<!-- end -->\nafter\n"


def _write(folder, leave_out=()):
    columns = [name for name in readme_tables.TABLES["flow_hard_cases"][1] if name not in leave_out]
    row = {name: "" for name in columns} | {"case": "single_62", "error": "0.00131"}
    (folder / "flow_hard_cases").mkdir()
    lines = [",".join(columns), ",".join(row[name] for name in columns)]
    (folder / "flow_hard_cases" / "hard_cases.csv").write_text("\n".join(lines) + "\n")


def test_a_table_is_that_of_the_file(tmp_path):
    _write(tmp_path)
    lines = readme_tables.filled(TEXT, tmp_path).splitlines()
    assert lines[0] == "before" and lines[-1] == "after" and "old" not in lines
    assert lines[2].startswith("| case | outcome |")
    assert lines[4].startswith("| single_62 |") and "| +0.0013 |" in lines[4]
    assert len(lines) == 7


def test_a_benchmark_that_was_not_run_leaves_its_table(tmp_path):
    assert readme_tables.filled(TEXT, tmp_path) == TEXT


def test_a_file_without_a_column_is_refused(tmp_path):
    _write(tmp_path, ["estimate"])
    with pytest.raises(InputError, match="estimate"):
        readme_tables.filled(TEXT, tmp_path)


def test_the_readme_names_tables_that_there_are():
    places = readme_tables.PLACE.findall((ROOT / "flow" / "README.md").read_text())
    assert {name for _, name, _ in places} == set(readme_tables.TABLES)
