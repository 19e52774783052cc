"""Tornado and Latin hypercube of a function that is known."""

import math

import pytest

from whatif import sampling
from whatif.flow_inputs import Input

INPUTS = [Input("a", "an input", -1.0, 0.0, 1.0, "%"), Input("b", "another", 0.5, 1.0, 2.0, "times", "log")]


def answers_at(values):
    return {("vci", "ffr"): 0.9 - 0.02 * values.get("a", 0.0) + 0.01 * math.log2(values.get("b", 1.0))}


def test_one_input_at_a_time():
    table = sampling.one_at_a_time(INPUTS, answers_at).set_index("input")
    assert table.loc["a", ["at_low", "at_planned", "at_high"]].tolist() == pytest.approx([0.92, 0.9, 0.88])
    assert table.loc["b", ["at_low", "at_planned", "at_high"]].tolist() == pytest.approx([0.89, 0.9, 0.91])


def test_an_end_without_an_answer_is_empty():
    table = sampling.one_at_a_time(INPUTS, lambda values: {} if values.get("a") == 1.0 else answers_at(values))
    assert table["at_high"].isna().tolist() == [True, False]


def test_a_hypercube_fills_every_range_evenly_and_is_the_same_again():
    found = sampling.latin_hypercube(INPUTS, 40)
    assert found == sampling.latin_hypercube(INPUTS, 40)
    strata = {math.floor(20 * (one["a"] + 1)) for one in found}
    assert strata == set(range(40))
    assert {math.floor(20 * (math.log2(one["b"]) + 1)) for one in found} == set(range(40))


def test_the_interval_is_the_middle_of_the_samples():
    """Only input a varies. FFR is then uniform from 0.88 to 0.92, and its middle 95 % is 0.881 to 0.919."""
    row = sampling.sample_intervals(INPUTS[:1], 400, answers_at).iloc[0]
    assert (row["lower"], row["upper"]) == pytest.approx((0.881, 0.919), abs=2e-4)
    assert (row["samples"], row["left_out"], row["inputs"]) == (400, 0, 1)


def test_samples_without_an_answer_are_counted():
    row = sampling.sample_intervals(
        INPUTS[:1], 40, lambda values: answers_at(values) if values.get("a", 0.0) >= 0 else {}
    )
    assert (row.iloc[0]["samples"], row.iloc[0]["left_out"]) == (20, 20)
