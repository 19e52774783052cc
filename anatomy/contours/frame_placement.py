"""Places the frames of a pull-back in space: along a straight axis, or on a centreline."""

from dataclasses import dataclass, field

import numpy as np

from common.errors import InputError

from . import rings
from .reading.outlines import centroid

# Each landmark gives a place of the pull-back along the line. A landmark whose place is farther than this from the mean
# is refused. A landmark's frame can be picked to within 2 or 3 mm.
LARGEST_DISAGREEMENT_MM = 3.0
LEAST_AXIS_DISTANCE_MM = (
    0.2  # least distance of a landmark from the axis: nearer, half a voxel of error may turn its direction by 90 deg
)
# Largest distance of a landmark from the lumen's centre, in lumen radii. Landmarks lie on the wall, in the mouth of a
# branch or on the rim of an ostium.
FARTHEST_RADII = 3.0
# Each landmark also gives an angle of the images about the line. A warning is given if one differs by more than this
# from the mean. The mouth of a side branch is marked to about 0.4 mm, which is 15 degrees on the wall of a lumen 3 mm
# wide. The catheter itself turns with a standard deviation of 10 degrees over 9 mm (README.md).
USUAL_TURN_DEG = 15.0
LARGEST_TURN_DEG = 45.0  # a larger difference is refused: the tables are mirrored, or points are mixed up


@dataclass
class FramePlacement:
    """How frames are placed in space.

    to_space(z_mm (k,), points (k, n, 2)): function that takes points in the planes of frames at k values of z, in mm.
    It returns the points in space (k, n, 3), in mm. axis_description: the axis in words. report: {name: number},
    written to contours.json.
    """

    to_space: object
    axis_description: str
    report: dict = field(default_factory=dict)


def centres(frames, on_outer_wall):
    """Centroid (frames, 2) in mm of the lumen or of the outer wall in each frame.

    on_outer_wall: whether to take the outer wall. Where it was not traced, the vector from the lumen's centroid to the
    outer wall's is interpolated between the traced frames. If no frame has an outer wall, the lumen's centroids are
    returned.
    """
    lumen = np.array([centroid(rings.smooth(frame.lumen)) for frame in frames])
    traced = np.array([frame.outer_wall is not None for frame in frames])
    if not on_outer_wall or not traced.any():
        return lumen
    z = np.array([frame.z_mm for frame in frames])
    away = np.array(
        [centroid(rings.smooth(f.outer_wall)) - c for f, c in zip(frames, lumen) if f.outer_wall is not None]
    )
    return lumen + rings.interpolator(z[traced], away)(z)


def straight_placement(pullback):
    """FramePlacement along the tables' own z axis, with x and y as in the image.

    The axis runs through the centroid of each frame's outer wall, or of its lumen if no outer wall is known. The images
    are centred on the catheter. The catheter cannot serve as the axis, since its path through the vessel is unknown.
    """
    centre = rings.interpolator(pullback.z_mm, centres(pullback.frames, on_outer_wall=True))

    def place_points(z_mm, points):
        across = points - centre(z_mm)[:, None]
        of_tables = np.broadcast_to(pullback.sign * z_mm[:, None, None], across.shape[:2] + (1,))
        return np.concatenate([across, of_tables], axis=2)

    known = any(frame.outer_wall is not None for frame in pullback.frames)
    on = "outer wall's centre" if known else "lumen's centre"
    return FramePlacement(place_points, f"straight axis through the {on}")


def centreline_placement(pullback, line, landmark_points_mm=(), proximal_s_mm=None, rotation_deg=0.0, mirrored=False):
    """FramePlacement on a Line: the lumen's centroids lie on the line, the frames' planes across it, z runs along it.

    landmark_points_mm: [(3,)], where the pull-back's landmarks lie in the line's space. They fix the place along the
    line and the turn about it. Without landmarks proximal_s_mm (default 0) is the arc length of the proximal frame on
    the line. rotation_deg then turns the images against the line's vectors across it (Line.frame_at). mirrored: whether
    x, y and z of the tables are left-handed; otherwise they are right-handed, from whichever end z rises. Raises
    InputError if the line is too short, if landmarks contradict each other, or if one lies on the line or far from it.
    """
    z = pullback.z_mm
    centre = rings.interpolator(z, centres(pullback.frames, on_outer_wall=False))
    flip = np.array([1.0, -pullback.sign if mirrored else pullback.sign])  # makes x, y and the frames' z right-handed
    report = {}
    if len(landmark_points_mm):
        shift, turn, report = _align_landmarks(pullback, line, np.asarray(landmark_points_mm, float), centre, flip)
    else:
        shift, turn = z[-1] + (proximal_s_mm or 0.0), np.radians(rotation_deg)
    first, last = shift - z[-1], shift - z[0]
    if first < -1e-6 or last > line.length_mm + 1e-6:
        value = f"frames from {first:.1f} to {last:.1f} mm along a line of {line.length_mm:.1f} mm"
        remedy = (
            "check the units of both; use fewer frames (z_range_mm), lay them elsewhere (proximal_s_mm, landmarks),"
        )
        remedy += " or give a longer line"
        raise InputError("the pull-back reaches beyond its centreline", "centreline", value, remedy)

    def place_points(z_mm, points):
        across = (points - centre(z_mm)[:, None]) * flip
        place, tangent, one, two = line.frame_at(np.clip(shift - z_mm, 0, line.length_mm))
        x, y = _image_axes(one, two, turn)
        return place[:, None] + across[..., :1] * x[:, None] + across[..., 1:] * y[:, None]

    report.update({"distal_s_mm": last, "proximal_s_mm": first, "rotation_deg": float(np.degrees(turn))})
    return FramePlacement(
        place_points, "centreline" + (", by landmarks" if len(landmark_points_mm) else ", least twist"), report
    )


