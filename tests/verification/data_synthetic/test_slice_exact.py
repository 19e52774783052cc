"""The slice model against exact solutions of a thick tube in plane strain."""

import numpy as np
import pytest
from scipy.integrate import quad

from data_synthetic.reference.slices.model import SliceModel
from data_synthetic.reference.solid import materials
from data_synthetic.reference.treatment import procedure

INNER, OUTER = 0.56, 2.4
NO_SUPPORT = 1e-6  # MPa/mm: so weak that it only prevents rigid motion
STIFF = 10.0  # MPa/mm: a device so stiff that it nearly prescribes the radius; the remaining gap gives its pressure


def tube(share, shear, yield_stress, hardening, bulk, c10=0.05, c20=0.2, around=16, through=6):
    """A concentric tube of one material in a SliceModel."""
    model = SliceModel(around, through, c10, c20, bulk, NO_SUPPORT)
    full = np.full(2 * around, 1.0)
    model.place(
        INNER * full,
        OUTER * full,
        lambda angle, radius: tuple(np.full_like(radius, v) for v in (share, shear, yield_stress, hardening)),
    )
    model.set_loads(
        {"balloon_stiffness": STIFF, "balloon_cap": 1e6, "stent_stiffness": 1.0, "stent_cap": 1.0, "balloon_share": 0.0}
    )
    return model


def radius(model):
    """Radius of the circle that has the lumen's area."""
    return float(np.sqrt(model.lumen_area() / np.pi))


def inflate(model, target, steps):
    """Prescribes the radius `target` by a stiff device; returns (radius, device pressure)."""
    model.set_loads({"balloon_share": 1.0, "balloon_radius": INNER - 0.02})
    for value in np.linspace(INNER, target, steps + 1)[1:]:
        model.advance({"balloon_radius": float(value)})
    r = radius(model)
    gap = target - r
    return r, STIFF * 0.5 * (gap + np.hypot(gap, 0.004))


def test_lame_tube():
    shear, bulk, pressure = 0.2, 20.0, 1e-4
    model = tube(1.0, shear, 1e3, 1.0, bulk)
    model.advance({"pressure": pressure})
    lame = bulk - 2 * shear / 3
    # u(a) = A a + B / a with sigma_rr(a) = -p, sigma_rr(b) = 0 and no axial strain.
    b = pressure * INNER**2 * OUTER**2 / (2 * shear * (OUTER**2 - INNER**2))
    a = pressure * INNER**2 / (2 * (lame + shear) * (OUTER**2 - INNER**2))
    exact = a * INNER + b / INNER
    mean = np.linalg.norm(model.lumen_displacement(), axis=1).mean()
    assert mean == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("through, tolerance", [(4, 4e-3), (8, 1.5e-3)])
def test_incompressible_neo_hookean_inflation_3_6_fold(through, tolerance):
    shear = 0.2
    model = tube(1.0, shear, 1e3, 1.0, 200.0, through=through)
    r, pressure = inflate(model, 3.6 * INNER, 16)
    inner = r / INNER
    outer = np.sqrt(OUTER**2 + r**2 - INNER**2) / OUTER
    exact = shear * (np.log(inner / outer) + 0.5 * (outer**-2 - inner**-2))
    assert inner > 3.5
    assert pressure == pytest.approx(exact, rel=tolerance)


def test_yeoh_wall_inflation():
    c10, c20 = 0.05, 0.2
    model = tube(0.0, 1.0, 1.0, 1.0, 2000.0, c10=c10, c20=c20)
    r, pressure = inflate(model, 2.0 * INNER, 10)

    def slope(x):
        first = x**2 + x**-2 - 2
        return 2 * (c10 + 2 * c20 * first) * (x**2 - x**-2) / (x * (x**2 - 1))

    exact = quad(slope, np.sqrt(OUTER**2 + r**2 - INNER**2) / OUTER, r / INNER)[0]
    assert pressure == pytest.approx(exact, rel=2.5e-3)


