"""A slice that is pressed sideways by its stent, and its stiffness as a part of a beam, against closed forms."""

import numpy as np
import pytest

from common.errors import ComputationError
from common.implicit.curves import Curve
from data_synthetic.reference.slices import sideways
from data_synthetic.reference.slices.model import SUPPORT_SHIFT, SliceModel
from data_synthetic.reference.straightening import beams

INNER, OUTER, SUPPORT = 1.4, 2.1, 0.01
C10, C20, BULK = 0.05, 0.2, 20.0
STENT_STIFFNESS, STENT_RADIUS = 1.5, 1.5
X = np.array([1.0, 0.0])


def held_tube(c10=C10, c20=C20, radius=STENT_RADIUS, around=16, eccentric=False):
    """SliceModel of a healthy tube that a stent holds open; eccentric: with stiff plaque on one side."""
    model = SliceModel(around, 4, c10, c20, BULK, SUPPORT)
    full = np.full(2 * around, 1.0)

    def material(angle, distance):
        share = np.where(np.cos(angle) > 0, 1.0, 0.0) if eccentric else np.zeros_like(angle)
        return share, *(np.full_like(angle, v) for v in (2.0, 1e3, 1.0))

    model.place(INNER * full, OUTER * full, material)
    model.set_loads({"stent_stiffness": STENT_STIFFNESS, "stent_cap": 1e6, "stent_share": 1.0, "stent_radius": INNER})
    model.advance({"stent_radius": radius})
    return model


def test_a_rigid_section_yields_by_the_stent_alone():
    """f = k pi r d while the stent touches all round: its pressure k (R - distance) integrated over the lumen.

    The wall is ten thousand times stiffer than an artery's, and the offset a tenth of the stent's overlap.
    """
    model = held_tube(c10=500.0, c20=0.0)
    law = sideways.sideways_law(model, X, "here")
    slope = STENT_STIFFNESS * np.pi * INNER
    assert law.force_n_per_mm[1:3] / law.offset_mm[1:3] == pytest.approx(slope, rel=0.01)
    assert np.all(law.lumen_mm[1:] < 0.01 * law.offset_mm[1:]), "the lumen stays with the section"


def test_the_law_starts_at_rest_and_hardens():
    """Half of a soft wall is left alone when the stent leaves it; then the other half is stretched."""
    law = sideways.sideways_law(held_tube(), X, "here")
    assert law.offset_mm[0] == law.force_n_per_mm[0] == law.lumen_mm[0] == 0
    assert np.all(np.diff(law.offset_mm) > 0) and np.all(np.diff(law.force_n_per_mm) > 0)
    assert np.all((law.lumen_mm[1:] > 0) & (law.lumen_mm[1:] < law.offset_mm[1:]))


def test_a_round_section_yields_alike_in_all_directions():
    found = [sideways.sideways_law(held_tube(), np.array(d), "here") for d in ([1.0, 0.0], [0.6, 0.8])]
    assert found[0].force_n_per_mm == pytest.approx(found[1].force_n_per_mm, rel=2e-3)
    assert found[0].offset_mm == pytest.approx(found[1].offset_mm, rel=2e-3, abs=1e-6)


def test_measuring_leaves_the_slice_as_it_was():
    model = held_tube(eccentric=True)
    before = model.u.x.array.copy(), model.loads()
    sideways.sideways_law(model, X, "here")
    assert np.all(model.u.x.array == before[0]) and model.loads() == before[1]


def test_pressing_by_the_law_gives_its_offset():
    """Offset and force of one point of the law: the section then lies where the law says."""
    model = held_tube()
    law = sideways.sideways_law(model, X, "here")
    centre = model.lumen_centre()
    moved = sideways.press(model, law.offset_mm[2] * X, law.force_n_per_mm[2] * X, "here")
    assert model.outside_shift() == pytest.approx([-law.offset_mm[2], 0], abs=1e-4)
    moved_centre = model.lumen_centre() - model.outside_shift() - centre
    assert moved_centre == pytest.approx([law.lumen_mm[2], 0], abs=1e-4), "the lumen follows the stent"
    right = np.argmax(moved[:, 0])
    assert right == 0 and moved[right, 0] > 0.1, "the wall yields on the side to which the stent goes"


def test_a_law_that_cannot_be_measured_is_an_error(monkeypatch):
    model = held_tube()

    def advance(*_):
        raise ComputationError("no", "here", "0", "none")

    monkeypatch.setattr(model, "advance", advance)
    with pytest.raises(ComputationError, match="cannot be pressed sideways"):
        sideways.sideways_law(model, X, "here")