def warnings(placement):
    """Yields a warning if the landmarks disagree about the turn by more than the usual error of marking."""
    off = placement.report.get("landmarks_differ_deg", 0.0)
    if off > USUAL_TURN_DEG:
        yield (
            f"the landmarks differ by {off:.0f} degrees about the centreline from their mean, {USUAL_TURN_DEG:g} are"
            " usual: check mirrored (true if x, y, z are left-handed: images seen from the other side, or z alone"
            " turned round), the points' order, and the place of each in the table and on the line"
        )


def _image_axes(one, two, turn):
    """Directions of the image's x and y, each (k, 3), for the line's vectors `one`, `two` (k, 3) and a turn in radians.

    Together with the frames' z they are right-handed. z points towards the proximal end, against the line's tangent.
    """
    x = np.cos(turn) * one - np.sin(turn) * two
    y = -np.sin(turn) * one - np.cos(turn) * two
    return x, y


def _align_landmarks(pullback, line, points, centre, flip):
    """(shift, turn, report) from the pull-back's landmarks and their places `points` (m, 3) in space.

    shift: arc length on the line plus z in mm; this sum is the same for all frames. turn: angle in radians by which the
    images are turned about the line. report: {name: number}, how far the landmarks disagree with shift and turn.
    centre: function of z that gives the lumen's centroids. flip (2,): factors 1 or -1 of the image's x and y.
    """
    if len(points) != len(pullback.landmarks):
        value = f"{len(points)} points for {len(pullback.landmarks)} landmarks"
        raise InputError(
            "landmarks without a partner", "landmark_points_mm", value, "a point for each of the table, in its order"
        )
    z = np.array([mark[0] for mark in pullback.landmarks])
    low, high = pullback.z_mm[[0, -1]]
    outside = np.flatnonzero((z < low - 1e-6) | (z > high + 1e-6))
    if outside.size:
        first, last = sorted(pullback.sign * np.array([low, high]))
        at = pullback.sign * z[outside[0]]
        value = f"landmark {outside[0] + 1} at z {at:.2f} mm, frames {first:.2f} to {last:.2f} mm"
        remedy = "widen z_range_mm, or leave the landmark and its point out"
        raise InputError("a landmark outside the frames", "landmarks", value, remedy)
    nearest = np.array([line.nearest(point) for point in points])
    sums = nearest + z
    shift = float(sums.mean())
    across = (np.array([mark[1] for mark in pullback.landmarks]) - centre(z)) * flip
    _check_landmark_distance(pullback, z, "landmarks", np.linalg.norm(across, axis=1))
    _check_landmark_distance(
        pullback, z, "landmark_points_mm", np.linalg.norm(points - line.frame_at(nearest)[0], axis=1)
    )
    place, tangent, one, two = line.frame_at(np.clip(shift - z, 0, line.length_mm))
    away = points - place
    u, v = (away * one).sum(axis=1), (away * two).sum(axis=1)
    for where, distance in (("landmark_points_mm", np.hypot(u, v)), ("landmarks", np.linalg.norm(across, axis=1))):
        if distance.min() < LEAST_AXIS_DISTANCE_MM:
            value = f"landmark {distance.argmin() + 1}, {distance.min():.2f} mm from it"
            remedy = f"a place on the wall or in a branch's mouth, {LEAST_AXIS_DISTANCE_MM} mm or more from the lumen's"
            remedy += " centre"
            raise InputError("a landmark on the axis tells no rotation", where, value, remedy)
    # A point at angle a in the image lies at angle -a - turn in the plane of `one` and `two` (_image_axes). So each
    # landmark gives the turn as minus the sum of its two angles.
    angles = -np.arctan2(v, u) - np.arctan2(across[:, 1], across[:, 0])
    turn = float(np.angle(np.exp(1j * angles).mean()))
    off = np.abs(np.degrees(np.angle(np.exp(1j * (angles - turn)))))
    along = np.abs(sums - shift)
    report = {"landmarks_differ_mm": float(along.max()), "landmarks_differ_deg": float(off.max())}
    if along.max() > LARGEST_DISAGREEMENT_MM or off.max() > LARGEST_TURN_DEG:
        value = (
            f"landmark {along.argmax() + 1} lies {along.max():.1f} mm off along the line,"
            f" landmark {off.argmax() + 1} {off.max():.0f} degrees about it"
        )
        limits = f"at most {LARGEST_DISAGREEMENT_MM:g} mm and {LARGEST_TURN_DEG:g} degrees"
        remedy = f"{limits}: check the points' order, mirrored (true if x, y, z are left-handed), and which line it is"
        raise InputError("landmarks contradict each other", "landmark_points_mm", value, remedy)
    return shift, turn, report


def _check_landmark_distance(pullback, z, where, distance):
    """Raises InputError if a landmark is more than FARTHEST_RADII radii from the lumen's centre.

    distance (m,): distance of the landmarks from the centre, in mm. The radius is the median over all frames, or the
    radius at the landmark's z (m,) if that is larger. where: the setting to name in the message.
    """
    radii = np.sqrt([rings.area_mm2(frame.lumen) / np.pi for frame in pullback.frames])
    radius = np.maximum(rings.interpolator(pullback.z_mm, radii)(z), np.median(radii))
    k = int((distance / radius).argmax())
    if distance[k] > FARTHEST_RADII * radius[k]:
        value = f"landmark {k + 1}, {distance[k]:.1f} mm from the lumen's centre, whose radius is {radius[k]:.2f} mm"
        remedy = (
            f"within {FARTHEST_RADII:g} radii: check its units, and that x, y, z are those of the table or the line"
        )
        raise InputError("a landmark lies far from its vessel", where, value, remedy)
