"""vci/constants.md lists the constants of the solver with the values that the code has."""

import re

import pytest
from tests.support.places import ROOT

SOURCES = [
    *sorted((ROOT / "vci" / "solver").glob("*.?pp")),
    *(ROOT / "vci" / "contact" / f"{name}.cpp" for name in ("contact", "surface_projection", "self_contact")),
]
PAGE = ROOT / "vci" / "constants.md"
NOT_LISTED = {"least"}  # the square of another constant


def code_constants():
    """{name: value} of the constants of type double or int in SOURCES."""
    found = {}
    for path in SOURCES:
        for declared in re.findall(r"\bconstexpr (?:double|int) ([^;]+);", path.read_text(encoding="utf-8")):
            for name, value in re.findall(r"(\w+) = ([-\w.]+)", declared):
                assert name not in found, f"{name} stands in two files"
                found[name] = value
    return {name: float(value) for name, value in found.items() if name not in NOT_LISTED}


def test_each_constant_stands_on_the_page_with_its_value():
    rows = re.findall(r"^\| `(\w+)` \| ([^|]+) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert {name: float(value) for name, value in rows} == pytest.approx(code_constants(), rel=0, abs=0)
    assert len(rows) == len(dict(rows)) > 20
