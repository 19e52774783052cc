"""Answers with one input at a time at its limits, and with all inputs drawn from a small Latin hypercube."""

import numpy as np
import pandas as pd
from scipy.stats import qmc

COLUMNS = ["state", "quantity", "input", "words", "unit", "low", "planned", "high", "at_low", "at_planned", "at_high"]
INTERVAL_PERCENTILES = (2.5, 97.5)  # percentiles of the samples' answers at the ends of an interval
INTERVAL_COLUMNS = ["state", "quantity", "planned", "lower", "upper", "samples", "left_out", "inputs"]
SEED = 24


def one_at_a_time(inputs, answers_at):
    """DataFrame with COLUMNS, one row for each input and answer. inputs: [Input] (whatif.flow_inputs).

    answers_at: function of {input's name: value} that returns {(state, quantity): value}, or {} if there is no answer.
    answers_at({}) gives the answers of the planned case.
    """
    planned, rows = answers_at({}), []
    for varied in inputs:
        answers_at_end = {end: answers_at({varied.name: getattr(varied, end)}) for end in ("low", "high")}
        for (state, quantity), value in planned.items():
            row = {
                "state": state,
                "quantity": quantity,
                "input": varied.name,
                "words": varied.label,
                "unit": varied.unit,
            }
            row |= {end: getattr(varied, end) for end in ("low", "planned", "high")}
            row |= {f"at_{end}": answers_at_end[end].get((state, quantity)) for end in answers_at_end} | {
                "at_planned": value
            }
            rows.append(row)
    return pd.DataFrame(rows, columns=COLUMNS)


def latin_hypercube(inputs, count, seed=SEED):
    """`count` samples [{input's name: value}] of a Latin hypercube between low and high of each input.

    The same seed gives the same samples.
    """
    unit = qmc.LatinHypercube(d=len(inputs), seed=seed).random(count)
    return [{varied.name: _value_at_share(varied, share) for varied, share in zip(inputs, row)} for row in unit]


def _value_at_share(varied, share):
    if varied.scale == "log":
        return float(varied.low * (varied.high / varied.low) ** share)
    return float(varied.low + share * (varied.high - varied.low))


def sample_intervals(inputs, count, answers_at):
    """DataFrame with INTERVAL_COLUMNS: the middle 95 % of the answers at `count` samples of a Latin hypercube.

    left_out: number of samples without an answer. answers_at: as for `one_at_a_time`.
    """
    planned = answers_at({})
    sample_answers = [answers_at(values) for values in latin_hypercube(inputs, count)]
    rows = []
    for (state, quantity), value in planned.items():
        values = [answers[state, quantity] for answers in sample_answers if answers.get((state, quantity)) is not None]
        lower, upper = np.percentile(values, INTERVAL_PERCENTILES) if values else (None, None)
        rows.append((state, quantity, value, lower, upper, len(values), count - len(values), len(inputs)))
    return pd.DataFrame(rows, columns=INTERVAL_COLUMNS)
