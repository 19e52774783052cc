"""Frames placed on a centreline: a known curved vessel is recorded as a pull-back and must be restored from it."""

import functools

import numpy as np
import pytest
import vtk
from contour_tables import tube
from scipy.spatial import cKDTree

from anatomy.contours import frame_placement, line, loft, pullback, run
from anatomy.contours.reading import outlines
from common import vtp
from common.errors import InputError

LENGTH = 40.0


def axis(s):
    """(points, tangents), each (k, 3), at arc lengths s (k,) of an axis that bends in space, in CT coordinates."""
    fine = np.linspace(0, 1, 4001)
    x, y, z = 25 * np.sin(1.5 * fine), 22 * (1 - np.cos(1.6 * fine)), 9 * np.sin(3.1 * fine)
    curve = np.column_stack([x, y, z]) + (60, -190, 1700)
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    assert along[-1] > LENGTH
    points = np.column_stack([np.interp(s, along, curve[:, k]) for k in range(3)])
    ahead = np.column_stack([np.interp(s + 0.01, along, curve[:, k]) for k in range(3)])
    return points, (ahead - points) / np.linalg.norm(ahead - points, axis=1)[:, None]


def frame_vectors(s):
    """Two unit vectors across the axis at arc lengths s, which do not turn about it: carried along in small steps."""
    fine = np.linspace(0, LENGTH, 4001)
    tangents = axis(fine)[1]
    first = np.empty_like(tangents)
    first[0] = np.cross(tangents[0], [0, 0, 1.0])
    first[0] /= np.linalg.norm(first[0])
    for k in range(1, len(fine)):
        carried = first[k - 1] - (first[k - 1] @ tangents[k]) * tangents[k]
        first[k] = carried / np.linalg.norm(carried)
    at = np.array([np.abs(fine - x).argmin() for x in s])
    return first[at], np.cross(tangents[at], first[at])


def radius(s, angle):
    """Radius at arc length s and angle, of a tapering vessel, not quite round, with an eccentric narrowing."""
    narrow = np.exp(-(((s - 20) / 5) ** 2))
    return (1.8 - 0.012 * s) * (1 + 0.1 * np.cos(2 * angle)) * (1 - narrow * (0.25 + 0.2 * np.cos(angle - 0.8)))


def wall(s, count=400):
    """Points (len(s), count, 3) of the true wall, `count` of them round each arc length s."""
    angle = 2 * np.pi * np.arange(count) / count
    place = axis(s)[0]
    first, second = frame_vectors(s)
    r = np.array([radius(x, angle) for x in s])
    return place[:, None] + r[..., None] * (
        np.cos(angle)[None, :, None] * first[:, None] + np.sin(angle)[None, :, None] * second[:, None]
    )


def recorded(turn, sign=1.0):
    """The vessel as a catheter records it: {frame: (z, outline)}, rows of the landmark table, their places in space.

    Frames are 0.6 mm apart, from distal to proximal. Images are turned by `turn` (radians), and their middle wanders
    with the catheter. x and y of an image and z, to proximal, are right-handed. sign -1 gives the mirror image.
    """
    s = np.arange(5.0, 35.01, 0.6)[::-1]
    place, _ = axis(s)
    first, second = frame_vectors(s)
    points = wall(s, 120)
    frames, marks, places = {}, [], []
    for k in range(len(s)):
        away = points[k] - place[k]
        u, v = away @ first[k], -(away @ second[k])  # the image is seen against the tangent
        x = np.cos(turn) * u + np.sin(turn) * v
        y = sign * (-np.sin(turn) * u + np.cos(turn) * v)
        middle = (4.5 + 0.4 * np.sin(k / 5), 4.5 + 0.3 * np.cos(k / 7))
        frames[k] = (s[0] - s[k], np.column_stack([x, y]) + middle)
        if k in (8, 25, 40):
            marks.append((k, *(frames[k][1][30 + k]), s[0] - s[k]))
            places.append(points[k][30 + k])
    return frames, marks, np.array(places)


