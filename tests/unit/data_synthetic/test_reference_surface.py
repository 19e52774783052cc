"""Slices to surface: interpolation, edges of the stent, refinement, straightening, materials."""

import numpy as np
import pytest

from common.documents import schema
from common.errors import ComputationError
from common.implicit import field, surface
from common.implicit.curves import Curve
from data_synthetic import tree
from data_synthetic.reference.slices import slices
from data_synthetic.reference.solid import materials
from data_synthetic.reference.straightening import stent_in_vessel
from data_synthetic.reference.surface import deformation, output, refine
from data_synthetic.reference.treatment import devices

THETA = 2 * np.pi * np.arange(48) / 48


def radial(amount):
    """Displacements (n, 48, 2) that open slices by amount (n,)."""
    ray = np.stack([np.cos(THETA), np.sin(THETA)], axis=1)
    return np.asarray(amount)[:, None, None] * ray[None]


def test_span_interpolates_radial_opening():
    s = np.linspace(5, 15, 15)
    span = deformation.SpanField(s, THETA, radial(0.5 + 0.01 * s))
    at = np.array([6.3, 9.9, 14.2])
    u = span.displacement_at(at, np.array([0.1, 3.0, 6.2]))
    assert np.linalg.norm(u, axis=1) == pytest.approx(0.5 + 0.01 * at, abs=1e-4)


def test_coupling_keeps_a_line_and_rounds_a_step():
    x = np.linspace(0, 10, 101)
    assert deformation.couple_along_axis(2 + 0.3 * x, 0.1, 0.6) == pytest.approx(2 + 0.3 * x, abs=1e-8)
    step = deformation.couple_along_axis((x > 5).astype(float), 0.1, 0.6)
    assert np.abs(np.diff(step)).max() < 0.12 and step[50] == pytest.approx(0.5, abs=0.1)
    assert step[:20] == pytest.approx(0, abs=0.01) and step[-20:] == pytest.approx(1, abs=0.01)


def test_opening_fades_beyond_the_stent():
    free = deformation.SpanField(np.linspace(0, 30, 10), THETA, radial(np.zeros(10)))
    held = deformation.SpanField(np.linspace(10, 20, 10), THETA, radial(np.ones(10)), 0.6)
    lumen = deformation.LumenDeformation(free, [held], 0.6)
    opened = lumen.in_plane(np.array([15.0, 20.0, 20.001, 20.6, 24.0]), np.zeros(5))[:, 0]
    assert opened[:3] == pytest.approx(1, abs=1e-3)
    assert opened[3] == pytest.approx(np.exp(-1) * (np.cos(1) + np.sin(1)), abs=1e-2)
    assert abs(opened[4]) < 0.01


def test_moved_lumen_opens_and_its_ends_rest(branches):
    main = branches[0]
    points, triangles, _ = surface.build(field.LumenField(branches), 0.3)
    span = deformation.SpanField(np.linspace(0, main.axis.length_mm, 30), THETA, radial(np.full(30, 0.2)))
    lumen = deformation.LumenDeformation(span, [], 0.6)
    still = deformation.AxisMotion(np.array([0, main.axis.length_mm]), np.zeros((2, 3)))
    ends = field.open_ends(branches)
    resting = [(centre, radius) for _, centre, _, radius in ends]
    moved = deformation.move_points(points, main, lumen, still, resting)
    for _, centre, _, radius in ends:
        near = np.linalg.norm(points - centre, axis=1) < 1.05 * radius
        assert np.abs(moved - points)[near].max() < 1e-12
    s = main.axis.nearest(points)
    wall = (s > 5) & (s < 14)
    distance = np.linalg.norm(moved[wall] - main.axis.point(s[wall]), axis=1)
    assert distance == pytest.approx(main.radius(s[wall]) + 0.2, abs=1e-4)
    output.check_not_folded(triangles, points, moved)


def tube(points_mm, radius_mm):
    """A vessel of constant radius along an axis: Branch."""
    axis = Curve(points_mm)
    radius = np.full(len(axis.s_mm), float(radius_mm))
    return tree.Branch("main", "", 0.0, axis, radius, radius, np.zeros((len(radius), 3)))


def unopened(branch):
    """LumenDeformation that leaves the lumen of a branch as it is."""
    span = deformation.SpanField(np.array([0, branch.axis.length_mm]), THETA, radial(np.zeros(2)))
    return deformation.LumenDeformation(span, [], 0.6)


