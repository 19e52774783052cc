"""The command that makes a lumen with plaque, the record contours.json and a picture from contour tables."""

import pathlib
import sys

import numpy as np

from common import vtp
from common.errors import InputError
from common.files import write_json
from common.patient.plaque_types import CALCIFIED, NONE

from . import frame_placement, line, loft, outer_wall, picture, plaque, pullback, rings, warnings

SCHEMA = "vci-contours-1"
ARRAYS = ("plaque_thickness_mm", "plaque_type")  # point data of lumen.vtp
EDGE_MM = 0.12  # length of edges of the lofted surface; `lumen process` remeshes it later
SHADOW_ARC_DEG = 90  # calcium over a wider arc hides the outer wall behind it (Mintz et al., JACC 37 (2001) 1478)
FEWEST_AROUND, MOST_AROUND = 64, 200  # points round a ring


def run(files, out, units="mm", healthy_wall_mm="auto", reading=None, placement_settings=None):
    """Writes lumen.vtp, contours.json and contours.png into the folder `out`. Returns the content of contours.json.

    files, units: as for pullback.read(). healthy_wall_mm: "auto" or mm. reading: further arguments of pullback.read(),
    {z_from, z_range_mm, drop_frames}. placement_settings: None for a straight axis; else {centreline, line, units} as
    for line.read(), and {landmark_points_mm, proximal_s_mm, rotation_deg, mirrored} as for
    frame_placement.centreline_placement(). Raises InputError.
    """
    pull = pullback.read(files, units, **(reading or {}))
    pull.warnings.extend(warnings.find_warnings(pull))
    placement = (
        _centreline_placement(pull, dict(placement_settings))
        if placement_settings
        else frame_placement.straight_placement(pull)
    )
    lumen = loft_pullback(pull, placement)
    arrays, plaque_summary = _plaque(pull, files, healthy_wall_mm, lumen)
    surface = vtp.surface(lumen["points"], lumen["triangles"])
    vtp.add_array(surface.GetCellData(), "region_id", lumen["region"].astype(np.int32))
    for name, values in arrays.items():
        vtp.add_array(surface.GetPointData(), name, values)
    document = _document(pull, placement, lumen, plaque_summary)
    out = pathlib.Path(out)
    vtp.write(out / "lumen.vtp", surface)
    write_json(out / "contours.json", document)
    around = lumen["frame_rings"].shape[1]
    walls = [arrays[key][: len(lumen["z_mm"]) * around].reshape(-1, around) if arrays else None for key in ARRAYS]
    picture.draw(document, pull.sign * lumen["z_mm"], *walls, out / "contours.png")
    for warning in pull.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    return document


def loft_pullback(pull, placement):
    """The lofted lumen of a Pullback, placed by a FramePlacement, as a dict.

    points, triangles, region: results of loft.surface(). z_mm (k,): z of the surface's rings. frame_rings
    (frames, n, 2): rings of the frames, in mm in their planes.
    """
    longest = max(_perimeter(frame.lumen) for frame in pull.frames)
    around = int(np.clip(np.ceil(longest / EDGE_MM), FEWEST_AROUND, MOST_AROUND))
    frame_rings = np.array([rings.ring_from_outline(frame.lumen, around) for frame in pull.frames])
    steps = np.maximum(np.ceil(np.diff(pull.z_mm) / EDGE_MM).astype(int), 1)
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(pull.z_mm, pull.z_mm[1:], steps)]
    z = np.concatenate([*parts, pull.z_mm[-1:]])
    placed = placement.to_space(z, rings.scale_to_areas(rings.interpolator(pull.z_mm, frame_rings)(z), _areas(pull, z)))
    points, triangles, region = loft.surface(placed, pull.sign * z)
    return {"points": points, "triangles": triangles, "region": region, "z_mm": z, "frame_rings": frame_rings}


def _areas(pull, z_mm):
    """Areas in mm2 of the lumen at z_mm (k,), interpolated monotonically between the areas of the frames' outlines."""
    return rings.interpolator(pull.z_mm, np.array([rings.area_mm2(frame.lumen) for frame in pull.frames]))(z_mm)


def _centreline_placement(pull, placement_settings):
    """The FramePlacement on a centreline.

    placement_settings: dict as for run(). The keys of line.read() are removed from it.
    """
    axis = line.read(
        placement_settings.pop("centreline"),
        placement_settings.pop("units", "mm"),
        placement_settings.pop("line", None),
    )
    pull.warnings.extend(axis.warnings)
    placement = frame_placement.centreline_placement(pull, axis, **placement_settings)
    pull.warnings.extend(frame_placement.warnings(placement))
    return placement


def _perimeter(outline):
    return np.linalg.norm(outline - np.roll(outline, 1, axis=0), axis=1).sum()