@pytest.fixture
def pull_back(tmp_path):
    def make(turn, sign=1.0, keep=slice(None), z_from="distal"):
        frames, marks, places = recorded(turn, sign)
        if z_from == "proximal":
            frames = {k: (30.0 - z, outline) for k, (z, outline) in frames.items()}
            marks = [(k, x, y, 30.0 - z) for k, x, y, z in marks]
        files = {"lumen": tmp_path / "lumen.csv", "landmarks": tmp_path / "landmarks.csv"}
        lines = [f"{k},{x},{y},{z}" for k, (z, outline) in frames.items() for x, y in outline]
        files["lumen"].write_text("\n".join(lines))
        files["landmarks"].write_text("\n".join(f"{k},{x},{y},{z}" for k, x, y, z in marks[keep]))
        return pullback.read(files, z_from=z_from), places[keep]

    return make


@functools.lru_cache
def centred_line():
    """The line through the centres of the lumen's sections, like a centreline from CT, with a jitter of 0.02 mm."""
    s = np.arange(0, LENGTH, 0.5)
    points = wall(s)
    first, second = frame_vectors(s)
    place = axis(s)[0]
    middle = []
    for k in range(len(s)):
        away = points[k] - place[k]
        u, v = outlines.centroid(np.column_stack([away @ first[k], away @ second[k]]))
        middle.append(place[k] + u * first[k] + v * second[k])
    return np.array(middle) + np.random.default_rng(3).normal(scale=0.02, size=(len(s), 3))


