"""A stent straightens a bent tube in three dimensions: against a beam that shears, and with a rigid stent."""

import numpy as np
import pytest

from common.documents import config
from common.implicit.curves import Curve
from data_synthetic import tree
from data_synthetic.reference.checks.straightening_in_solid import mean_curvature
from data_synthetic.reference.slices.slices import Patient
from data_synthetic.reference.surface import straightening
from data_synthetic.reference.tube.straightened import StraightenedTube, _timoshenko_matrix
from data_synthetic.reference.treatment.devices import Balloon, Stent, Step

RADIUS_OF_BEND, LENGTH, HALF, INNER, WALL = 50.0, 40.0, 9.0, 2.0, 0.7
SPAN = (LENGTH / 2 - HALF, LENGTH / 2 + HALF)


def straightened(stent_bending):
    """(StraightenedTube, shifts of lumen and stent) of a uniform healthy tube along an arc."""
    angle = np.linspace(-LENGTH / 2, LENGTH / 2, 401) / RADIUS_OF_BEND
    axis = Curve(RADIUS_OF_BEND * np.stack([np.sin(angle), 1 - np.cos(angle), 0 * angle], axis=1))
    radius = np.full(len(axis.s_mm), INNER)
    branch = tree.Branch("main", "", 0.0, axis, radius, radius, np.zeros((len(radius), 3)))
    stent = Stent("stent", *SPAN, 0.99, 2.0, stent_bending, 1.05 * INNER, 0.6)
    balloon = Balloon("balloon", LENGTH / 2, 2 * HALF, 2.0, 1.05 * INNER, 5.0, 4.0)
    step = Step("stent", "stent", balloon, stent)
    settings = config.load_section(None, "reference")
    tube = StraightenedTube(Patient(branch, [branch], WALL), [step], settings, (6, 2, 3.0))
    tube.run()
    return tube, *tube.straighten()


def test_a_cantilever_bends_and_shears():
    """Tip deflection under a force F at the tip: F L^3 / 3 EI + F L / kGA (Timoshenko), whatever the elements."""
    length, bending, shear = 7.0, 9.0, 0.5
    matrix = _timoshenko_matrix(np.array([2.0, 1.0, 4.0]), bending, shear, 0.0)
    force = np.zeros(len(matrix) - 2)
    force[-2] = 0.3
    tip = np.linalg.solve(matrix[2:, 2:], force)[-2]
    assert tip == pytest.approx(0.3 * (length**3 / (3 * bending) + length / shear), rel=1e-9)


@pytest.mark.slow
def test_the_tube_is_straightened_more_like_a_beam_that_shears():
    tube, shift, _ = straightened(20.0)
    s = tube.tube.station_s_mm
    inside = np.flatnonzero((s > SPAN[0] - 1e-6) & (s < SPAN[1] + 1e-6))
    stent, load = tube._stent_beam(s[inside])
    sheared = np.linalg.solve(stent + tube._vessel_beam(inside)[0], load)[len(inside) // 2, 1]
    stents = [step.stent for step in tube.steps]
    beam_s, beam = straightening.axis_displacement(tube.branch, WALL, stents, LENGTH / 2, tube.settings)
    unsheared = beam[np.argmin(np.abs(beam_s - LENGTH / 2)), 1]
    found = shift[np.argmin(np.abs(s - LENGTH / 2)), 1]  # towards the centre of the arc
    assert found == pytest.approx(sheared, rel=0.2)  # the tube also gives way locally at the ends of the stent
    assert found > 1.4 * unsheared
    assert np.abs(shift[:, 2]).max() < 1e-6, "it stays in its plane"
    assert shift == pytest.approx(shift[::-1] * [-1, 1, 1], abs=5e-3), "the tube is symmetric"


@pytest.mark.slow
def test_a_rigid_stent_is_straight_and_the_lumen_follows_it_in_part():
    """The rigid stent leaves the wall on one side, and the lumen gets oval."""
    tube, shift, stent_shift = straightened(1e4)
    s, axis = tube.tube.station_s_mm, tube.branch.axis
    stented = (s > SPAN[0] - 1e-6) & (s < SPAN[1] + 1e-6)
    before = mean_curvature(axis, s, 0 * shift, SPAN)
    assert before == pytest.approx(1 / RADIUS_OF_BEND, rel=1e-3)
    assert mean_curvature(axis, s[stented], stent_shift, SPAN) < 0.02 * before
    assert 0.5 * before < mean_curvature(axis, s, shift, SPAN) < 0.9 * before
