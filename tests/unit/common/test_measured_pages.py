"""The tables that stand in the measured.md of a part have the headings under which they are made anew."""

import importlib.util
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]


def _tables(part):
    """tests/verification/<part>/measured_tables.py as a module; both parts have one of that name."""
    file = ROOT / "tests" / "verification" / part / "measured_tables.py"
    spec = importlib.util.spec_from_file_location(f"{part}_measured_tables", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _headings(text):
    """{table: its headings} of a page."""
    found = re.findall(r"<!-- table: (\w+) -->\n\| (.*?) \|\n", text)
    return {name: line.split(" | ") for name, line in found}


def _written_headings(module):
    """{table: the headings that it is written with}."""
    headings = {name: list(columns.values()) for name, (_, columns) in module.TABLES.items()}
    if hasattr(module, "STUDY"):
        headings[module.STUDY] = list(module.STUDY_COLUMNS)
    return headings | {cohort: module.CONTRAST_HEADINGS for cohort in getattr(module, "PREFIXES", ())}


PAGES = {part: _tables(part) for part in ("flow", "vci")}
PLACES = [(part, name) for part, module in PAGES.items() for name in sorted(_written_headings(module))]


@pytest.mark.parametrize(("part", "name"), PLACES)
def test_a_table_has_the_headings_that_it_is_made_with(part, name):
    found = _headings((ROOT / part / "measured.md").read_text())
    assert found[name] == _written_headings(PAGES[part])[name], f"{part}/measured.md: write the table {name} anew"
