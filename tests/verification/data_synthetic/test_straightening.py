"""The straightening beam compared with the closed form of a beam on an elastic foundation: error and its order.

A vessel of uniform curvature c0 carries a straight device of bending stiffness Es over |x| < a; Ev is the vessel's. For
small displacements (Es + Ev) w'''' + k w = 0 inside the device and Ev w'''' + k w = 0 outside. The moment inside is
Es (c0 + w'') + Ev w''. At the device's end w, w', the moment and the shear force are continuous. By symmetry four
constants remain (Hetenyi, Beams on Elastic Foundation).
"""

import numpy as np
import pytest

from data_synthetic.reference.surface import straightening
from data_synthetic.reference.treatment import devices

LENGTH, HALF, CURVATURE = 240.0, 9.0, 0.01
DEVICE, VESSEL, FOUNDATION = 20.0, 8.0, 0.04
STEPS = (6.0, 3.0, 1.5)


class Arc:
    """An axis whose tangent turns at a constant rate, so its curvature is the constant vector (0, CURVATURE, 0)."""

    length_mm = LENGTH

    @staticmethod
    def frame(s_mm):
        turned = CURVATURE * (np.asarray(s_mm) - LENGTH / 2)
        return np.stack([np.ones_like(turned), turned, np.zeros_like(turned)], axis=-1), None, None


def exact(x):
    """Displacement w (n,) in mm at distances x (n,) from the device's middle."""
    inside, outside = ((FOUNDATION / (4 * e)) ** 0.25 for e in (DEVICE + VESSEL, VESSEL))

    def powers(r):
        """[w, w', w'', w'''] of exp(r x) for complex r, x >= 0."""
        return lambda at: np.array([r**n * np.exp(r * at) for n in range(4)])

    r_in, r_out = inside * (1 + 1j), outside * (-1 + 1j)
    grow, back = powers(r_in), powers(-r_in)
    even = lambda at: 0.5 * (grow(at) + back(at))  # noqa: E731  real and imaginary part: the two even solutions
    fall = powers(r_out)
    stiff, soft = DEVICE + VESSEL, VESSEL
    rows = []
    for solution, scale in ((even, (1, 1, stiff, stiff)), (fall, (-1, -1, -soft, -soft))):
        value = solution(HALF) * np.array(scale)
        rows += [value.real, value.imag]
    a, b, c, d = np.linalg.solve(np.array(rows).T, [0, 0, -DEVICE * CURVATURE, 0])
    x = np.abs(x)
    within, beyond = even(np.minimum(x, HALF))[0], fall(np.maximum(x, HALF))[0]
    return np.where(x <= HALF, a * within.real + b * within.imag, c * beyond.real + d * beyond.imag)


def beam_error(step_mm):
    """(largest error, largest displacement) in mm at a spacing of the beam's nodes."""
    stent = devices.Stent("stent", LENGTH / 2 - HALF, LENGTH / 2 + HALF, 0.955, 0.22, DEVICE, 1.5, 0.5)
    s, w = straightening.beam_displacement(Arc(), [stent], VESSEL, FOUNDATION, step_mm)
    assert np.abs(w[:, [0, 2]]).max() < 1e-12
    right = exact(s - LENGTH / 2)
    return np.abs(w[:, 1] - right).max(), np.abs(right).max()


def test_the_closed_form_keeps_its_conditions():
    """Far from the device w is 0, at the device's end w is continuous, and the middle of the device is straightened."""
    x = np.array([HALF - 1e-6, HALF + 1e-6, 55.0])
    w = exact(x)
    assert w[0] == pytest.approx(w[1], abs=1e-7) and abs(w[2]) < 2e-5
    bent = np.gradient(np.gradient(exact(np.linspace(-1, 1, 201)), 0.01), 0.01)[100]
    assert -CURVATURE < bent < -0.1 * CURVATURE


def test_straightening_converges_to_the_closed_form():
    errors, largest = zip(*(beam_error(step) for step in STEPS))
    assert errors[-1] < 1e-4 * max(largest)
    slopes = np.log(np.array(errors[:-1]) / errors[1:]) / np.log(2)
    assert slopes == pytest.approx(4, abs=0.3)


def test_ends_of_a_device_may_lie_anywhere():
    """With the study's spacing of nodes. The beam has nodes at the device's ends, wherever these are."""
    stent = devices.Stent(
        "stent", LENGTH / 2 - HALF + 0.0617, LENGTH / 2 + HALF + 0.0617, 0.955, 0.22, DEVICE, 1.5, 0.5
    )
    s, w = straightening.beam_displacement(Arc(), [stent], VESSEL, FOUNDATION)
    right = exact(s - LENGTH / 2 - 0.0617)
    assert np.abs(w[:, 1] - right).max() < 1e-6 * np.abs(right).max()


def test_bending_of_the_wall():
    """The wall's bending stiffness is 6 C10 times its second moment of area, here integrated over the ring."""
    y, z = np.meshgrid(*2 * [np.linspace(-3, 3, 2001)])
    r = np.hypot(y, z)
    moment = np.sum(y[(r > 2.0) & (r < 2.7)] ** 2) * (6 / 2000) ** 2
    assert straightening.wall_bending_n_mm2(2.0, 2.7, 0.05) == pytest.approx(0.3 * moment, rel=2e-3)
