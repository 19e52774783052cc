"""End points of the vessels in a CT: values on both sides of each limit, and the messages of refusals."""

import ct_vessels
import nibabel
import numpy as np
import pytest

from anatomy.ct import ends_check, paths, segment, volumes
from common import volume as image
from common.errors import ComputationError, InputError

BLOOD = 400.0


def pair(distance):
    return [("inlet", [0.0, 0.0, 0.0]), ("outlet1", [0.0, 0.0, distance])]


def test_end_points_of_a_short_vessel():
    assert len(ends_check.checked_ends(pair(1.01), "case")) == 2
    with pytest.raises(InputError, match="(?s)at one place.*1.0 mm from inlet"):
        ends_check.checked_ends(pair(0.99), "case")
    with pytest.raises(InputError, match="(?s)too few end points.*an outlet for each branch"):
        ends_check.checked_ends(pair(5.0)[:1], "case")


@pytest.mark.parametrize("miss, near", [(1.95, True), (2.05, False)])
def test_a_line_may_end_a_radius_away_from_its_point(miss, near):
    ends = [("inlet", np.zeros(3)), ("outlet1", np.array([0.0, miss, 20.0]))]
    line = {"main": np.column_stack([np.zeros(60), np.zeros(60), np.linspace(0, 20, 60)])}
    if near:
        assert segment._lines_of_user(line, ends)[0].end == 1
    else:
        with pytest.raises(InputError, match="(?s)away from every end point.*within 2 mm.*left-posterior-superior"):
            segment._lines_of_user(line, ends)


def test_a_centreline_reaches_every_outlet():
    """Each outlet needs its own line. Formerly a branch without a line was left out without a message."""
    ends = [("inlet", np.zeros(3)), ("outlet1", np.array([0.0, 0.0, 20.0])), ("outlet2", np.array([10.0, 0.0, 10.0]))]
    main = np.column_stack([np.zeros(60), np.zeros(60), np.linspace(0, 20, 60)])
    side = np.column_stack([np.linspace(0, 10, 60), np.zeros(60), np.full(60, 10.0)])
    assert [line.end for line in segment._lines_of_user({"main": main, "side1": side}, ends)] == [1, 2]
    with pytest.raises(InputError, match="(?s)not have one line to each outlet.*outlet2.*reached by none"):
        segment._lines_of_user({"main": main}, ends)
    with pytest.raises(InputError, match="(?s)not have one line to each outlet.*outlet1.*reached by main and side1"):
        segment._lines_of_user({"main": main, "side1": main, "side2": side}, ends)


def test_a_centreline_off_the_axis_is_centred():
    """Centrelines of workstations are off by some tenths of a millimetre. Used without centring, such a line made a
    false lesion."""
    z = np.linspace(0.5, ct_vessels.LENGTH_MM - 0.5, 120)
    off = np.column_stack([0.7 * np.exp(-(((z - 20) / 5) ** 2)), np.zeros(120), z])
    found = segment.segment(ct_vessels.image(), ct_vessels.ends(), ct_vessels.settings(), {"main": off})
    tube = found["tubes"][0]
    assert np.abs(tube.axis.point(tube.s_mm)[:, :2]).max() < 0.1
    assert tube.radius(tube.s_mm) == pytest.approx(ct_vessels.RADIUS_MM, abs=0.08)


@pytest.mark.parametrize("share, filled", [(0.52, True), (0.48, False)])
def test_an_end_point_in_half_the_contrast_is_in_the_vessel(share, filled):
    """In the blurred throat of a thin branch, the CT number on the axis is only half that of the blood."""
    values = np.full((20, 20, 20), BLOOD * share, np.float32)
    block = image.Image(values, np.zeros(3), np.full(3, 0.5))
    if filled:
        paths._seed(block, values, "outlet1", [5.0, 5.0, 5.0], BLOOD)
    else:
        with pytest.raises(InputError, match="(?s)outlet1.*192 HU where blood is 400.*the inlet's too"):
            paths._seed(block, values, "outlet1", [5.0, 5.0, 5.0], BLOOD)


