import numpy as np
import pytest

from common.errors import InputError
from common.implicit import field
from common.implicit.curves import Curve
from data_synthetic import tree


def test_stenosis_is_as_asked(branches):
    main = branches[0]
    loss = 1 - main.radius_mm / main.healthy_radius_mm
    assert 100 * loss.max() == pytest.approx(60, abs=0.1)
    assert main.lesions[0]["centre_s_mm"] == pytest.approx(main.axis.s_mm[np.argmax(loss)], abs=0.1)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_curvature_has_the_mean_and_the_bound_asked(vessel, seed):
    data = vessel(seed=seed, side_branches=[], lesions=[])
    data["main"].update(length_mm=80, mean_curvature_per_mm=0.12, max_curvature_per_mm=0.25)
    axis = tree.grow(data)[0].axis
    k = axis.curvature(axis.s_mm)
    assert k.mean() == pytest.approx(0.12, rel=0.02)
    assert k.max() < 0.255


def test_eccentric_lumen_stays_inside_the_healthy_wall(branches):
    main = branches[0]
    theta = np.linspace(0, 2 * np.pi, 90)
    s = np.linspace(0, main.axis.length_mm, 200)
    shift = np.linalg.norm(main.shift(s), axis=1)
    assert shift.max() > 0.3
    assert np.all(shift + main.radius(s) <= main.healthy_radius(s) + 5e-4)
    thickness = main.plaque_thickness(main.lesions[0]["centre_s_mm"], theta)
    assert thickness.min() >= 0 and thickness.max() > 2 * thickness.min()


def test_plaque_thickness_of_a_shifted_circle(branches):
    main = branches[0]
    s = main.lesions[0]["centre_s_mm"]
    _, normal, binormal = main.axis.frame(s)
    for theta in (0.3, 2.0, 4.5):
        ray = np.cos(theta) * normal + np.sin(theta) * binormal
        outer = (main.radius(s) + main.plaque_thickness(s, theta)) * ray
        assert np.linalg.norm(outer + main.shift(s)) == pytest.approx(float(main.healthy_radius(s)), abs=1e-9)


def test_same_seed_same_tree_other_seed_other_tree(vessel):
    a, b, c = (tree.grow(vessel(seed=seed))[0].axis.points_mm for seed in (7, 7, 8))
    assert np.array_equal(a, b)
    assert a.shape != c.shape or np.abs(a - c).max() > 0.1


def test_a_tree_that_cannot_be_clear_of_itself_is_refused(vessel):
    crowd = [{"s_mm": s, "diameter_mm": 1.4, "length_mm": 9, "azimuth_deg": 0} for s in (14.0, 15.0)]
    with pytest.raises(InputError) as caught:
        tree.grow(vessel(side_branches=crowd, lesions=[]), "case.yaml: vessel")
    assert caught.value.where == "case.yaml: vessel.seed"
    assert "side1 meets another branch" in str(caught.value) and "azimuths" in str(caught.value)


@pytest.mark.parametrize("end_height_mm, conflict", [(4.5, (tree.END_CONTACT, "main")), (6.5, None)])
def test_no_branch_passes_where_the_surface_is_cut_at_an_end(end_height_mm, conflict):
    """A side branch that bends back and ends before the main vessel's wall: the cut at its end would open that wall."""

    def branch(name, parent, points, radius_mm):
        axis = Curve(points)
        radius = np.full(len(axis.s_mm), radius_mm)
        return tree.Branch(name, parent, 5.0, axis, radius, radius, np.zeros((len(radius), 3)))

    x = np.linspace(0, 40, 401)
    turn = np.linspace(0, np.pi - np.arcsin(end_height_mm / 8), 200)
    arc = np.stack([13 - 8 * np.cos(turn), 8 * np.sin(turn), 0 * turn], axis=1)
    branches = [
        branch("main", "", np.stack([x, 0 * x, 0 * x], axis=1), 1.5),
        branch("side1", "main", arc, 0.7),
    ]
    assert tree._first_conflict(branches) == conflict


def test_a_lesion_that_bends_the_lumen_too_sharply_is_said_to(vessel):
    """Another seed would not help, so the message must not suggest one."""
    short = {"centre_s_mm": 11, "length_mm": 2, "diameter_stenosis_percent": 80, "eccentricity": 1}
    with pytest.raises(InputError) as caught:
        tree.grow(vessel(lesions=[short]))
    message = str(caught.value)
    assert "bends more sharply" in message and "eccentricity" in message and "another seed" not in message


def test_a_whole_number_written_with_a_point_is_that_number(vessel):
    whole, pointed = (tree.grow(vessel(seed=seed))[0].axis.points_mm for seed in (7, 7.0))
    assert np.array_equal(whole, pointed)


@pytest.mark.parametrize("eccentricity", [0.0, 0.9])
@pytest.mark.parametrize("percent", [0, 40, 70])
def test_a_side_branch_inside_a_lesion_leaves_the_opposite_wall_alone(vessel, percent, eccentricity):
    """The branch is wider than its parent's narrowed lumen, and starts in it wherever the plaque has shifted it."""
    lesion = {"centre_s_mm": 20, "length_mm": 14, "diameter_stenosis_percent": percent, "eccentricity": eccentricity}
    side = {"s_mm": 20, "diameter_mm": 2.4, "length_mm": 9, "azimuth_deg": 40}
    main, branch = tree.grow(vessel(lesions=[lesion] if percent else [], side_branches=[side]))
    lumen = field.LumenField([main, branch])
    s = np.linspace(main.axis.nearest(branch.axis.point(0.0)[None])[0] - 2, 23, 40)
    tangent, normal, binormal = main.axis.frame(s)
    outward = branch.axis.frame(0.0)[0]
    for angle in np.radians([120, 180, 240]):  # from the side branch's direction, round the main axis
        across = outward - np.sum(outward * tangent, axis=1)[:, None] * tangent
        across /= np.linalg.norm(across, axis=1)[:, None]
        ray = np.cos(angle) * across + np.sin(angle) * np.cross(tangent, across)
        wall = main.axis.point(s) + main.radius(s)[:, None] * ray
        assert np.all(np.abs(lumen.value(wall)) < 1e-3)
    beyond_parent = branch.axis.s_mm[branch.axis.s_mm > 1.7 / np.sin(np.radians(60))]
    assert np.allclose(lumen.axis_radius(1, beyond_parent), branch.healthy_radius(beyond_parent))
    # The mouth is no narrower than three quarters of the parent's lumen, which feeds it.
    s_root = main.axis.nearest(branch.axis.point(0.0)[None])
    assert (-lumen.value(branch.axis.points_mm)).min() > 0.7 * main.radius(s_root)
