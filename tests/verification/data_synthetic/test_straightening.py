"""The beams of stent and vessel compared with a closed form: error and its order, and balance of forces.

A vessel of uniform curvature c0 carries a straight stent of bending stiffness Es over |x| < a. w and v are the small
shifts of stent and vessel, d = w - v. E and G are the vessel's bending and shear stiffness, k its foundation, K the
resistance of its sections to d, and C the stiffness of the wall that bends along the vessel. The vessel's beam has the
shift W = f w + (1 - f) v and the rotation T. With D the derivative by x and Q = G (D W - T) the shear force,

    Es D^4 w + C D^4 d - f D Q + K d = 0,   -C D^4 d - (1 - f) D Q + k v - K d = 0,   E D^2 T + Q = 0.

Beyond the stent Es = 0. At its ends w, v, D d, T, D T, D^2 d and both shear forces, Es D^3 w + C D^3 d - f Q and
-C D^3 d - (1 - f) Q, are continuous, and the stent has no moment: c0 + D^2 w = 0.
"""

import numpy as np
import pytest
import scipy.linalg

from data_synthetic.reference.straightening import beams, stent_in_vessel
from data_synthetic.reference.treatment import devices

LENGTH, HALF, CURVATURE = 240.0, 9.0, 1e-3
DEVICE, VESSEL, FOUNDATION, RESISTANCE = 20.0, 8.0, 0.04, 0.3
FOLLOWING, WALL = -0.2, 0.5
STEPS = (0.6, 0.3, 0.15)
SHEAR = 2.0


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
    law = stent_in_vessel.SidewaysLaw(np.array(offset), np.array(force), 0.5 * np.array(offset), FOLLOWING, WALL)
    ends = np.array([0.0, LENGTH])
    return stent_in_vessel.VesselSections(ends, np.full(2, bending), np.full(2, shear), [(0.0, law), (LENGTH, law)])


LINEAR = sections(VESSEL, SHEAR, (0, 0.01), (0, 0.01 * RESISTANCE))


DIFFERENCE, BEAM = np.array([1.0, -1.0]), np.array([FOLLOWING, 1 - FOLLOWING])


def modes(stent_bending):
    """(rates r (k,), shapes (3, k)) of the solutions (w, v, T / r) = shape * exp(r x), those with Re r > 0."""
    a = np.zeros((3, 3, 3))  # of the powers 0, 1, 2 of r^2
    a[2, :2, :2] = np.diag([stent_bending, 0.0]) + WALL * np.outer(DIFFERENCE, DIFFERENCE)
    a[1, :2, :2], a[1, :2, 2], a[1, 2, 2] = -SHEAR * np.outer(BEAM, BEAM), SHEAR * BEAM, -VESSEL
    a[0, :2, :2] = RESISTANCE * np.outer(DIFFERENCE, DIFFERENCE) + np.diag([0.0, FOUNDATION])
    a[0, 2, :2], a[0, 2, 2] = -SHEAR * BEAM, SHEAR
    zero, one = np.zeros((3, 3)), np.eye(3)
    squares, shapes = scipy.linalg.eig(np.block([[zero, one], [-a[0], -a[1]]]), np.block([[one, zero], [zero, a[2]]]))
    finite = np.isfinite(squares) & (np.abs(squares) < 1e6)
    rates = np.sqrt(squares[finite] + 0j)
    return rates, shapes[:3, finite]


def conditions(rates, shapes, stent_bending, x, mirrored):
    """Rows (9, k) at x of what the stent's end asks for: 8 quantities that are continuous, then the stent's D^2 w.

    The solutions are exp(r x); if mirrored, the even exp(r x) + exp(-r x).
    """

    def power(n):
        return rates**n * (np.exp(rates * x) + mirrored * (-1) ** n * np.exp(-rates * x))

    w, v, t = shapes
    d, shear = w - v, SHEAR * (BEAM @ shapes[:2] - t) * power(1)
    third = stent_bending * w * power(3) + WALL * d * power(3)
    return np.array(
        [w * power(0), v * power(0), d * power(1), t * power(1), t * power(2), d * power(2)]
        + [third - FOLLOWING * shear, -WALL * d * power(3) - (1 - FOLLOWING) * shear, w * power(2)]
    )


def exact(x):
    """Displacements (2, n) in mm of stent and vessel at distances x (n,) from the stent's middle.

    Beyond the stent the first is the shift of the wall that follows it.
    """
    (rate_in, shape_in), (rate_out, shape_out) = modes(DEVICE), modes(0.0)
    assert len(rate_in) == 5 and len(rate_out) == 4
    inside = conditions(rate_in, shape_in, DEVICE, HALF, mirrored=True)
    outside = conditions(-rate_out, shape_out, 0.0, 0.0, mirrored=False)
    outside[8] = 0  # the stent's moment is asked for inside alone
    constants = np.linalg.solve(np.hstack([inside, -outside]), np.append(np.zeros(8), -CURVATURE))
    within, beyond = constants[:5], constants[5:]
    return np.array(
        [
            (
                (shape_in[:2] * 2 * np.cosh(rate_in * y)) @ within
                if y <= HALF
                else (shape_out[:2] * np.exp(-rate_out * (y - HALF))) @ beyond
            ).real
            for y in np.abs(x)
        ]
    ).T


