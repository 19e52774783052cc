"""The table of springs in vci/method.md has the figures that the C++ test of thin tubes asserts."""

import pathlib
import re

ROOT = pathlib.Path(__file__).parents[3]


def rows_of_page():
    page = (ROOT / "vci/method.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| ([\d.]+) \| (.*) \|$", page, re.MULTILINE)
    return [(mapping, float(nu), [float(v) for v in values.split("|")]) for mapping, nu, values in rows]


def rows_of_test():
    test = (ROOT / "tests/verification/vci/test_tubes.cpp").read_text(encoding="utf-8")
    rows = re.findall(r"\{SpringMapping::(\w+), ([\d.]+), \{([^}]*)\}\}", test)
    return [(mapping, float(nu), [float(v) for v in values.split(",")]) for mapping, nu, values in rows]


def test_springs_on_tubes():
    assert len(rows_of_test()) == 4
    assert rows_of_page() == rows_of_test()