def straightened(axis, stent_bending):
    """Straightening of a soft vessel along an axis by a stent between 8 and 22 mm."""
    law = stent_in_vessel.SidewaysLaw(*np.array([[0.0, 0.1], [0.0, 0.05], [0.0, 0.08]]), -0.1, 0.1)
    ends = np.array([0.0, axis.length_mm])
    sections = stent_in_vessel.VesselSections(ends, np.full(2, 4.0), np.full(2, 2.0), [(s, law) for s in ends])
    stent = devices.Stent("stent", 8.0, 22.0, 0.955, 0.22, stent_bending, 1.5, 0.5)
    return stent_in_vessel.straighten(axis, [stent], sections, 0.08)


def test_sections_turn_with_the_straightened_axis():
    """If sections only shifted, the moved axis would cut them obliquely: 10 degrees cost 1.5 % of a diameter."""
    angle = np.linspace(0, 4, 401)
    bent = tube(10 * np.stack([np.sin(angle), 1 - np.cos(angle), 0.3 * angle], axis=1), 1.5)
    axis_s = np.linspace(0, bent.axis.length_mm, 201)
    shift = 0.5 * np.exp(-(((axis_s - 15) / 4) ** 2))[:, None] * bent.axis.frame(axis_s)[1]
    s = np.linspace(4.0, 26.0, 45)
    _, normal, binormal = bent.axis.frame(s)
    ray = np.cos(THETA)[:, None, None] * normal + np.sin(THETA)[:, None, None] * binormal
    wall = (bent.axis.point(s) + 1.5 * ray).reshape(-1, 3)
    moved = deformation.move_points(wall, bent, unopened(bent), deformation.AxisMotion(axis_s, shift), [])
    new = Curve(bent.axis.point(axis_s) + shift)
    distance = np.linalg.norm(moved - new.point(new.nearest(moved)), axis=1)
    assert distance == pytest.approx(np.full(len(distance), 1.5), rel=2e-3)


def test_a_side_branch_inside_a_bend_is_not_torn():
    """Half-way between the limbs of a bend the nearest place on the axis jumps from one limb to the other."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 101)
    limb = np.linspace(0, 10, 81)[:-1]
    x = np.concatenate([limb - 10, 4 * np.cos(angle), -limb[1:]])
    y = np.concatenate([0 * limb - 4, 4 * np.sin(angle), 0 * limb[1:] + 4])
    bent = tube(np.stack([x, y, 0 * x], axis=1), 1.0)
    # One limb moves along x, the other against it.
    shift = np.stack([0.4 * np.tanh(bent.axis.s_mm - 0.5 * bent.axis.length_mm), *np.zeros((2, len(bent.axis.s_mm)))])
    across = np.linspace(-2.9, 2.9, 117)
    line = np.stack([0 * across - 3, across, 0 * across], axis=1)
    moved = deformation.move_points(line, bent, unopened(bent), deformation.AxisMotion(bent.axis.s_mm, shift.T), [])
    steps = np.linalg.norm(np.diff(moved - line, axis=0), axis=1) / np.diff(across)
    assert np.ptp(moved[:, 0]) > 0.4, "each end still follows its limb"
    assert steps.max() < 0.5


def test_a_folded_surface_is_an_error():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])
    triangles = np.array([[0, 1, 2], [1, 3, 2]])
    with pytest.raises(ComputationError, match=r"folded(.|\n)*2 of 2 triangles turned over, the most near \["):
        output.check_not_folded(triangles, points, points * [-1, 1, 1])


def test_refinement_is_watertight_keeps_area_and_halves_stretched_edges(branches):
    points, triangles, _ = surface.build(field.LumenField(branches), 0.4)

    def move(x):
        return x * [1, 1.0, 2.0]

    new, split, parents, old = refine.refine_stretched(points, triangles, move, lambda x, _: x, 0.5)
    directed = np.concatenate([split[:, [0, 1]], split[:, [1, 2]], split[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed)
    assert set(map(tuple, directed)) == set(map(tuple, directed[:, ::-1]))
    assert len(new) == len(points) + len(parents) and len(old) == len(split)

    def area(x, t):
        return 0.5 * np.linalg.norm(np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]]), axis=1)

    assert np.bincount(old, area(new, split)) == pytest.approx(area(points, triangles), rel=1e-9)
    length = np.linalg.norm(move(new)[directed[:, 0]] - move(new)[directed[:, 1]], axis=1)
    assert length.max() <= 0.5 + 1e-9


def test_stiff_stent_straightens_a_bend(branches):
    """The stiffer the stent, the straighter it is. The vessel's ends stay, and the lumen follows the stent in part."""
    axis, kept = branches[0].axis, []
    for stiffness in (2.0, 20.0, 200.0):
        found = straightened(axis, stiffness)
        s, w = found.s_mm[found.stented], found.stent_mm
        bent = np.gradient(axis.frame(s)[0], s, axis=0) + np.gradient(np.gradient(w, s, axis=0), s, axis=0)
        kept.append(np.linalg.norm(bent, axis=1)[2:-2].mean())
        assert np.all(found.vessel_mm[[0, -1]] == 0)
        lumen = found.lumen_shift() - found.vessel_mm
        assert lumen == pytest.approx(0.8 * found.offset_mm)
    assert kept[0] > kept[1] > kept[2]