def test_fully_plastic_tube_reaches_its_limit_load():
    yield_stress = 0.1
    model = tube(1.0, 20.0, yield_stress, 1e-6, 2000.0, through=8)
    r, pressure = inflate(model, 1.3 * INNER, 12)
    exact = 2 / np.sqrt(3) * yield_stress * np.log(np.sqrt(OUTER**2 + r**2 - INNER**2) / r)
    assert pressure == pytest.approx(exact, rel=5e-3)


def test_a_softer_plaque_keeps_no_memory_below_yield_and_some_above():
    model = tube(1.0, 0.2, 0.1, 0.2, 20.0)
    left = []
    for target in (1.05 * INNER, 2.0 * INNER):
        inflate(model, target, 6)
        model.advance({"balloon_share": 0.0})
        left.append(radius(model))
    assert left[0] == pytest.approx(INNER, rel=1e-4)
    assert 1.1 * INNER < left[1] < 2.0 * INNER


def test_lesion_of_the_published_size_against_its_three_dimensional_solution():
    """The middle of a 70 % cosine lesion, opened by a device of radius 1.75 mm.

    The solution in three dimensions has a radius of 1.6044 mm. Plane strain gives 0.35 % more.
    """
    around = 24
    model = SliceModel(around, 8, 0.05, 0.2, 20.0, 0.01)

    def tissue(_, r):
        return 0.5 * (1 - np.tanh((r - 1.7) / 0.04)), *(np.full_like(r, v) for v in (0.2, 0.1, 0.2))

    model.place(np.full(2 * around, 0.48), np.full(2 * around, 2.4), tissue)
    model.set_loads({"balloon_stiffness": 20.0, "balloon_cap": 1.2, "balloon_radius": 0.4, "balloon_share": 1.0})
    model.set_loads({"stent_stiffness": 1.5, "stent_cap": 0.15, "stent_radius": 0.97 * 1.75})
    for value in np.arange(0.5, 1.7501, 0.125):
        model.advance({"balloon_radius": float(value)})
    for share in np.linspace(0.2, 1, 5):
        model.advance({"balloon_share": 1 - share, "stent_share": share})
    assert np.sqrt(model.lumen_area() / np.pi) == pytest.approx(1.6044 * 1.0035, rel=2e-3)


def test_an_eccentric_soft_plaque_lets_go_of_a_balloon_step_by_step():
    """`deflate` lowers the balloon's radius in steps. Its result does not depend on the length of the steps.

    If it lowered the pressure, the plaque would collapse at once near the end.
    """
    plaque, healthy, shift = materials.LIPID, 2.09, 0.585

    def reach(theta):
        return -shift * np.cos(theta) + np.sqrt(healthy**2 - (shift * np.sin(theta)) ** 2)

    def tissue(theta, r):
        share = 0.5 * (1 - np.tanh((r - reach(theta)) / 0.04))
        return share, *(np.full_like(r, v) for v in (plaque.shear_mpa, plaque.yield_mpa, plaque.hardening_mpa))

    def inflated():
        model = SliceModel(24, 6, 0.05, 0.2, 20.0, 0.01)
        model.place(np.full(48, 0.63), reach(model.annulus.theta_rad) + 0.7, tissue)
        model.set_loads({"balloon_stiffness": 5.0, "balloon_cap": 0.8, "balloon_radius": 0.58, "balloon_share": 1.0})
        for value in np.linspace(0.58, 1.75, 21)[1:]:
            model.advance({"balloon_radius": float(value)})
        return model

    found = []
    for step in (0.12, 0.06):
        model = inflated()
        assert radius(model) == pytest.approx(1.742, abs=2e-3)
        procedure.deflate(model, lambda: np.linalg.norm(model.lumen_position(), axis=1).min(), step, "test")
        assert model.loads()["balloon_share"] == 0
        found.append(radius(model))
    assert found[0] == pytest.approx(found[1], rel=1e-3) and found[1] == pytest.approx(1.075, abs=5e-3)