@pytest.mark.parametrize("share, passable", [(0.22, True), (0.18, False)])
def test_a_fifth_of_the_contrast_is_a_way(share, passable):
    """The vessel has a gap, in which the CT number is the given share of the blood's."""
    x, y, z = np.meshgrid(*3 * [np.arange(60) * 0.4], indexing="ij")
    values = np.where(np.hypot(x - 12, y - 12) < 1.6, BLOOD, 0).astype(np.float32)
    values[np.where((np.abs(z - 12) < 2.5) & (np.hypot(x - 12, y - 12) < 2.4))] = share * BLOOD
    block = image.Image(values, np.zeros(3), np.full(3, 0.4))
    ends = [("inlet", np.array([12.0, 12, 2])), ("outlet1", np.array([12.0, 12, 22]))]
    if passable:
        assert len(paths.find_branches(block, ends)) == 1
    else:
        with pytest.raises(ComputationError, match="(?s)no way.*outlet1.*0.2 of the blood's 400 HU.*--centreline"):
            paths.find_branches(block, ends)


def fork(length):
    """(at, lines): a vessel of 1.5 mm along z and a branch of 1 mm across it, `length` long from the axis on."""

    def at(points):
        x, y, z = np.moveaxis(np.asarray(points), -1, 0)
        main = np.hypot(x, y) < 1.5
        side = (np.hypot(y, z - 10) < 1.0) & (x > 0)
        return np.where(main | side, BLOOD, 0.0)

    main = np.column_stack([np.zeros(80), np.zeros(80), np.linspace(0, 20, 80)])
    side = np.column_stack([np.linspace(0, length, 60), np.zeros(60), np.full(60, 10.0)])
    axes = [paths.smooth_curve(points, 0.01) for points in (main, side)]
    return at, [paths.Line(axes[0], -1, 1), paths.Line(axes[1], 0, 2)]


@pytest.mark.parametrize("length, leaves", [(3.7, True), (3.2, False), (1.6, False)])
def test_a_branch_needs_five_sections_outside_its_parent(length, leaves):
    """From 2.3 mm off the parent's axis, rays no longer run into the parent. A branch that ends before that has no
    sections of its own."""
    at, lines = fork(length)
    main = segment._measure_tube(at, lines[0], None, "half_maximum", BLOOD, None, 0.25, 24)[0]
    if leaves:
        tube = segment._measure_tube(at, lines[1], main, "half_maximum", BLOOD, None, 0.25, 24)[0]
        assert tube.radius(tube.s_mm[-1]) == pytest.approx(1.0, abs=0.1)
    else:
        with pytest.raises(
            ComputationError, match="(?s)hardly leaves its parent.*outlet 2 of those given.*mm of it outside"
        ):
            segment._measure_tube(at, lines[1], main, "half_maximum", BLOOD, None, 0.25, 24)


def test_a_lumen_without_a_surface_names_the_settings(monkeypatch):
    """The message names settings that the user can change. It does not ask for "a finer spacing", which is no
    setting."""

    def turned(*_):
        raise ComputationError("the edge of an end turns back", "lumen surface", "near [1, 2, 3] mm", "a finer spacing")

    monkeypatch.setattr(segment.surface, "build", turned)
    block = volumes.Volume(image.Image(np.zeros((2, 2, 2)), np.zeros(3), np.ones(3)), np.diag([-1.0, -1.0, 1.0]))
    found = {"field": None, "blood_hu": 400.0, "noise_hu": 50.0, "ends": [("inlet", np.array([1.0, 2.0, 3.0]))]}
    with pytest.raises(ComputationError, match=r"(?s)turns back.*\[-1.0, -2.0, 3.0\].*noise 7.0.*surface_spacing_mm"):
        segment._surface(found, 0.2, block)
    # The points may be right although the path is wrong: it may run through a chamber that touches the vessel.
    with pytest.raises(ComputationError, match="or give your own lines .--centreline.* chamber"):
        segment._surface(found, 0.2, block)