def misfit(points):
    """Distances (n,) in mm from the true wall, for those of the points between s = 6 and 34 mm."""
    s, tree = true_wall()
    distance, index = tree.query(points)
    near = s[index // 200]
    return distance[(near > 6) & (near < 34)]


@functools.lru_cache
def true_wall():
    s = np.arange(4.5, 35.5, 0.05)
    return s, cKDTree(wall(s, 200).reshape(-1, 3))


@pytest.mark.parametrize("turn", [0.0, 1.1, -2.4])
@pytest.mark.parametrize("keep", [slice(None), slice(1, 2)])
def test_a_curved_vessel_comes_back(pull_back, turn, keep):
    pull, places = pull_back(turn, keep=keep)
    place = frame_placement.centreline_placement(pull, line.Line(centred_line()), places)
    lofted = run.loft_pullback(pull, place)
    rim = len(lofted["z_mm"]) * lofted["frame_rings"].shape[1]
    off = misfit(lofted["points"][:rim])
    assert np.sqrt(np.mean(off**2)) < 0.03 and off.max() < 0.06
    assert loft.volume_mm3(lofted["points"], lofted["triangles"]) > 0


def test_landmarks_tell_the_rotation(pull_back):
    turns = []
    axis_line = line.Line(centred_line())
    for turn in (0.0, 1.1):
        pull, places = pull_back(turn)
        report = frame_placement.centreline_placement(pull, axis_line, places).report
        assert report["landmarks_differ_mm"] < 0.3 and report["landmarks_differ_deg"] < 5
        turns.append(report["rotation_deg"])
    assert (turns[1] - turns[0] - np.degrees(1.1) + 180) % 360 - 180 == pytest.approx(0, abs=0.5)


def test_without_its_rotation_the_vessel_does_not_come_back(pull_back):
    pull, places = pull_back(1.1)
    place = frame_placement.centreline_placement(pull, line.Line(centred_line()), proximal_s_mm=5.0, rotation_deg=90)
    lofted = run.loft_pullback(pull, place)
    rim = len(lofted["z_mm"]) * lofted["frame_rings"].shape[1]
    assert misfit(lofted["points"][:rim]).max() > 0.3


def test_mirrored_images_are_found_out_and_put_right(pull_back):
    pull, places = pull_back(0.4, sign=-1.0)
    with pytest.raises(InputError, match="landmarks contradict"):
        frame_placement.centreline_placement(pull, line.Line(centred_line()), places)
    place = frame_placement.centreline_placement(pull, line.Line(centred_line()), places, mirrored=True)
    lofted = run.loft_pullback(pull, place)
    rim = len(lofted["z_mm"]) * lofted["frame_rings"].shape[1]
    assert misfit(lofted["points"][:rim]).max() < 0.06
    assert loft.volume_mm3(lofted["points"], lofted["triangles"]) > 0


@pytest.mark.parametrize("sign, mirrored", [(-1.0, False), (1.0, True)])
@pytest.mark.parametrize("keep", [slice(None), slice(1, 2)])
def test_z_from_the_proximal_end_is_no_mirror_image(pull_back, sign, mirrored, keep):
    """With z reversed, right-handed tables become left-handed. With y mirrored too, they are right-handed again."""
    pull, places = pull_back(1.1, sign, keep, z_from="proximal")
    place = frame_placement.centreline_placement(pull, line.Line(centred_line()), places, mirrored=mirrored)
    lofted = run.loft_pullback(pull, place)
    rim = len(lofted["z_mm"]) * lofted["frame_rings"].shape[1]
    assert misfit(lofted["points"][:rim]).max() < 0.06
    assert loft.volume_mm3(lofted["points"], lofted["triangles"]) > 0


def test_landmarks_that_do_not_fit_are_refused(pull_back):
    pull, places = pull_back(0.4)
    axis_line = line.Line(centred_line())
    with pytest.raises(InputError, match="landmarks contradict"):
        frame_placement.centreline_placement(pull, axis_line, places[[1, 0, 2]])
    with pytest.raises(InputError, match="without a partner"):
        frame_placement.centreline_placement(pull, axis_line, places[:2])
    with pytest.raises(InputError, match="tells no rotation"):
        frame_placement.centreline_placement(
            pull, axis_line, np.vstack([axis_line.frame_at(np.array([30.2]))[0], places[1:]])
        )
    frame_placement.centreline_placement(
        pull, axis_line, places + [0, 0, 1.0]
    )  # points are picked with errors of a millimetre, which is accepted


def moved(places, axis_line, along_mm, about_deg):
    """Places (3, 3) of three landmarks. The second is moved along the line by mm and about it by degrees."""
    s = np.array([axis_line.nearest(place) for place in places])
    middle, tangent, one, two = axis_line.frame_at(s)
    away, turn = (places - middle)[1], np.radians(about_deg)
    u, v = away @ one[1], away @ two[1]
    place, _, first, second = (x[0] for x in axis_line.frame_at(s[1:2] + along_mm))
    points = places.copy()
    points[1] = place + (u * np.cos(turn) - v * np.sin(turn)) * first + (u * np.sin(turn) + v * np.cos(turn)) * second
    return points


def test_landmarks_that_were_picked_roughly_are_taken(pull_back):
    """One of three is off by 4.2 mm along the vessel (2.8 mm from the mean of all) or by 60 degrees about it (41)."""
    pull, places = pull_back(0.4)
    axis_line = line.Line(centred_line())
    for off in ((4.2, 0), (0, 60)):
        report = frame_placement.centreline_placement(pull, axis_line, moved(places, axis_line, *off)).report
        assert report["landmarks_differ_mm"] > 2.5 or report["landmarks_differ_deg"] > 38
    for off, said in (((4.9, 0), "landmark 2 lies 3.[1-5] mm"), ((0, 72), "landmark 2 (49|5.) degrees")):
        with pytest.raises(InputError, match=f"(?s)landmarks contradict.*{said}.*which line"):
            frame_placement.centreline_placement(pull, axis_line, moved(places, axis_line, *off))


@pytest.mark.parametrize("about_deg, told", [(0, False), (20, False), (26, True), (60, True)])
def test_landmarks_that_disagree_by_more_than_they_are_marked_to_are_told(pull_back, about_deg, told):
    """One of three is off by two thirds of the angle from the mean. A mirror image may show as such a disagreement."""
    pull, places = pull_back(0.4)
    axis_line = line.Line(centred_line())
    found = list(
        frame_placement.warnings(
            frame_placement.centreline_placement(pull, axis_line, moved(places, axis_line, 0, about_deg))
        )
    )
    assert len(found) == told and all("mirrored" in one and "place of each" in one for one in found)


def test_the_command_tells_that_landmarks_disagree(table, tmp_path):
    """A mirror image of round frames on a straight line. Two landmarks 150 degrees apart disagree by 30 degrees."""
    frames, angles = tube([1.5] * 20), np.radians([0.0, 150.0])
    write_lines(tmp_path / "line.vtp", np.column_stack([np.zeros((41, 2)), np.linspace(30, -10, 41)]))
    marks = [(z, 4 + 1.5 * np.cos(a), 5 - 1.5 * np.sin(a)) for z, a in zip((5, 15), angles)]
    (tmp_path / "marks.csv").write_text("\n".join(f"0,{x},{y},{z}" for z, x, y in marks))
    points = [[1.5 * np.cos(a), 1.5 * np.sin(a), z] for z, a in zip((5, 15), angles)]
    files = {"lumen": table(frames), "landmarks": tmp_path / "marks.csv"}
    placement_settings = {"centreline": tmp_path / "line.vtp", "landmark_points_mm": points}
    for mirrored in (False, True):
        document = run.run(files, tmp_path / "out", placement_settings=placement_settings | {"mirrored": mirrored})
        assert document["placing"]["landmarks_differ_deg"] == pytest.approx(0 if mirrored else 30, abs=1)
        assert any("check mirrored" in one for one in document["warnings"]) != mirrored


@pytest.mark.parametrize("distance, taken", [(0.23, True), (0.17, False)])
def test_a_landmark_near_the_axis_tells_its_turn_from_two_tenths_on(pull_back, distance, taken):
    pull, places = pull_back(0.4, keep=slice(0, 1))
    axis_line = line.Line(centred_line())
    middle = axis_line.frame_at(np.array([axis_line.nearest(places[0])]))[0][0]
    near = middle + distance * (places[0] - middle) / np.linalg.norm(places[0] - middle)
    if taken:
        frame_placement.centreline_placement(pull, axis_line, near[None])
    else:
        with pytest.raises(InputError, match="(?s)tells no rotation.*landmark_points_mm.*landmark 1, 0.1. mm"):
            frame_placement.centreline_placement(pull, axis_line, near[None])


@pytest.mark.parametrize("radii, near", [(2.9, True), (3.1, False)])
@pytest.mark.parametrize("where", ["landmarks", "landmark_points_mm"])
def test_a_landmark_lies_within_three_radii_of_its_vessel(pull_back, where, radii, near):
    """The radius is the median of all frames, about 1.55 mm. The second landmark's own frame is narrower."""
    pull, places = pull_back(0.4)
    axis_line = line.Line(centred_line())
    far = radii * np.median([np.sqrt(outlines.area_mm2(frame.lumen) / np.pi) for frame in pull.frames])
    if where == "landmarks":
        z, point = pull.landmarks[1]
        middle = frame_placement.rings.interpolator(pull.z_mm, frame_placement.centres(pull.frames, False))(
            np.array([z])
        )[0]
        pull.landmarks[1] = z, middle + far * (point - middle) / np.linalg.norm(point - middle)
    else:
        middle = axis_line.frame_at(np.array([axis_line.nearest(places[1])]))[0][0]
        places[1] = middle + far * (places[1] - middle) / np.linalg.norm(places[1] - middle)
    if near:
        frame_placement.centreline_placement(pull, axis_line, places)
    else:
        with pytest.raises(InputError, match=f"(?s)far from its vessel.*where:  {where}\n.*landmark 2, .*3 radii"):
            frame_placement.centreline_placement(pull, axis_line, places)


def test_a_landmark_outside_the_frames_is_named_with_its_z(pull_back):
    pull, places = pull_back(0.4)
    pull.landmarks[1] = (31.0, pull.landmarks[1][1])
    with pytest.raises(InputError, match="(?s)landmark 2 at z 31.00 mm, frames 0.00 to 30.00 mm.*z_range_mm"):
        frame_placement.centreline_placement(pull, line.Line(centred_line()), places)


def test_a_pull_back_longer_than_its_line_is_refused(pull_back):
    pull, _ = pull_back(0.0)
    short = line.Line(centred_line()[:60])
    with pytest.raises(InputError, match="beyond its centreline"):
        frame_placement.centreline_placement(pull, short)
    frame_placement.centreline_placement(pull, line.Line(centred_line()[:64]))


def test_a_line_that_bends_within_the_lumen_is_refused(pull_back):
    pull, _ = pull_back(0.0)
    angle = np.linspace(0, 40, 400)
    loop = np.column_stack([1.2 * np.cos(angle), 1.2 * np.sin(angle), 0.02 * angle])
    monkey = line.Line.__new__(line.Line)
    monkey.s_mm = np.linspace(0, 48, 400)
    monkey._points = loop
    monkey._tangents = np.gradient(loop, axis=0) / np.linalg.norm(np.gradient(loop, axis=0), axis=1)[:, None]
    monkey._first = line._parallel_transport(loop, monkey._tangents)
    with pytest.raises(InputError, match="run into each other"):
        run.loft_pullback(pull, frame_placement.centreline_placement(pull, monkey))


def write_lines(path, *lines):
    points, cells, poly = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
    for line_points in lines:
        ids = [points.InsertNextPoint(*p) for p in line_points]
        cells.InsertNextCell(len(ids), ids)
    poly.SetPoints(points)
    poly.SetLines(cells)
    vtp.write(path, poly)


def test_which_of_several_lines_must_be_said(tmp_path):
    write_lines(tmp_path / "lines.vtp", *(centred_line() + [offset, 0, 0] for offset in (0.0, 30.0)))
    with pytest.raises(InputError, match="several lines"):
        line.read(tmp_path / "lines.vtp", "mm")
    with pytest.raises(InputError, match="no such line"):
        line.read(tmp_path / "lines.vtp", "mm", 3)
    with pytest.raises(InputError, match="no such line"):
        line.read(tmp_path / "lines.vtp", "mm", 0)
    one, two = (line.read(tmp_path / "lines.vtp", "mm", number) for number in (1, 2))
    assert two.frame_at(np.array([5.0]))[0] - one.frame_at(np.array([5.0]))[0] == pytest.approx(
        np.array([[30, 0, 0]]), abs=0.01
    )


@pytest.mark.parametrize("count, what", [(4, None), (3, "too few points"), (0, "not finite.*point 2 of line 1")])
def test_a_line_needs_four_points_with_places(tmp_path, count, what):
    places = centred_line()[:: len(centred_line()) // 3][: count or 4].copy()
    if count == 0:
        places[1, 2] = np.nan
    write_lines(tmp_path / "line.vtp", places)
    if what is None:
        assert line.read(tmp_path / "line.vtp", "mm").length_mm > 35
    else:
        with pytest.raises(InputError, match=f"(?s){what}"):
            line.read(tmp_path / "line.vtp", "mm")


@pytest.mark.parametrize("scale, units", [(1e-3, "mm"), (0.028, "mm"), (1e-3, "m")])
def test_a_line_in_metres_is_told_by_its_length(tmp_path, scale, units):
    """A line of 40 mm in metres is refused. A line of 1.1 mm is read here, but will be too short for its pull-back."""
    write_lines(tmp_path / "line.vtp", scale * centred_line())
    if (scale, units) == (1e-3, "mm"):
        with pytest.raises(InputError, match="(?s)shorter than any vessel.*0.0396 mm as mm.*centreline: units"):
            line.read(tmp_path / "line.vtp", units)
    else:
        assert line.read(tmp_path / "line.vtp", units).length_mm > 1.05
    write_lines(tmp_path / "line.vtp", 10 * centred_line())
    assert line.read(tmp_path / "line.vtp", "mm").length_mm < 400
    with pytest.raises(InputError, match="(?s)longer than any vessel.* mm as m.*centreline: units"):
        line.read(tmp_path / "line.vtp", "m")


def test_frames_carried_along_a_line_do_not_turn_about_it():
    """On a helix the frame turns relative to the normal by the integral of the torsion, which is known."""
    angle = np.linspace(0, 4 * np.pi, 4000)
    a, b = 10.0, 3.0
    helix = line.Line(np.column_stack([a * np.cos(angle), a * np.sin(angle), b * angle]))
    s = np.array([5.0, helix.length_mm - 5.0])
    _, tangent, first, second = helix.frame_at(s)
    at = s / np.hypot(a, b)
    normal = np.column_stack([-np.cos(at), -np.sin(at), 0 * at])
    seen = np.arctan2((normal * second).sum(axis=1), (normal * first).sum(axis=1))
    expected = b / (a**2 + b**2) * (s[1] - s[0])
    assert (seen[1] - seen[0] - expected + np.pi) % (2 * np.pi) - np.pi == pytest.approx(0, abs=0.01)


@pytest.mark.parametrize("bend_mm, fits", [(1.53, True), (1.47, False)])
def test_an_axis_may_bend_as_sharply_as_the_lumen_is_wide(bend_mm, fits):
    """Rings with a radius of 1.5 mm lie on an arc. If the arc's radius is smaller, they cross on its inside."""
    around = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    along = np.linspace(0, np.pi / 2, 30)
    out = bend_mm + 1.5 * np.cos(around)
    ring_list = np.array([np.column_stack([out * np.cos(a), out * np.sin(a), 1.5 * np.sin(around)]) for a in along])
    if fits:
        points, triangles, _ = loft.surface(ring_list, along)
        assert abs(loft.volume_mm3(points, triangles)) == pytest.approx(
            np.pi * 1.5**2 * bend_mm * np.pi / 2, rel=0.01
        )
    else:
        with pytest.raises(InputError, match="(?s)run into each other.*bends within the lumen.*smoother centreline"):
            loft.surface(ring_list, along)