def test_a_ring_at_rest_is_a_tube():
    """E I = 6 C10 pi/4 (R^4 - r^4), and Cowper's part of 2 C10 A bears shear."""
    model = SliceModel(24, 4, C10, C20, BULK, SUPPORT)
    full = np.full(48, 1.0)
    model.place(INNER * full, OUTER * full, lambda angle, _: np.zeros((4, len(angle))) + [[0.0], [1.0], [1.0], [1.0]])
    bending, shear = model.beam_stiffness()
    assert bending == pytest.approx(6 * C10 * np.pi / 4 * (OUTER**4 - INNER**4), rel=1e-3)
    assert shear == pytest.approx(
        beams.shear_share((INNER / OUTER) ** 2) * 2 * C10 * np.pi * (OUTER**2 - INNER**2), rel=1e-3
    )


def test_a_section_that_moves_as_a_whole_turns_as_a_whole():
    """The shape is 1 along x: fibres move by x, so the wall itself does not bend."""
    model = held_tube()
    following, stiffness = model.wall_bending(0 * model.displacement(), np.array([-1.0, 0.0]))
    assert following == pytest.approx(1, rel=1e-6) and stiffness == pytest.approx(0, abs=1e-6)


def test_an_oval_section_bends_its_wall():
    """The shape (x, -y) is the gradient of psi = (x^2 - y^2) / 2, with 3 G integral psi^2 = 3 G pi/24 (R^6 - r^6)."""
    model = SliceModel(24, 4, C10, C20, BULK, SUPPORT)
    full = np.full(48, 1.0)
    model.place(INNER * full, OUTER * full, lambda angle, _: np.zeros((4, len(angle))) + [[0.0], [1.0], [1.0], [1.0]])
    x = model.u.function_space.tabulate_dof_coordinates()[:, :2]
    shift = np.array([-1.0, 0.0])
    following, stiffness = model.wall_bending((x * [1, -1] + shift).ravel(), shift)
    assert following == pytest.approx(0, abs=1e-3)
    assert stiffness == pytest.approx(3 * 2 * C10 * np.pi / 24 * (OUTER**6 - INNER**6), rel=2e-3)


def test_cowper_s_shear_of_hollow_circles():
    """6 (1 + n) / (7 + 6 n) of a full circle and (2 + 2 n) / (4 + 3 n) of a thin tube, with Poisson's ratio n = 0.5."""
    assert beams.shear_share(0.0) == pytest.approx(0.9) and beams.shear_share(1.0) == pytest.approx(6 / 11)


def test_plaque_on_one_side_bends_about_its_own_axis():
    """The mean E I of two half rings of E1 and E2, about their common neutral axes."""
    model = SliceModel(48, 6, C10, 0.0, BULK, SUPPORT)
    full, shear = np.full(96, 1.0), 2.0
    model.place(
        INNER * full,
        OUTER * full,
        lambda angle, _: (np.where(np.cos(angle) > 0, 1.0, 0.0), *np.full((3, len(angle)), shear)),
    )
    e1, e2 = 3 * shear, 6 * C10
    area, first = np.pi / 2 * (OUTER**2 - INNER**2), 2 / 3 * (OUTER**3 - INNER**3)
    second = np.pi / 8 * (OUTER**4 - INNER**4)
    about_neutral = (e1 + e2) * second - ((e1 - e2) * first) ** 2 / ((e1 + e2) * area)
    assert model.beam_stiffness()[0] == pytest.approx(0.5 * (about_neutral + (e1 + e2) * second), rel=0.01)


def test_the_bend_of_an_axis_has_a_direction():
    """Towards the centre of the bend; any direction where the axis is straight."""
    angle = np.linspace(0, 1, 201)
    arc = Curve(20 * np.stack([np.sin(angle), 1 - np.cos(angle), 0 * angle], axis=1))
    _, normal, binormal = arc.frame(np.array([10.0]))
    a, b = sideways.bend_direction(arc, 10.0)
    centre = (np.array([0, 20.0, 0]) - arc.point(np.array([10.0]))[0]) / 20
    assert a * normal[0] + b * binormal[0] == pytest.approx(centre, abs=1e-3)
    straight = Curve(np.stack([np.linspace(0, 20, 101), np.zeros(101), np.zeros(101)], axis=1))
    assert np.linalg.norm(sideways.bend_direction(straight, 10.0)) == pytest.approx(1)


def test_a_new_section_lies_in_tissue_that_was_not_shifted():
    model = held_tube()
    model.advance(dict(zip(SUPPORT_SHIFT, (0.3, 0.1))))
    full = np.full(32, 1.0)
    model.place(INNER * full, OUTER * full, lambda angle, _: np.ones((4, len(angle))))
    assert [model.loads()[name] for name in SUPPORT_SHIFT] == [0, 0]