def test_an_end_point_outside_is_told_in_the_users_coordinates(tmp_path):
    """x and y have the signs of the other convention. The message gives point and volume in the file's coordinates."""
    values = np.full((40, 40, 40), BLOOD, np.float32)
    values[:, :20] = -80  # fat, as round any vessel
    values[:3, :3, :3] = BLOOD
    affine = np.diag([0.5, 0.5, 0.5, 1.0])
    affine[:3, 3] = (10, -200, 1700)
    nibabel.save(nibabel.Nifti1Image(values, affine), tmp_path / "ct.nii")
    volume = volumes.read(tmp_path / "ct.nii")
    inside = [("inlet", np.array([10.0, -200, 1700])), ("outlet1", np.array([29.5, -180.5, 1719.5]))]
    ends_check.check(volume, inside)
    other = [inside[0], ("outlet1", np.array([-15.0, 190, 1710]))]
    said = r"(?s)outlet1.*\[-15.0, 190.0, 1710.0\].*\[10.0, -200.0, 1700.0\] to \[29.5, -180.5, 1719.5\].*change sign"
    with pytest.raises(InputError, match=said):
        ends_check.check(volume, other)


@pytest.mark.parametrize("share, contrast", [(0.26, True), (0.24, False)])
def test_an_inlet_must_lie_in_contrast(share, contrast):
    volume = volumes.Volume(image.Image(np.full((20, 20, 20), BLOOD * share), np.zeros(3), np.full(3, 0.5)), np.eye(3))
    ends = [("inlet", np.array([5.0, 5, 5])), ("outlet1", np.array([5.0, 5, 8]))]
    if contrast:
        ends_check.check(volume, ends)
    else:
        with pytest.raises(InputError, match="(?s)inlet.*96 HU.*not voxel numbers.*left-posterior-superior") as refused:
            ends_check.check(volume, ends)
        assert "reversed" not in str(refused.value)


@pytest.mark.parametrize("inlet", [[-3.0, 2.0, 1.0], [-3.0, 6.0, 1.0]])
def test_points_of_the_other_convention_are_recognised(inlet):
    """The given point lies inside the volume or outside it. With x and y reversed it lies in bright blood."""
    values = np.full((40, 40, 20), -80.0)
    origin = np.array([-8.0, -8.0, -2.0])
    x, y = (origin[k] + 0.4 * np.arange(40) for k in (0, 1))
    values[np.hypot(x[:, None] - 3, y[None] + inlet[1]) < 1.5] = BLOOD
    low = 0 if inlet[1] < 5 else 5  # cut off columns, so that the given point lies outside the volume
    block = image.Image(values[:, : 40 - 2 * low], origin, np.full(3, 0.4))
    said = r"(?s)inlet.*\[3.0, -\d.0, 1.0\], with x and y reversed, has 400 HU: the point is of the other convention"
    with pytest.raises(InputError, match=said):
        ends_check.check(volumes.Volume(block, np.eye(3)), [("inlet", np.array(inlet)), ("outlet1", np.array(inlet))])


@pytest.mark.parametrize("points", [np.ones((5, 3)), np.full((5, 3), np.nan)])
def test_an_axis_without_length_is_an_error_of_the_users(points):
    """The user gets an error message, not a traceback from the spline."""
    with pytest.raises(ComputationError, match="(?s)axis has no length.*CT numbers.*centreline"):
        paths.smooth_curve(points)


def test_an_end_between_thick_slices_has_blood():
    """No voxel lies within 0.6 mm of the point. Formerly its blood was nan then, and the search for the vessel broke
    off."""
    fine = ct_vessels.image(noise=0.0)
    thick = image.Image(fine.values[..., ::7], fine.origin_mm, fine.spacing_mm * [1, 1, 7])
    between = np.array([0.0, 0.0, fine.origin_mm[2] + 2.5 * 2.8])
    assert paths.blood_hu(thick, between) == pytest.approx(BLOOD, rel=0.05)


@pytest.mark.parametrize("every, said", [(2, False), (7, True)])
def test_thick_slices_are_named_where_a_vessel_is_not_found(every, said):
    fine = ct_vessels.image(noise=0.0)
    volume = image.Image(fine.values[..., ::every], fine.origin_mm, fine.spacing_mm * [1, 1, every])
    ends = [("inlet", np.array([0.0, 0.0, 2.0])), ("outlet1", np.array([5.0, 0.0, 30.0]))]
    with pytest.raises(InputError, match="not in a contrast-filled vessel") as caught:
        paths.find_branches(volume, ends)
    assert ("slices are 2.8 mm apart: give those of 1 mm or less" in str(caught.value)) == said
