"""The beams of stent and vessel compared with a closed form: error and its order, and balance of forces.

A vessel of uniform curvature c0 carries a straight stent of bending stiffness Es over |x| < a. Ev is the vessel's, k
its foundation, and K the resistance of its sections to the stent. D is the derivative by x. For small displacements w
of the stent and v of the vessel, Es D^4 w + K (w - v) = 0 and Ev D^4 v + k v - K (w - v) = 0 inside, and
Ev D^4 v + k v = 0 outside. At its ends the stent has no moment, Es (c0 + D^2 w) = 0, and no shear force. There v and
its first three derivatives are continuous. By symmetry six constants remain (Hetenyi, Beams on Elastic Foundation).
"""

import numpy as np
import pytest

from data_synthetic.reference.straightening import beams, stent_in_vessel
from data_synthetic.reference.treatment import devices

LENGTH, HALF, CURVATURE = 240.0, 9.0, 1e-3
DEVICE, VESSEL, FOUNDATION, RESISTANCE = 20.0, 8.0, 0.04, 0.3
STEPS = (1.5, 0.75, 0.375)
RIGID = 1e7  # N: a vessel that does not shear


class Arc:
    """An axis whose tangent turns at a constant rate, so its curvature is the constant vector (0, CURVATURE, 0)."""

    length_mm = LENGTH

    @staticmethod
    def frame(s_mm):
        turned = CURVATURE * (np.asarray(s_mm) - LENGTH / 2)
        return np.stack([np.ones_like(turned), turned, np.zeros_like(turned)], axis=-1), None, None


def stent(shift_mm=0.0):
    ends = LENGTH / 2 - HALF + shift_mm, LENGTH / 2 + HALF + shift_mm
    return devices.Stent("stent", *ends, 0.955, 0.22, DEVICE, 1.5, 0.5)


def sections(bending, shear, offset, force):
    """VesselSections of a uniform vessel whose law goes through the points (offset, force), each (k,)."""
    law = stent_in_vessel.SidewaysLaw(np.array(offset), np.array(force), 0.5 * np.array(offset))
    ends = np.array([0.0, LENGTH])
    return stent_in_vessel.VesselSections(ends, np.full(2, bending), np.full(2, shear), [(0.0, law), (LENGTH, law)])


LINEAR = sections(VESSEL, RIGID, (0, 0.01), (0, 0.01 * RESISTANCE))


def powers(rates):
    """Function: derivatives 0 to 3 (4, number of rates) of exp(rate x) at a place x."""
    return lambda x: np.array([rates**n * np.exp(rates * x) for n in range(4)])


def exact(x):
    """Displacements in mm of (stent, vessel), each (n,), at distances x (n,) from the stent's middle."""
    # (Es l^4 + K) (Ev l^4 + k + K) = K^2 for the rates l inside.
    quartic = np.roots(
        [DEVICE * VESSEL, DEVICE * (FOUNDATION + RESISTANCE) + VESSEL * RESISTANCE, RESISTANCE * FOUNDATION]
    )
    first = np.array([(v + 0j) ** 0.25 for v in quartic])
    rates = np.concatenate([first * 1j**n for n in range(4)])
    share = (DEVICE * rates**4 + RESISTANCE) / RESISTANCE  # v / w
    inside, outside = powers(rates), powers((FOUNDATION / (4 * VESSEL)) ** 0.25 * np.array([-1 + 1j, -1 - 1j]))
    # Unknowns: 8 constants inside and 2 outside. A rate and its negative have the same constant.
    end, beyond = inside(HALF), outside(HALF)
    rows = [np.append(end[n], [0, 0]) for n in (2, 3)]
    rows += [np.append(share * end[n], -beyond[n]) for n in range(4)]
    for i in range(8):
        j = int(np.argmin(np.abs(rates + rates[i])))
        if j > i:
            rows.append(np.eye(10)[i] - np.eye(10)[j])
    constants = np.linalg.solve(np.array(rows), [-CURVATURE] + 9 * [0])
    x = np.abs(np.asarray(x, float))
    in_x = np.array([inside(at)[0] for at in np.minimum(x, HALF)])
    out_x = np.array([outside(at)[0] for at in np.maximum(x, HALF)])
    vessel = np.where(x <= HALF, in_x @ (share * constants[:8]), out_x @ constants[8:])
    return (in_x @ constants[:8]).real, vessel.real


def errors_at(step_mm):
    """Largest errors of (stent, vessel) at a spacing of the beams' nodes, as shares of the largest displacements."""
    found = stent_in_vessel.straighten(Arc(), [stent()], LINEAR, FOUNDATION, step_mm)
    assert np.abs(found.vessel_mm[:, [0, 2]]).max() < 0.01 * np.abs(found.vessel_mm).max()
    x = found.s_mm - LENGTH / 2
    right = exact(x[found.stented])[0], exact(x)[1]
    return [np.abs(a[:, 1] - b).max() / np.abs(b).max() for a, b in zip((found.stent_mm, found.vessel_mm), right)]


