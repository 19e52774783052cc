"""The benchmark of the FDA's nozzle: the comparison of velocities with the laboratories', and the reattachment."""

import pathlib
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "verification" / "flow"))

import fda_jet  # noqa: E402
import fda_nozzle  # noqa: E402


def test_a_jet_too_fast_by_more_than_two_deviations_is_not_within():
    values = fda_nozzle.VELOCITY_ORIGINAL.copy()
    values[3] += 2.1 * fda_nozzle.SPREAD_ORIGINAL[3]
    values[4] += 1.9 * fda_nozzle.SPREAD_ORIGINAL[4]
    assert fda_jet.count_within(values) == "8 of 9"


def test_a_flow_that_never_turns_is_said():
    z = np.linspace(2, 118, 5)
    assert fda_jet.reattachment(z, -np.ones(5)) == "behind 118"
    assert fda_jet.reattachment(z, np.ones(5)) == "nowhere upstream"
    assert fda_jet.reattachment(z, z - 70.25) == "70.2"
