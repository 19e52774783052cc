"""The table by which the strength of calcium was chosen."""

import pytest

from common.documents import schema
from vci.benchmarks import calcium_strength


def test_change_is_the_slope_over_the_arcs():
    """Expansion falls by 3 % for 90 degrees; of two runs at 180 degrees one is refused."""
    row = calcium_strength.strength_row((20.0, 0.06, 0.05), {90: [82, 84], 180: [80, None], 270: [77, 77]})
    assert row["change_percent"] == pytest.approx(-6)
    assert row["expansion_90_percent"] == 83 and row["spread_percent"] == pytest.approx(100 * 2 / 82)
    assert row["refused"] == "1 of 6" and row["strength_mpa"] == pytest.approx(1.2)


def test_an_arc_without_a_run_leaves_the_change_empty():
    row = calcium_strength.strength_row((30.0, None, 0.0), {90: [82], 180: [None], 270: [61]})
    assert "change_percent" not in row and "expansion_180_percent" not in row and "strength_mpa" not in row
    assert row["yield_strain"] == "never" and row["refused"] == "1 of 3"


def test_a_law_of_which_every_run_is_refused_has_a_row():
    row = calcium_strength.strength_row((30.0, 0.02, 0.0), {90: [None], 270: [None]})
    assert row["refused"] == "2 of 2" and "spread_percent" not in row


def test_the_default_is_that_of_the_engine():
    """The engine's default is also a row of the table, so that the table shows the strength that the study uses."""
    settings = schema.with_defaults({}, schema.read("deployment"))
    calcium = settings["wall"]["plaque"]["calcified"]
    assert tuple(calcium[key] for key in calcium_strength.KEYS) == calcium_strength.DEFAULT
    assert calcium_strength.DEFAULT in calcium_strength.STRENGTHS
