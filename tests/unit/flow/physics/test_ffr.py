"""Warnings name probes whose FFR depends on their exact place."""

import numpy as np
import pandas as pd
import pytest

import tubes
from flow.geometry import centreline
from flow.physics import ffr


def _line(slopes):
    """A pull-back of 40 mm on `main`, whose FFR falls to 0.6 at 10 mm.

    slopes: {place in mm: change of FFR per mm that is added from there on}.
    """
    s = np.arange(0, 40.5, 0.5)
    value = 1 - 0.04 * np.minimum(s, 10)
    for start, slope in slopes.items():
        value += slope * np.clip(s - start, 0, None)
    return pd.DataFrame({"branch": "main", "s_mm": s, "ffr": value})


def _probe(name, s_mm, branch="main"):
    return {"name": name, "branch": branch, "s_mm": s_mm}


def test_a_probe_in_a_jet_that_has_not_reattached_is_named():
    table = _line({10.0: 0.003, 30.0: -0.0035})  # pressure recovers up to 30 mm; then friction lowers it
    found = ffr.slope_warnings([_probe("distal", 20.3), _probe("far", 35.0), _probe("throat", 5.0)], table)
    assert len(found) == 1
    assert "distal" in found[0] and "0.0030 a mm" in found[0]


@pytest.mark.parametrize(("slope", "said"), [(4e-4, 0), (6e-4, 1)])
def test_a_slow_rise_is_let_pass(slope, said):
    assert len(ffr.slope_warnings([_probe("distal", 20.0)], _line({10.0: slope}))) == said


def test_only_the_probes_own_branch_counts():
    table = _line({10.0: 0.003})
    assert ffr.slope_warnings([_probe("end_side1", 20.0, "side1")], table) == []


def _displaced(shift_mm, kept):
    """The warnings of a probe at this distance from the axis of a tube (radius 1.2 mm, length 16 mm). `kept` of its 33
    points lie in the mesh."""
    tree = centreline.Tree([tubes.centre_branch(16.0, lambda s: 1.2)])
    probe = _probe("distal", 12.0) | {"shift_mm": shift_mm}
    s = np.linspace(0, 16, 33)[:kept]
    return ffr.displacement_warnings([probe], tree, pd.DataFrame({"branch": "main", "s_mm": s, "ffr": 1.0}))


def test_a_centreline_beside_the_lumen_is_said():
    assert _displaced(0.59, 33) == []
    (shifted,) = _displaced(0.61, 33)
    assert "distal" in shifted and "0.61 mm" in shifted
    (dropped,) = _displaced(0.0, 28)
    assert "5 of 33 points" in dropped and "main" in dropped
