"""A lumen with another radius: every section changes except those that a stent holds."""

import numpy as np
import pytest

from common.errors import InputError
from whatif import segmentation, sensitivity

CASE = """kind: surface
description: x
patient: {lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80}
lumen: {path: a.stl, units: mm}
plan: auto
"""


def radii(lumen):
    return np.sqrt(lumen[1]["area_mm2"].to_numpy() / np.pi)


def test_all_radii_move_alike_but_for_those_that_a_stent_holds(vessel):
    lumen = vessel.lumen("pre")
    assert radii(segmentation.with_radius_change(lumen, -0.1)) == pytest.approx(0.9)
    found, s = segmentation.with_radius_change(lumen, 0.1, [("main", 10, 18), ("main", 20, 28)]), lumen[1]["s_mm"]
    assert radii(found) == pytest.approx(np.where((s >= 10) & (s <= 18) | (s >= 20) & (s <= 28), 1.0, 1.1))
    assert radii(segmentation.with_radius_change(lumen, 0.1, [("side1", 10.0, 28.0)])) == pytest.approx(1.1)
    assert radii(lumen) == pytest.approx(1.0), "the lumen itself is left alone"


def test_only_stents_hold_and_where_they_lie(vessel):
    assert segmentation.stented_spans(vessel.scene) == [("main", 10.0, 28.0)]
    moved = sensitivity.scene_with_inputs(vessel.scene, {"placement": 2.0})
    assert segmentation.stented_spans(moved) == [("main", 12.0, 30.0)]
    vessel.scene["devices"]["des"]["kind"] = "balloon"
    assert segmentation.stented_spans(vessel.scene) == []


def test_a_varied_procedure_holds_its_own_stretch(vessel, tmp_path):
    """In the same lumen the image's error changes the loss more if no stent holds a part of it."""
    file = tmp_path / "case.yaml"
    file.write_text(CASE)
    answers, lumen, off = sensitivity.VariedFlow(vessel, file), vessel.lumen("vci"), {segmentation.RADIUS_INPUT: -0.02}
    balloons, document = {"devices": {}, "procedure": []}, answers.boundary_at(off)
    losses = [answers.loss("vci", document, off, (scene, lumen)) for scene in (vessel.scene, balloons)]
    assert losses[0] == answers.loss("vci", document, off) and losses[1] > 1.01 * losses[0]


def test_a_lumen_that_would_vanish_is_refused(vessel):
    with pytest.raises(InputError, match="no lumen is left"):
        segmentation.with_radius_change(vessel.lumen("pre"), -1.0)


def test_the_true_radius_is_the_found_one_minus_the_error():
    one = segmentation.radius_input()
    assert 0.5 * (one.low + one.high) == pytest.approx(-segmentation.RADIUS_BIAS_MM)
    assert one.high - one.low == pytest.approx(2 * segmentation.RADIUS_SD_MM) and one.low < 0 < one.high


def test_a_narrower_lumen_has_a_lower_ffr_as_poiseuille_says(vessel, tmp_path):
    file = tmp_path / "case.yaml"
    file.write_text(CASE)
    answers = sensitivity.VariedFlow(vessel, file)
    assert segmentation.RADIUS_INPUT in [one.name for one in answers.inputs]
    planned, narrow = answers.ffr_of_states({}), answers.ffr_of_states({segmentation.RADIUS_INPUT: -0.02})
    grown = {state: (1 - narrow[state, "ffr"]) / (1 - planned[state, "ffr"]) for state in ("pre", "vci")}
    # The loss grows with 1 / r^4. A larger loss lowers the flow, so it grows a little less.
    assert 1.04 < grown["pre"] < 0.98**-4
    free = 1 - 18.0 / (vessel.boundary["probes"][0]["s_mm"] - 0.5)  # share of the length upstream of the probe
    all_free = (1 - 0.02 / 1.4) ** -4
    assert grown["vci"] == pytest.approx(1 + free * (all_free - 1), abs=0.006) and grown["vci"] < all_free - 0.02