def test_the_closed_form_keeps_its_conditions():
    """v is continuous and 0 far away; both are straightened, and the stent is free at its ends."""
    end = np.array([HALF - 1e-6, HALF + 1e-6, 70.0])
    v = exact(end)[1]
    assert v[0] == pytest.approx(v[1], abs=1e-7) and abs(v[2]) < 1e-3 * abs(v[0])
    x = np.linspace(HALF - 1, HALF, 201)
    assert np.gradient(np.gradient(exact(x)[0], 0.005), 0.005)[-4] == pytest.approx(-CURVATURE, rel=0.01)
    middle = np.linspace(-1, 1, 201)
    bent = [np.gradient(np.gradient(w, 0.01), 0.01)[100] for w in exact(middle)]
    assert -CURVATURE < min(bent) and max(bent) < -0.1 * CURVATURE


def test_straightening_converges_to_the_closed_form():
    """By the second order, since the foundation and the sections' resistance are lumped to the nodes."""
    errors = np.array([errors_at(step) for step in STEPS])
    assert np.log(errors[:-1] / errors[1:]) / np.log(2) == pytest.approx(np.full((2, 2), 2), abs=0.3)
    assert max(errors_at(beams.LARGEST_ELEMENT_MM)) < 2e-3


def test_ends_of_a_device_may_lie_anywhere():
    """With the study's spacing of nodes. The beams have nodes at the device's ends, wherever these are."""
    found = stent_in_vessel.straighten(Arc(), [stent(0.0617)], LINEAR, FOUNDATION)
    right = exact(found.s_mm - LENGTH / 2 - 0.0617)[1]
    assert np.abs(found.vessel_mm[:, 1] - right).max() < 2e-3 * np.abs(right).max()


HARDENING = (0.0, 2e-3, 5e-3, 2e-2), (0.0, 2e-4, 1e-3, 1e-2)
GAP = (0.0, 5e-3, 5.5e-3, 2e-2), (0.0, 1e-7, 2e-3, 0.1)  # the stent moves freely before it meets the wall


@pytest.mark.parametrize("points", [HARDENING, GAP])
def test_sections_that_harden_balance_the_stent(points):
    """The sections' forces hold the stent: they have no resultant and no moment, and follow the law."""
    found = stent_in_vessel.straighten(Arc(), [stent()], sections(VESSEL, 2.0, *points), FOUNDATION)
    x, force, offset = found.s_mm[found.stented] - LENGTH / 2, found.force_n_per_mm[:, 1], found.offset_mm[:, 1]
    assert np.trapz(force, x) == pytest.approx(0, abs=1e-3 * np.trapz(np.abs(force), x))
    assert np.trapz(x * force, x) == pytest.approx(0, abs=1e-3 * np.trapz(np.abs(x * force), x))
    assert np.abs(force) == pytest.approx(np.interp(np.abs(offset), *points), rel=1e-3, abs=1e-6)
    assert np.abs(offset).max() > points[0][2] and np.abs(offset).min() < points[0][1], "several parts are met"
    assert found.lumen_mm == pytest.approx(0.5 * found.offset_mm), "as this law has it"


def test_two_stents_apart_act_on_one_vessel():
    """Far from each other they do what each does alone."""
    far = [stent(-60.0), stent(60.0)]
    both = stent_in_vessel.straighten(Arc(), far, LINEAR, FOUNDATION)
    right = sum(exact(both.s_mm - LENGTH / 2 - shift)[1] for shift in (-60.0, 60.0))
    assert np.abs(both.vessel_mm[:, 1] - right).max() < 4e-3 * np.abs(right).max()


@pytest.mark.parametrize(
    "spans", [[(0, 18)], [(225, 245)], [(110, 122), (118, 130)], [(110, 120), (120, 130)], [(119.5, 120.5)]]
)
def test_unusual_places_of_stents(spans):
    """At the vessel's start, beyond its end, overlapping, touching, very short: the forces on the stents balance."""
    stents = [devices.Stent("stent", *span, 0.955, 0.22, DEVICE, 1.5, 0.5) for span in spans]
    found = stent_in_vessel.straighten(Arc(), stents, sections(VESSEL, 2.0, *HARDENING), FOUNDATION)
    force = found.force_n_per_mm[:, 1]
    x = found.s_mm[found.stented]
    assert np.trapz(np.abs(force), x) > 0
    assert np.trapz(force, x) == pytest.approx(0, abs=1e-3 * np.trapz(np.abs(force), x))


def test_without_a_stent_nothing_moves():
    none = stent_in_vessel.straighten(Arc(), [], LINEAR, FOUNDATION)
    assert np.all(none.vessel_mm == 0) and len(none.stent_mm) == 0 and np.all(none.lumen_shift() == 0)
