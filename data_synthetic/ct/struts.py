"""Stent struts for the phantom: rings of waves laid on the lumen's wall, or the lines of a file."""

import numpy as np
import vtk
from scipy.interpolate import PchipInterpolator

from common import vtp
from common.errors import InputError
from common.implicit.curves import Curve


RING_PITCH_MM = 1.3  # distance between the rings of a stent
WAVE_AMPLITUDE_MM = 0.45  # half the height of a ring's wave
PIECE_LENGTH_MM = 0.02  # length of a piece of a strut
OVERHANG_MM = 0.5  # a stent may reach beyond the vessel's end by this, since straightening may shorten the vessel


def struts_on_wall(poly, axis_points_mm, start_s_mm, end_s_mm, crowns, links, thickness_mm):
    """Centre lines (n, 3) mm and lengths (n,) mm of strut pieces of a stent against the wall of a lumen.

    The stent goes from start_s_mm to end_s_mm along the axis (m, 3). It has a ring of `crowns` waves about every
    RING_PITCH_MM, and `links` straight bars between neighbouring rings. The struts are thickness_mm thick and touch the
    wall from inside.
    """
    axis = Curve(axis_points_mm)
    tree = vtk.vtkOBBTree()
    tree.SetDataSet(poly)
    tree.BuildLocator()
    count = max(int(round((end_s_mm - start_s_mm - 2 * WAVE_AMPLITUDE_MM) / RING_PITCH_MM)), 1) + 1
    rings = np.linspace(start_s_mm + WAVE_AMPLITUDE_MM, end_s_mm - WAVE_AMPLITUDE_MM, count)
    paths = []
    for number, s in enumerate(rings):
        theta = np.linspace(0, 2 * np.pi, 40 * crowns + 1)
        paths.append((s + WAVE_AMPLITUDE_MM * np.sin(crowns * theta), theta))
        if number + 1 < count:
            for link in range(links):
                # A link runs at a constant angle, from a crest or trough of this ring's wave to the crest or trough of
                # the next ring.
                angle = 2 * np.pi * (np.floor(link * crowns / links) + 0.25 + 0.5 * (number % 2)) / crowns
                height = WAVE_AMPLITUDE_MM * np.sin(crowns * angle)
                paths.append((np.linspace(s, rings[number + 1], 40) + height, np.full(40, angle)))
    lines = [_project_to_wall(tree, axis, s, theta, thickness_mm) for s, theta in paths]
    return _split_into_pieces(lines)


def _project_to_wall(tree, axis, s_mm, theta, thickness_mm):
    _, normal, binormal = axis.frame(s_mm)
    rays = np.cos(theta)[:, None] * normal + np.sin(theta)[:, None] * binormal
    centres, hits, distances = axis.point(s_mm), vtk.vtkPoints(), []
    for centre, ray in zip(centres, rays):
        tree.IntersectWithLine(centre, centre + 6 * ray, hits, None)
        distance = np.linalg.norm(np.array(hits.GetPoint(0)) - centre) if hits.GetNumberOfPoints() else np.nan
        distances.append(distance)
    radius = np.array(distances)
    # Where a ray leaves through an ostium, the strut bridges it at the median radius instead of following the branch's
    # wall.
    median_radius = np.nanmedian(radius)
    radius = np.where(np.isnan(radius) | (radius > 1.35 * median_radius), median_radius, radius) - 0.5 * thickness_mm
    return centres + radius[:, None] * rays


def _split_into_pieces(lines):
    places, lengths = [], []
    for line in lines:
        along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        count = max(int(np.ceil(along[-1] / PIECE_LENGTH_MM)), 1)
        middle = (np.arange(count) + 0.5) * along[-1] / count
        places.append(PchipInterpolator(along, line)(middle))
        lengths.append(np.full(count, along[-1] / count))
    return np.concatenate(places), np.concatenate(lengths)


def read_struts(path):
    """Strut pieces of a vtp file of lines: centres (n, 3) mm and lengths (n,) mm. Raises InputError."""
    poly = vtp.read(path, "give the struts of a deployed stent")
    points, lines = vtp.points(poly), vtp.lines(poly)
    if not lines:
        raise InputError("no struts in the file", path, "no lines", "give a file of lines, <stent>_struts.vtp")
    runs = [points[line] for line in lines]
    return _split_into_pieces([run for run in runs if np.ptp(run, axis=0).max() > 0])


def struts_of_scene(scene, poly, centreline, where):
    """Strut pieces of every stent that the scene's procedure places, laid on the wall; None without a stent.

    Returns centres (n, 3) mm and volumes (n,) mm3 of the pieces of square struts, as thick as the stent's. centreline:
    {branch name: points (n, 3) mm} of the same lumen. Raises InputError for a branch that the centreline lacks.
    """
    found = []
    for i, step in enumerate(scene["procedure"], start=1):
        for j, use in enumerate(step["devices"], start=1):
            key = f"{where}: procedure[{i}].devices[{j}]"
            if use["device"] not in scene["devices"]:
                raise InputError("no such device", f"{key}.device", use["device"], "list it under devices")
            device = scene["devices"][use["device"]]
            if device["kind"] != "stent":
                continue
            missing = [name for name in ("crowns", "links", "strut_thickness_mm") if name not in device]
            if missing:
                at = f"{where}: devices.{use['device']}.{missing[0]}"
                raise InputError("missing key", at, "nothing", "write the scene with the planning command")
            if use["branch"] not in centreline:
                raise InputError("no such branch", f"{key}.branch", use["branch"], ", ".join(centreline))
            axis, half, s = centreline[use["branch"]], 0.5 * device["length_mm"], use["centre_s_mm"]
            length = float(np.linalg.norm(np.diff(axis, axis=0), axis=1).sum())
            if not half - OVERHANG_MM <= s <= length - half + OVERHANG_MM:
                inside = f"between {half:.1f} and {length - half:.1f} mm"
                raise InputError("stent beyond the vessel", f"{key}.centre_s_mm", s, inside)
            size = device["strut_thickness_mm"]
            places, lengths = struts_on_wall(poly, axis, s - half, s + half, device["crowns"], device["links"], size)
            found.append((places, lengths * size**2))
    if not found:
        return None
    return np.concatenate([p for p, _ in found]), np.concatenate([v for _, v in found])