def test_blended_plaque_runs_from_base_to_calcium():
    shear, yields, _ = materials.blend_with_calcium(materials.FIBROUS, np.array([0.0, 0.5, 1.0]))
    assert shear == pytest.approx([0.2, np.sqrt(0.2 * 6.0), 6.0]), "geometric mean"
    assert yields[[0, 2]] == pytest.approx([0.1, 1.5])


def test_tissues_carry_what_coronary_lesions_do():
    """Published stresses of three lesion classes at a biaxial stretch of 1.15: 0.067, 0.13, 0.30 MPa."""
    fibrous, lipid, calcified = (materials.biaxial_stress(1.15, kind) for kind in materials.BY_PLAQUE_TYPE.values())
    assert lipid < 0.067 < fibrous < 0.30 < calcified
    assert fibrous == pytest.approx(0.117, abs=0.001)  # 0.15 without yield
    assert 0.067 < materials.biaxial_stress(1.15, c10_mpa=0.05, c20_mpa=0.2) < 0.30
    # Below yield the law is that of a neo-Hookean sheet. The stress does not jump at yield.
    gentle = materials.biaxial_stress(1.01, materials.FIBROUS)
    assert gentle == pytest.approx(0.2 * (1.01**2 - 1.01**-4), rel=1e-12)
    below, above = (materials.biaxial_stress(x, materials.FIBROUS) for x in (1.0905, 1.0935))
    assert below < above < below + 0.004


def test_every_material_constant_names_a_source_or_says_that_it_has_none():
    defaults = schema.with_defaults({}, schema.read("reference"))
    numeric = {"slice_spacing_mm", "margin_mm", "elements_around", "elements_through", "radius_step_mm", "check_slices"}
    numeric |= {"slice_tolerance_percent"}
    physical = set(defaults) - numeric - {"edge_mm", "wall_c10_mpa", "wall_c20_mpa"}
    assert physical <= set(materials.SETTINGS_SOURCE)
    for text in [kind.source for kind in materials.BY_PLAQUE_TYPE.values()] + [materials.WALL_SOURCE]:
        assert "doi" in text or "J Physiol" in text
    for key in physical:
        value = "from " if defaults[key] is None else f"{defaults[key]:g}: "
        assert materials.SETTINGS_SOURCE[key].startswith(value)
    for kind in materials.BY_PLAQUE_TYPE.values():
        for value in (kind.shear_mpa, kind.yield_mpa, kind.hardening_mpa):
            assert f"{value:g}" in kind.source


def test_slices_sit_at_the_ends_of_the_stent():
    balloon = devices.Balloon("b", 15.0, 12.0, 1.0, 1.6, 10.0, 1.1)
    stent = devices.Stent("s", 9.0, 21.0, 0.96, 0.2, 20.0, 1.5, 0.5)
    free, held = slices.slice_positions(40.0, [devices.Step("stent", "stent", balloon, stent)], 0.75, 2.5)
    assert free[0] == pytest.approx(5.5) and free[-1] == pytest.approx(24.5)
    assert {9.0, 21.0} <= set(free) and not np.any((free > 9) & (free < 21))
    assert held[0][2][[0, -1]] == pytest.approx([9, 21]) and np.diff(held[0][2]).max() <= 0.75
