"""What fixes the place of a lumen along its vessel, and which way round it lies."""

import numpy as np
import pytest
from registered_vessels import TRANSLATION, ROTATION, unbranched_tree, bent, moved, registered, straight, vessel
from scipy.spatial.transform import Rotation

from anatomy.register import placement_checks, sliding
from anatomy.register.match import match_branches
from anatomy.register.placement import Placement, Target
from anatomy.register.tree import STEP_MM, Line, Tree
from common.errors import InputError


@pytest.mark.parametrize("pre, post", [((0, 10), (0, 10)), ((0, 8), (12, 20)), ((0, 12), (0, 10))])
def test_straight_pieces_of_like_length_need_a_landmark(pre, post):
    """Here the check for rival placements finds none. Each slid placement has a misfit more than a tenth larger,
    because pieces jut out at the ends."""
    with pytest.raises(InputError, match="(?s)does not fix the place along it.*slid by a radius.*in place.*landmarks"):
        registered(bent(*pre), bent(*post))


def test_a_vessel_with_bends_needs_no_landmark():
    found, _, _ = registered(bent(0, 30, bow_mm=3), bent(3, 28, bow_mm=3))
    assert found.placement.apply(np.array([[0, 0, 10.0]]))[0] == pytest.approx([0, 0, 10], abs=0.1)


def test_narrow_bends_fix_the_place_though_the_vessel_is_nearly_straight():
    """The axis is a straight line within a quarter of the radius. But slid by a radius it does not fit any more."""

    def wound(first, last):
        z = np.arange(first, last, STEP_MM)
        return unbranched_tree(np.column_stack([0.3 * np.cos(z), 0.3 * np.sin(0.75 * z), z]))

    target, piece = Target(wound(0, 22)), wound(3, 19)
    in_place = Placement(Rotation.identity(), np.zeros(3))
    match = match_branches(target, piece, in_place)
    assert not sliding.fits_after_sliding(target, piece, in_place, match)
    # a lone landmark may be wrong; the residual after sliding is then that of a wrong place, so the user is warned
    assert sliding.depends_on_landmark(target, piece, in_place, match)
    target, piece = Target(bent(0, 22)), bent(3, 19)
    assert sliding.fits_after_sliding(target, piece, in_place, match_branches(target, piece, in_place))


def test_a_lone_landmark_on_a_straight_vessel_is_warned_of():
    """A landmark that was wrong by 3 mm moved the lumen by 3 mm. The residual was 0.06 mm, so there was no warning."""
    pre, post = straight(16), straight(20)
    marks = np.array([[0, 0, 15.68]]), np.array([[0, 0, 16.75]])
    found, match, target = registered(pre, post, marks)
    (said,) = placement_checks.warnings(target, post, found, match, marks)
    assert "nothing but the landmark fixes the place along a straight vessel" in said
    two = tuple(np.vstack([mark, mark - [[0, 0, 9]]]) for mark in marks)
    assert placement_checks.warnings(target, post, found, match, two) == []
    at = vessel().branches["main"].points[[40]]
    marks, post = (at, ROTATION.apply(at) + TRANSLATION), moved(vessel())
    found, match, target = registered(vessel(), post, marks)
    assert placement_checks.warnings(target, post, found, match, marks) == []


@pytest.mark.parametrize("marks_mm", [[15.68], [15.68, 6.0]])
def test_landmarks_do_not_turn_a_vessel_round(marks_mm):
    """The contours were read from the wrong end, so the inlet afterwards came to lie on the outlet before."""
    pre, post = straight(16), straight(20)
    line = post.branches["main"]
    turned = Line(line.points[::-1], line.radius, line.branch)
    marks = tuple(np.array([[0, 0, z + more] for z in marks_mm]) for more in (0, 4.07))
    assert registered(pre, post, marks)
    with pytest.raises(InputError, match="(?s)the other way round.*inlet_point_mm.*z_from"):
        registered(pre, Tree({"main": turned}, {"main": turned}, post.summary), marks)
