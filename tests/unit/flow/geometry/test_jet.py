"""The jet behind a narrowing starts with the throat's radius and widens slowly."""

import numpy as np
import pytest

import tubes
from flow.geometry import jet


def test_jet_keeps_the_throat_and_widens_slowly():
    branch = tubes.centre_branch(40, tubes.lesion(1.5, 0.6, 15, 10))
    radius = jet.jet_radius(branch, 0.1)
    s = branch.s_mm
    assert radius[s <= 15] == pytest.approx(branch.radius_mm[s <= 15])
    # The jet leaves the wall where the wall's slope exceeds the spread. From there its radius grows by the spread.
    behind = (s > 20) & (s < 24)
    assert np.diff(radius[behind]) == pytest.approx(0.1 * np.diff(s[behind]))
    assert 0.6 < radius[np.searchsorted(s, 15.5)] < 0.65
    assert radius[-1] == pytest.approx(1.5)


def test_no_jet_in_a_tapering_vessel():
    branch = tubes.centre_branch(40, lambda s: 1.5 - 0.01 * s)
    assert jet.jet_radius(branch, 0.1) == pytest.approx(branch.radius_mm)
