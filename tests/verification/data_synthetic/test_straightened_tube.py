"""A stent straightens a bent tube in three dimensions: against the beams of the reference, and with a rigid stent."""

import numpy as np
import pytest

from common.documents import config
from common.implicit.curves import Curve
from data_synthetic import tree
from data_synthetic.reference.checks.straightening_in_solid import mean_curvature
from data_synthetic.reference.slices import slices
from data_synthetic.reference.slices.lumen import solve_lumen
from data_synthetic.reference.slices.slices import Patient
from data_synthetic.reference.straightening import beams
from data_synthetic.reference.tube.straightened import StraightenedTube
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


def beams_of(tube):
    """Straightening of the same tube by slices and beams."""
    patient = Patient(tube.branch, [tube.branch], WALL)
    return solve_lumen(slices.slice_model(tube.settings), patient, tube.steps, tube.settings).straightening


def test_a_cantilever_bends_and_shears():
    """Tip deflection under a force F at the tip: F L^3 / 3 EI + F L / kGA (Timoshenko), whatever the elements."""
    length, bending, shear = 7.0, 9.0, 0.5
    matrix = beams.vessel_matrix(np.array([0.0, 2.0, 3.0, 7.0]), bending, shear).toarray()
    force = np.zeros(len(matrix) - 2)
    force[-2] = 0.3
    tip = np.linalg.solve(matrix[2:, 2:], force)[-2]
    assert tip == pytest.approx(0.3 * (length**3 / (3 * bending) + length / shear), rel=1e-9)


def test_a_stepped_cantilever():
    """E I is given by elements: the tip's deflection is the integral of the moment times the lever over E I."""
    matrix = beams.vessel_matrix(np.array([0.0, 3.0, 7.0]), np.array([8.0, 2.0]), 1e9).toarray()
    tip = np.linalg.solve(matrix[2:, 2:], [0, 0, 1.0, 0])[-2]
    assert tip == pytest.approx((7**3 - 4**3) / (3 * 8.0) + 4**3 / (3 * 2.0), rel=1e-6)


def moved_inwards(s_mm, shift_mm):
    """Shift of the middle towards the centre of the arc, in mm."""
    return shift_mm[np.argmin(np.abs(s_mm - LENGTH / 2)), 1]


@pytest.mark.slow
def test_lumen_and_stent_move_as_by_the_beams():
    tube, shift, stent_shift = straightened(20.0)
    s, axis, found = tube.tube.station_s_mm, tube.branch.axis, beams_of(tube)
    inside = np.flatnonzero((s > SPAN[0] - 1e-6) & (s < SPAN[1] + 1e-6))
    assert moved_inwards(found.s_mm, found.lumen_shift()) == pytest.approx(moved_inwards(s, shift), rel=0.1)
    lumen = mean_curvature(axis, s, shift, SPAN)
    assert lumen < 0.9 / RADIUS_OF_BEND
    assert mean_curvature(axis, found.s_mm, found.lumen_shift(), SPAN) == pytest.approx(lumen, rel=0.1)
    stent = mean_curvature(axis, s[inside], stent_shift, SPAN)
    assert mean_curvature(axis, found.s_mm[found.stented], found.stent_mm, SPAN) == pytest.approx(stent, rel=0.1)
    assert np.abs(shift[:, 2]).max() < 1e-6, "it stays in its plane"
    assert shift == pytest.approx(shift[::-1] * [-1, 1, 1], abs=5e-3), "the tube is symmetric"


@pytest.mark.slow
def test_a_rigid_stent_is_straight_and_presses_the_wall_aside():
    """The rigid stent leaves the wall on one side, and the lumen bulges at the stent's ends."""
    tube, shift, stent_shift = straightened(1e4)
    s, axis, found = tube.tube.station_s_mm, tube.branch.axis, beams_of(tube)
    stented = (s > SPAN[0] - 1e-6) & (s < SPAN[1] + 1e-6)
    before = mean_curvature(axis, s, 0 * shift, SPAN)
    assert before == pytest.approx(1 / RADIUS_OF_BEND, rel=1e-3)
    assert mean_curvature(axis, s[stented], stent_shift, SPAN) < 0.02 * before
    lumen = mean_curvature(axis, s, shift, SPAN)
    assert before < lumen < 1.2 * before
    assert mean_curvature(axis, found.s_mm, found.lumen_shift(), SPAN) == pytest.approx(lumen, rel=0.1)
    assert moved_inwards(found.s_mm, found.lumen_shift()) == pytest.approx(moved_inwards(s, shift), rel=0.1)
    ends = tube.area_profile()[1][stented][[0, -1]]
    assert ends == pytest.approx([14.1, 14.1], abs=0.3), "wider than the 13.6 mm2 of the stent"
