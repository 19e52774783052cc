"""Answers with one input at a time at its limits, and with all inputs drawn from a small Latin hypercube."""

import numpy as np
import pandas as pd
from scipy.stats import qmc

COLUMNS = ["state", "quantity", "input", "words", "unit", "low", "planned", "high", "at_low", "at_planned", "at_high"]
INTERVAL = (2.5, 97.5)  # percentiles of the samples' answers, the ends of an interval
INTERVAL_COLUMNS = ["state", "quantity", "planned", "lower", "upper", "samples", "left_out", "inputs"]
SEED = 24


def tornado(inputs, answers_at):
    """DataFrame with COLUMNS, one row for each input and answer. inputs: [Input] (whatif.flow_inputs).

    answers_at: function of {input's name: value} that returns {(state, quantity): value}, or {} if there is no answer.
    answers_at({}) gives the answers of the planned case.
    """
    planned, rows = answers_at({}), []
    for one in inputs:
        ends = {end: answers_at({one.name: getattr(one, end)}) for end in ("low", "high")}
        for (state, quantity), value in planned.items():
            row = {"state": state, "quantity": quantity, "input": one.name, "words": one.words, "unit": one.unit}
            row |= {end: getattr(one, end) for end in ("low", "planned", "high")}
            row |= {f"at_{end}": ends[end].get((state, quantity)) for end in ends} | {"at_planned": value}
            rows.append(row)
    return pd.DataFrame(rows, columns=COLUMNS)


def samples(inputs, count, seed=SEED):
    """`count` samples [{input's name: value}] of a Latin hypercube between low and high of each input.

    The same seed gives the same samples.
    """
    unit = qmc.LatinHypercube(d=len(inputs), seed=seed).random(count)
    return [{one.name: _between(one, share) for one, share in zip(inputs, row)} for row in unit]


def _between(one, share):
    if one.scale == "log":
        return float(one.low * (one.high / one.low) ** share)
    return float(one.low + share * (one.high - one.low))


def intervals(inputs, count, answers_at):
    """DataFrame with INTERVAL_COLUMNS: the middle 95 % of the answers at `count` samples of a Latin hypercube.

    left_out: number of samples without an answer. answers_at: as for `tornado`.
    """
    planned = answers_at({})
    found = [answers_at(values) for values in samples(inputs, count)]
    rows = []
    for (state, quantity), value in planned.items():
        values = [answers[state, quantity] for answers in found if answers.get((state, quantity)) is not None]
        lower, upper = np.percentile(values, INTERVAL) if values else (None, None)
        rows.append((state, quantity, value, lower, upper, len(values), count - len(values), len(inputs)))
    return pd.DataFrame(rows, columns=INTERVAL_COLUMNS)
