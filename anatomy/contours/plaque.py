"""Plaque from the outlines of lumen and outer wall: its thickness beyond a healthy wall, and its type."""

import numpy as np
from matplotlib.path import Path
from scipy.spatial import cKDTree

from common.errors import InputError
from common.patient.plaque_types import CALCIFIED, FIBROUS, LIPID

from . import outer_wall, rings
from .reading.outlines import centroid

TYPE_OF_TABLE = {"lipid": LIPID, "calcium": CALCIFIED}  # where a ray meets both, the later entry (calcium) counts
# Largest thickness (mm) of a healthy wall. A normal intima is below 0.3 mm by IVUS (0.22 to 0.25 mm at 30 to 40 years).
# The media behind it has 0.2 mm by histology, but is thinner beneath plaque (0.1 mm in vivo: Gussenhoven et al., Am J
# Cardiol 68 (1991) 1625).
THICKEST_HEALTHY_MM = 0.3
# A thinner mean wall gives a warning: the media alone, beneath plaque, has this thickness (as above). The thinnest
# frame of the real pull-back has 0.12 mm.
THINNEST_WALL_MM = 0.1
LUMEN_CROSSING_MM = 0.1  # the lumen may reach this far outside its outer wall: hand-drawn outlines that touch may cross
REGION_CROSSING_MM = (
    0.3  # a region may reach this far outside the outer wall, which is guessed behind calcium; shipped data: 0.07 mm
)
STEP_MM = 0.02  # distance between the points that are tested along a ray from the lumen outwards


def wall_distance_mm(ring, outer_wall):
    """Distance (n,) in mm from the ring's points (n, 2) to the outer wall's outline; negative outside it."""
    fine = rings.smooth(outer_wall)
    distance = cKDTree(fine).query(ring)[0]
    return np.where(Path(fine).contains_points(ring), distance, -distance)


def wall_distances_mm(frames, z_mm, ring_list, path):
    """Distance (frames, n) in mm from each point of the lumen's outline to the outer wall of its frame.

    z_mm (frames,): places of the frames, rising. ring_list (frames, n, 2): the lumen's outlines in mm. path: file of
    the outer wall's table, named in messages. At least one frame needs a traced outer wall. A frame without one gets an
    interpolated wall (outer_wall.interpolated_outlines). Such a wall may cross the lumen, so the distance there is at
    least 0. Raises InputError if a lumen crosses its traced outer wall.
    """
    walls = outer_wall.interpolated_outlines(frames, z_mm, len(ring_list[0]))
    found = np.empty((len(frames), len(ring_list[0])))
    for row, frame, ring, wall in zip(found, frames, ring_list, walls):
        if frame.outer_wall is None:
            row[:] = np.maximum(wall_distance_mm(ring, wall), 0)
            continue
        row[:] = wall_distance_mm(ring, frame.outer_wall)
        _check_inside_wall(row, LUMEN_CROSSING_MM, "the lumen", f"{path}: frame {frame.name}", frame)
    return found


def check_regions(frames, paths):
    """Raises InputError if calcium or lipid lies within the lumen, or outside a traced outer wall.

    paths: {calcium, lipid: file of its table}, for messages.
    """
    for frame in frames:
        for name, several in frame.regions.items():
            where = f"{paths[name]}: frame {frame.name}"
            for region in several:
                _check_outside_lumen(region, name, where, frame)
                if frame.outer_wall is not None:
                    distance = wall_distance_mm(region, frame.outer_wall)
                    _check_inside_wall(distance, REGION_CROSSING_MM, name, where, frame)


def _check_outside_lumen(region, what, where, frame):
    """Raises InputError if a region (n, 2) lies wholly within the lumen, where no ray into the wall would meet it."""
    if (distance := wall_distance_mm(region, frame.lumen)).min() > 0:
        value = f"all of it {distance.min():.2f} mm or more within the lumen's outline"
        remedy = f"trace {what} behind the lumen, in the same coordinates, or leave the frame out"
        raise InputError(f"{what} lies within the lumen", where, value, f"{remedy} (drop_frames: [{frame.name}])")


def _check_inside_wall(distance, largest_mm, what, where, frame):
    """Raises InputError if an outline reaches more than largest_mm outside the outer wall.

    distance (n,): distance in mm of its points from the outer wall, negative outside (wall_distance_mm). what: the
    outline's name in the message.
    """
    if distance.min() < -largest_mm:
        value = f"{-distance.min():.2f} mm outside it"
        remedy = f"trace the outer wall (EEM) round {what}, in the same coordinates, or leave the frame out"
        remedy += f" (drop_frames: [{frame.name}])"
        raise InputError(f"{what} runs outside the outer wall", where, value, remedy)


def healthy_wall_mm(distance, setting="auto"):
    """Thickness in mm of the healthy wall: `setting`, or with "auto" the mean over the frame with the thinnest wall.

    distance (frames, n): result of wall_distances_mm() for the traced frames. With "auto" the thickness is at most
    THICKEST_HEALTHY_MM: if the thinnest wall is thicker, the pull-back has no healthy frame.
    """
    if setting != "auto":
        return float(setting)
    return float(min(distance.mean(axis=1).min(), THICKEST_HEALTHY_MM))


def plaque_types(frame, ring):
    """Type (n,) of plaque (common.patient.plaque_types) behind each point of a frame's ring (n, 2), at any thickness.

    A ray runs from the lumen's centroid through the point. The point gets the type of a traced region (calcium, lipid)
    that the ray meets outside the lumen. The region's depth does not matter, since the stiffest layer carries the load
    round the vessel.
    """
    kind = np.full(len(ring), FIBROUS)
    centre = centroid(ring)
    out = ring - centre
    out /= np.linalg.norm(out, axis=1)[:, None]
    for name, value in TYPE_OF_TABLE.items():
        for region in map(rings.smooth, frame.regions.get(name, ())):
            reach = np.linalg.norm(region - centre, axis=1).max()
            steps = np.arange(0, reach, STEP_MM)
            samples = ring[:, None] + steps[None, :, None] * out[:, None]
            inside = Path(region).contains_points(samples.reshape(-1, 2)).reshape(len(ring), -1)
            kind[inside.any(axis=1)] = value
    return kind


def arc_deg(kind, ring, value):
    """Arc in degrees, seen from the lumen's centroid, over which the points of a ring (n, 2) have the type `value`.

    kind (n,): types of the points.
    """
    relative = ring - centroid(ring)
    angle = np.unwrap(np.arctan2(relative[:, 1], relative[:, 0]), period=2 * np.pi)
    share = np.abs(np.roll(angle, -1) - np.roll(angle, 1))
    share = 0.5 * np.minimum(share, 2 * np.pi - share)
    return float(np.degrees(share[kind == value].sum()))


def burden_percent(frame):
    """Plaque burden in percent: area between lumen and outer wall over area within the outer wall.

    None if the frame has no outer wall.
    """
    if frame.outer_wall is None:
        return None
    outer = rings.area_mm2(frame.outer_wall)
    return 100 * (outer - rings.area_mm2(frame.lumen)) / outer