def _plaque(pull, files, healthy_wall_mm, lumen):
    """(arrays, summary) of the plaque.

    arrays: {name: values at the surface's points}, empty without an outer wall. summary: dict with `kinds` (frames, n),
    the plaque types at the points of frame_rings. With an outer wall it also has `distance` (frames, n) in mm from
    lumen to outer wall, and `healthy_wall_mm`. lumen: result of loft_pullback().
    """
    frames, frame_rings = pull.frames, lumen["frame_rings"]
    kinds = np.array([plaque.plaque_types(frame, ring) for frame, ring in zip(frames, frame_rings)])
    if not files.get("outer_wall"):
        if any(frame.regions for frame in frames):
            remedy = "give the outer wall's table (EEM), which tells their depth, or leave calcium and lipid out"
            raise InputError("calcium or lipid without an outer wall", "outer_wall", "missing", remedy)
        pull.warnings.append(
            "no outer wall (outer_wall): the plaque behind the lumen is estimated from its narrowing alone"
        )
        return {}, {"kinds": kinds}
    traced = outer_wall.is_traced(frames)
    if not traced.any():
        remedy = "the first column names a frame alike in both tables; check z_range_mm and drop_frames"
        value = f"frames of the lumen: {', '.join(str(frame.name) for frame in frames[:5])}, ..."
        raise InputError("no frame of the outer wall is one of the lumen", files["outer_wall"], value, remedy)
    plaque.check_regions(frames, files)
    distance = plaque.wall_distances_mm(frames, pull.z_mm, frame_rings, files["outer_wall"])
    pull.warnings.extend(outer_wall.warnings(pull))
    healthy = plaque.healthy_wall_mm(distance[traced], healthy_wall_mm)
    if healthy_wall_mm == "auto" and distance[traced].mean(axis=1).min() > healthy:
        pull.warnings.append(
            f"no healthy frame: the thinnest wall has {distance[traced].mean(axis=1).min():.2f} mm; "
            f"{healthy:.2f} mm of it are taken for the healthy wall (healthy_wall_mm says otherwise)"
        )
    _warn_of_thin_walls(pull, distance.mean(axis=1))
    z = lumen["z_mm"]
    thickness = np.maximum(rings.interpolator(pull.z_mm, distance)(z) - healthy, 0)
    low, high = outer_wall.known_range_mm(frames, pull.z_mm)
    # NaN: the section lies beyond the frames with a traced outer wall. For NaN `lumen process` keeps its own estimate
    # of the plaque thickness, which it makes from the narrowing.
    thickness[(z < low - 1e-9) | (z > high + 1e-9)] = np.nan
    nearest = np.abs(z[:, None] - pull.z_mm[None]).argmin(axis=1)
    kind = np.where(thickness > 0, kinds[nearest], NONE)
    inner = len(lumen["points"]) - thickness.size  # number of the caps' inner points, which get no plaque
    _warn_of_shadows(pull, frame_rings, kinds)
    values = (
        np.concatenate([thickness.ravel(), np.zeros(inner)]),
        np.concatenate([kind.ravel(), np.zeros(inner, int)]).astype(np.int32),
    )
    return dict(zip(ARRAYS, values)), {"kinds": kinds, "distance": distance, "healthy_wall_mm": healthy}


def _warn_of_thin_walls(pull, means):
    """Warns of traced walls that are too thin for an artery. means (frames,): mean wall thickness in mm."""
    thin = [k for k, frame in enumerate(pull.frames) if frame.outer_wall is not None]
    thin = [k for k in thin if means[k] < plaque.THINNEST_WALL_MM]
    if thin:
        at = min(thin, key=lambda k: means[k])
        pull.warnings.append(
            f"the wall is thinner than {plaque.THINNEST_WALL_MM:g} mm, the media alone, in {len(thin)} frames:"
            f" {max(means[at], 0):.2f} mm on average in frame {pull.frames[at].name}, z"
            f" {pull.sign * pull.frames[at].z_mm:.1f} mm. Is outer_wall the table of the lumen, or of another membrane?"
        )


def _warn_of_shadows(pull, frame_rings, kinds):
    """Warns of frames in which calcium hides much of the outer wall. kinds: plaque types of the rings' points."""
    arcs = [plaque.arc_deg(kind, ring, CALCIFIED) for kind, ring in zip(kinds, frame_rings)]
    wide = [pull.sign * frame.z_mm for frame, arc in zip(pull.frames, arcs) if arc > SHADOW_ARC_DEG]
    if wide:
        pull.warnings.append(
            f"calcium shadows more than {SHADOW_ARC_DEG} degrees of the outer wall in {len(wide)} frames, "
            f"z {min(wide):.1f} to {max(wide):.1f} mm: the thickness there is what the reader assumed"
        )


def _document(pull, placement, lumen, plaque_summary):
    """The content of contours.json (docs/design.md). plaque_summary: summary from _plaque()."""
    rows = []
    for k, (frame, ring) in enumerate(zip(pull.frames, lumen["frame_rings"])):
        distance = plaque_summary["distance"][k] if "distance" in plaque_summary else np.array([np.nan])
        traced = frame.outer_wall is not None
        rows.append(
            {
                "frame": frame.name,
                "z_mm": pull.sign * frame.z_mm,
                "lumen_area_mm2": rings.area_mm2(frame.lumen),
                "outer_wall_area_mm2": rings.area_mm2(frame.outer_wall) if traced else None,
                "plaque_burden_percent": plaque.burden_percent(frame),
                "wall_mean_mm": float(distance.mean()) if traced else None,
                "wall_max_mm": float(distance.max()) if traced else None,
                "calcium_arc_deg": plaque.arc_deg(plaque_summary["kinds"][k], ring, CALCIFIED),
            }
        )
    return {
        "schema": SCHEMA,
        "axis": placement.axis_description,
        "placing": placement.report,
        "length_mm": float(np.ptp(pull.z_mm)),
        "volume_mm3": loft.volume_mm3(lumen["points"], lumen["triangles"]),
        "healthy_wall_mm": plaque_summary.get("healthy_wall_mm"),
        "frames": rows,
        "warnings": pull.warnings,
    }