def errors_at(step_mm):
    """Largest errors of (stent, vessel) at a spacing of the beams' nodes, as shares of the largest displacements."""
    found = stent_in_vessel.straighten(Arc(), [stent()], LINEAR, FOUNDATION, step_mm)
    assert np.abs(found.vessel_mm[:, [0, 2]]).max() < 0.01 * np.abs(found.vessel_mm).max()
    x = found.s_mm - LENGTH / 2
    right = exact(x[found.stented])[0], exact(x)[1]
    return [np.abs(a[:, 1] - b).max() / np.abs(b).max() for a, b in zip((found.stent_mm, found.vessel_mm), right)]


def test_the_closed_form_keeps_its_conditions():
    """Stent and vessel are continuous and 0 far away. Both are straightened."""
    ends = exact(np.array([HALF - 1e-6, HALF + 1e-6, 70.0]))
    assert ends[:, 0] == pytest.approx(ends[:, 1], abs=1e-7)
    assert np.abs(ends[:, 2]).max() < 1e-3 * np.abs(ends).max()
    middle = np.linspace(-1, 1, 201)
    bent = [np.gradient(np.gradient(w, 0.01), 0.01)[100] for w in exact(middle)]
    assert -CURVATURE < min(bent) and max(bent) < -0.1 * CURVATURE


def test_straightening_converges_to_the_closed_form():
    """By the second order, since the foundation and the sections' resistance are lumped to the nodes.

    The closed form ignores that the axis turns by 0.01 along the stent. This is 5e-5 of the displacements.
    """
    errors = np.array([errors_at(step) for step in STEPS])
    assert np.log(errors[:-1] / errors[1:]) / np.log(2) == pytest.approx(np.full((2, 2), 2), abs=0.35)
    assert max(errors_at(beams.LARGEST_ELEMENT_MM)) < 2e-3


def test_ends_of_a_device_may_lie_anywhere():
    """With the study's spacing of nodes. The beams have nodes at the device's ends, wherever these are."""
    found = stent_in_vessel.straighten(Arc(), [stent(0.0617)], LINEAR, FOUNDATION)
    right = exact(found.s_mm - LENGTH / 2 - 0.0617)[1]
    assert np.abs(found.vessel_mm[:, 1] - right).max() < 2e-3 * np.abs(right).max()


HARDENING = (0.0, 1e-3, 3e-3, 2e-2), (0.0, 1e-4, 8e-4, 1e-2)
GAP = (0.0, 5e-3, 5.5e-3, 2e-2), (0.0, 1e-7, 2e-3, 0.1)  # the stent moves freely before it meets the wall


@pytest.mark.parametrize("points", [HARDENING, GAP])
def test_sections_that_harden_balance_the_stent(points):
    """The sections' forces hold the stent: they have no resultant and no moment, and follow the law."""
    vessel = sections(VESSEL, SHEAR, *points)
    found = stent_in_vessel.straighten(Arc(), [stent()], vessel, FOUNDATION)
    x, force, offset = found.s_mm - LENGTH / 2, found.force_n_per_mm[:, 1], found.offset_mm[:, 1]
    assert np.trapz(force, x) == pytest.approx(0, abs=1e-3 * np.trapz(np.abs(force), x))
    assert np.trapz(x * force, x) == pytest.approx(0, abs=1e-3 * np.trapz(np.abs(x * force), x))
    law = vessel.laws[0][1]
    assert np.abs(force) == pytest.approx([law.at(d)[0] for d in np.abs(offset)], rel=1e-3, abs=2e-6)
    assert np.abs(offset).max() > points[0][1] > np.abs(offset).min(), "several parts are met"
    assert found.lumen_mm == pytest.approx(0.5 * found.offset_mm), "as this law has it"


def test_a_law_goes_through_its_points_and_on_as_a_line():
    law = sections(VESSEL, SHEAR, *HARDENING).laws[0][1]
    at = np.array([law.at(d) for d in HARDENING[0]])
    assert at[:, 0] == pytest.approx(HARDENING[1]) and at[:, 2] == pytest.approx(0.5 * np.array(HARDENING[0]))
    (last, slope, _), (beyond, same, lumen) = law.at(2e-2), law.at(3e-2)
    assert beyond == pytest.approx(last + 1e-2 * slope) and same == slope and lumen == pytest.approx(1.5e-2)


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
    found = stent_in_vessel.straighten(Arc(), stents, sections(VESSEL, SHEAR, *HARDENING), FOUNDATION)
    force = found.force_n_per_mm[:, 1]
    x = found.s_mm
    assert np.trapz(np.abs(force), x) > 0
    assert np.trapz(force, x) == pytest.approx(0, abs=1e-3 * np.trapz(np.abs(force), x))


def test_without_a_stent_nothing_moves():
    none = stent_in_vessel.straighten(Arc(), [], LINEAR, FOUNDATION)
    assert np.all(none.vessel_mm == 0) and len(none.stent_mm) == 0 and np.all(none.lumen_shift() == 0)
