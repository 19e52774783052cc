"""Finds a closed lumen in a CT volume from the vessels' end points, and warns of doubtful places."""

import pathlib
import sys

import numpy as np
from scipy.ndimage import gaussian_filter

from common import vtp
from common.documents import config
from common.errors import ComputationError, InputError
from common.files import write_json
from common.implicit import surface
from common.volume import SIGMA_PER_FWHM, Image

from . import calcium, ends_check, paths, saturation, volumes, wall, warnings
from .rays import blood as blood_level
from .rays import edges
from .tubes import LevelField, Tube, TubeField

SCHEMA = "vci-segmentation-1"
CENTRING_ROUNDS = 3  # rounds in which an axis is centred on its sections
FEW_RAYS = 8  # number of rays that suffices to sample the blood near the axis
USUAL_FWHM_MM = 0.7  # point spread that is assumed if the image does not show it
# Largest distance from the end of a user's line to the outlet's point. Both are picked by hand within the vessel, so
# they may differ by about its radius.
FARTHEST_END_MM = 2.0
FEWEST_OWN_SECTIONS = 5  # a branch needs this many sections outside its parent for radii of its own
LEAST_CONTRAST = 6.0  # contrast of blood and wall over noise; below it radii are off by 0.2 mm and ends may not close
MARGIN_MM = 30.0  # the volume is cropped this far round the end points, since vessels bow out between them


def run(image_path, ends, out, settings_path=None, centreline_path=None, series=None, stented=False):
    """Writes `out`/lumen.vtp (calcium as plaque) and `out`/segmentation.json. Returns the content of the latter.

    image_path, series: as for volumes.read(). ends: [(name, centre (3,) in mm)], the inlet first, in the volume's own
    coordinates, which are also the surface's. settings_path: file with the section `ct`; None for the defaults.
    centreline_path: a .vtp whose lines tell which vessels are meant. Without it the centreline is found in the image.
    Either centreline is then centred in the vessel. stented: whether the vessels hold a stent. Raises InputError, or
    ComputationError if the contrast is interrupted or too low.
    """
    settings = config.load_section(settings_path, "ct")["segmentation"]
    volume = volumes.read(image_path, series)
    lines = (
        "a .vtp of lines from the inlet on, each with its name in the cells' text array branch_name: main, side1, ..."
    )
    user_lines = vtp.read_named_lines(centreline_path, lines) if centreline_path else None
    ends_check.check(volume, ends)
    inside = [(name, volume.to_image(centre)) for name, centre in ends]
    user_lines = {name: volume.to_image(points) for name, points in user_lines.items()} if user_lines else None
    image = volume.image.cropped(np.array([centre for _, centre in inside]), MARGIN_MM)
    print("finding the centreline", file=sys.stderr)
    segmentation = segment(image, inside, settings, user_lines, stented)
    points, triangles, on_cap = _surface(segmentation, settings["surface_spacing_mm"], volume)
    thickness, kind = calcium.plaque_behind(points, segmentation)
    poly = vtp.surface(volume.to_patient(points), triangles)
    vtp.add_array(poly.GetPointData(), "plaque_thickness_mm", np.where(on_cap, 0.0, thickness))
    vtp.add_array(poly.GetPointData(), "plaque_type", np.where(on_cap, calcium.NONE, kind).astype(np.int32))
    document = _document(segmentation, settings, pathlib.Path(image_path).name, bool(user_lines), volume, stented)
    vtp.write(pathlib.Path(out) / "lumen.vtp", poly)
    write_json(pathlib.Path(out) / "segmentation.json", document)
    for warning in document["warnings"]:
        print(f"warning: {warning['message']}", file=sys.stderr)
    return document


def _surface(segmentation, spacing_mm, volume):
    """Closed surface of a segmentation, as surface.build() returns it.

    segmentation: result of segment(). Raises ComputationError with the settings to change.
    """
    try:
        return surface.build(segmentation["field"], spacing_mm)
    except ComputationError as error:
        ends = "; ".join(f"{name} {np.round(volume.to_patient(at), 2).tolist()}" for name, at in segmentation["ends"])
        contrast = (segmentation["blood_hu"] - edges.HEALTHY_WALL_HU) / max(segmentation["noise_hu"], 1e-9)
        value = f"with {spacing_mm} mm, ends {ends}, contrast over noise {contrast:.1f}"
        remedy = "put the end points on the vessel's axis, where it is round; or give your own lines (--centreline, in"
        remedy += " a case ct: centreline) where a path left the vessel, as it does into a chamber that touches it; or"
        remedy += " change surface_spacing_mm, or smoothing_fwhm_mm where the noise is high, in ct: segmentation"
        remedy += " (--settings)"
        raise ComputationError(
            f"the found lumen has no closed surface: {error.what}", error.where, value, remedy
        ) from error


def _lines_of_user(user_lines, ends):
    """[paths.Line] of the user's centreline, {branch: points (n, 3)}. ends: as for segment().

    Raises InputError unless each line ends within FARTHEST_END_MM of an outlet's point, and exactly one at each outlet.
    """
    lines, axes = [], {name: paths.smooth_curve(points, 0.01) for name, points in user_lines.items()}
    names = list(axes)
    for rank, (name, axis) in enumerate(axes.items()):
        miss = [np.linalg.norm(axis.points_mm[-1] - centre) for _, centre in ends[1:]]
        if min(miss) > FARTHEST_END_MM:
            remedy = (
                f"each line from the inlet on to within {FARTHEST_END_MM:g} mm of an outlet's point, in the volume's"
            )
            remedy += f" own coordinates ({volumes.FRAMES_HINT})"
            raise InputError("the centreline ends away from every end point", name, f"{min(miss):.1f} mm", remedy)
        start = axis.points_mm[0]
        away = [np.linalg.norm(axes[other].point(axes[other].nearest(start[None])) - start) for other in names[:rank]]
        lines.append(paths.Line(axis, int(np.argmin(away)) if rank else -1, int(np.argmin(miss)) + 1))
    for number, (end, _) in enumerate(ends[1:], start=1):
        reaching = [name for name, line in zip(names, lines) if line.end == number]
        if len(reaching) != 1:
            value = "none of its lines" if not reaching else " and ".join(reaching)
            remedy = "one line for each outlet's point, or leave the centreline out: it is found in the image"
            raise InputError("the centreline does not have one line to each outlet", end, f"reached by {value}", remedy)
    return lines


def segment(volume, ends, settings, user_lines=None, stented=False):
    """The lumen in an image, as a dict: its implicit field, the lines, tubes and profiles, CT numbers, warnings.

    volume: common.volume.Image. ends: [(name, centre (3,) in mm)], the inlet first, in the image's coordinates.
    settings: the section `segmentation`. user_lines: the user's centreline, {branch: points (n, 3) in mm}, or None.
    stented: whether the vessels hold a stent, as the user says.
    """
    smoothing, scan = settings["smoothing_fwhm_mm"] * SIGMA_PER_FWHM, volume
    if smoothing > 0:
        smooth = gaussian_filter(volume.values.astype(np.float32), smoothing / volume.spacing_mm)
        volume = Image(smooth, volume.origin_mm, volume.spacing_mm)
    lines = _lines_of_user(user_lines, ends) if user_lines else paths.find_branches(volume, ends)
    hu_at, spacing, rays = volume.interpolator(), settings["section_spacing_mm"], settings["rays"]
    blood = _set_main_blood(hu_at, lines[0], spacing, rays)
    tubes = _first_tubes(hu_at, lines, blood, spacing, rays, stented)
    main = blood_level.level_contrast(edges.sample(hu_at, lines[0].axis, spacing, rays), lines[0].blood, blood)
    _check_noise(main, float(np.median(lines[0].blood(main.s_mm))))
    measured = edges.point_spread(main, tubes[0].radii_mm, blood)
    sigma = measured or np.hypot(USUAL_FWHM_MM * SIGMA_PER_FWHM, smoothing)  # a measured sigma includes the smoothing
    if settings["psf_fwhm_mm"] != "auto":
        user_sigma = settings["psf_fwhm_mm"] * SIGMA_PER_FWHM
        sigma = np.sqrt(user_sigma**2 + smoothing**2 + np.mean(volume.spacing_mm**2) / 12)
    blood = _refine_blood(hu_at, lines, tubes, spacing, sigma)
    method = "half_maximum" if settings["method"] == "threshold" else settings["method"]
    result, profiles, replaced = [], [], []
    for rank, line in enumerate(lines):
        parent = result[line.parent] if rank else None
        tube, profile, bad = _measure_tube(hu_at, line, parent, method, blood, sigma, spacing, rays, stented)
        tube.name = "main" if rank == 0 else f"side{rank}"
        result.append(tube)
        profiles.append(profile)
        replaced.append(bad)
    tissue = [edges.tissue_hu(p, t.radii_mm, blood) for p, t in zip(profiles, result)]
    field, level = TubeField(result), None
    if settings["method"] == "threshold":
        level = settings["threshold_hu"]
        levels = None
        if level == "auto":
            level = 0.5 * (blood + float(np.median(tissue[0])))
            levels = [level + 0.5 * (line.blood(tube.s_mm) - blood) for line, tube in zip(lines, result)]
        field = LevelField(result, hu_at, level, blood / (2.5 * sigma), levels)
    bright = [edges.find_calcium_and_stents(profile, blood, stented) for profile in profiles]
    noise = edges.noise_hu(profiles[0].hu, profiles[0], blood)
    found_warnings = warnings.find_warnings(
        lines, result, profiles, bright, ends, (blood, noise), settings, measured is None, stented
    )
    found_warnings += saturation.find_warnings(scan, result)
    if settings["method"] == "psf_edge":
        found_warnings += wall.find_warnings(result[0], profiles[0], bright[0], blood)
    return {
        "field": field,
        "lines": lines,
        "tubes": result,
        "replaced": replaced,
        "profiles": profiles,
        "bright": bright,
        "at": hu_at,
        "ends": ends,
        "blood_hu": blood,
        "noise_hu": noise,
        "tissue_hu": float(np.median(tissue[0])),
        "sigma_mm": float(sigma),
        "level_hu": level,
        "warnings": found_warnings,
    }


def _check_noise(profiles, blood):
    """Raises ComputationError if the contrast of blood and wall is so low that noise hides the edges."""
    noise, contrast = edges.noise_hu(profiles.hu, profiles, blood), blood - edges.HEALTHY_WALL_HU
    if contrast < LEAST_CONTRAST * noise:
        value = (
            f"blood {blood:.0f} HU, a wall about {edges.HEALTHY_WALL_HU:.0f}, noise {noise:.0f}: contrast over noise"
        )
        value += f" {contrast / noise:.1f}, {LEAST_CONTRAST:g} are needed"
        remedy = "a softer kernel, or segmentation: {smoothing_fwhm_mm: 0.7} in the section ct (--settings)"
        raise ComputationError("the contrast is too low against the noise", "CT volume", value, remedy)


def _set_main_blood(hu_at, main, spacing_mm, rays):
    """Sets the blood's trend of the main vessel's Line. Returns its median, which stands for the blood everywhere."""
    profiles = edges.sample(hu_at, main.axis, spacing_mm, rays)
    main.blood = blood_level.first_trend(profiles)
    return float(np.median(main.blood(profiles.s_mm)))


def _first_tubes(hu_at, lines, blood, spacing_mm, rays, stented):
    """[Tube] of all lines, by half maximum. Also centres each Line's axis and sets the trend of its blood."""
    tubes = []
    for line in lines:
        parent = tubes[line.parent] if tubes else None
        if parent is not None:
            start = lines[line.parent].axis.nearest(line.axis.points_mm[:1])
            line.blood = blood_level.Trend(0.0, lines[line.parent].blood(start))
        for turn in range(CENTRING_ROUNDS + 1):
            tube = _measure_tube(hu_at, line, parent, "half_maximum", blood, None, spacing_mm, rays, stented)[0]
            line.blood = blood_level.refined_trend(
                edges.sample(hu_at, line.axis, spacing_mm, FEW_RAYS), tube, line.blood
            )
            if turn < CENTRING_ROUNDS:
                line.axis = _centred_axis(tube, parent)
        tubes.append(tube)
    return tubes


def _refine_blood(hu_at, lines, tubes, spacing_mm, sigma_mm):
    """Sets the blood's trend of each Line anew, with the point spread sigma_mm. Returns the main vessel's median."""
    for line, tube in zip(lines, tubes):
        profiles = edges.sample(hu_at, line.axis, spacing_mm, FEW_RAYS)
        line.blood = blood_level.refined_trend(profiles, tube, line.blood, sigma_mm)
    return float(np.median(lines[0].blood(tubes[0].s_mm)))


def _measure_tube(hu_at, line, parent, method, blood, sigma_mm, spacing_mm, rays, stented=False):
    """(Tube, Profiles, replaced rays (n, m) of bool) of one branch. parent: its parent's Tube or None.

    Within its parent the branch gets the radii of its first section outside. Raises ComputationError if too little of
    the branch is outside the parent.
    """
    profiles = edges.sample(hu_at, line.axis, spacing_mm, rays)
    if line.blood is not None:
        profiles = blood_level.level_contrast(profiles, line.blood, blood)
    radii, bad = edges.find_edges(profiles, method, blood, sigma_mm, stented)
    if parent is not None:
        inside = _count_sections_within_parent(line.axis, profiles.s_mm, parent)
        if len(radii) - inside < FEWEST_OWN_SECTIONS:
            step = profiles.s_mm[1]
            value = (
                f"{step * (len(radii) - inside):.1f} mm of it outside, {step * FEWEST_OWN_SECTIONS:.1f} mm are needed"
            )
            remedy = "move its end point along the branch, away from the parent, or leave the branch out"
            raise ComputationError(
                "a branch hardly leaves its parent", f"outlet {line.end} of those given", value, remedy
            )
        # The radii are found again from the sections outside the parent alone. Otherwise the filter along the axis
        # would mix in sections that show the parent.
        own, own_bad = edges.find_edges(profiles.sections_from(inside), method, blood, sigma_mm, stented)
        radii = np.concatenate([np.repeat(own[:1], inside, axis=0), own])
        bad = np.concatenate([np.ones((inside, rays), bool), own_bad])
    tube = Tube(None if parent is None else parent.name, line.axis, profiles.s_mm, profiles.theta, radii)
    return tube, profiles, bad


def _count_sections_within_parent(axis, s_mm, parent):
    """Number of sections at a branch's start whose rays would run into its parent; all if it does not leave it."""
    points = axis.point(s_mm)
    on_parent = parent.axis.nearest(points)
    away = np.linalg.norm(points - parent.axis.point(on_parent), axis=1)
    # A section is clear of the parent if its whole disc is. The factor stands for a usual branching angle and radius.
    clear = away > 1.35 * parent.radius(on_parent) + 0.3
    return int(np.argmax(clear)) if clear.any() else len(s_mm)


def _centred_axis(tube, parent):
    """The Curve of a Tube's axis after moving it to the centroids of its sections, by at most 0.5 mm, and smoothing.

    parent: the Tube that it leaves, or None. The start is moved onto the parent's axis.
    """
    theta = np.linspace(0, 2 * np.pi, tube.radii_mm.shape[1], endpoint=False)
    third, second = tube.radii_mm**3, tube.radii_mm**2
    u = (third * np.cos(theta)).sum(axis=1) / (1.5 * second.sum(axis=1))
    v = (third * np.sin(theta)).sum(axis=1) / (1.5 * second.sum(axis=1))
    shift = edges.smooth_along(np.stack([u, v], axis=1), tube.s_mm)
    size = np.linalg.norm(shift, axis=1, keepdims=True)
    shift *= np.minimum(1, 0.5 / np.maximum(size, 1e-9))
    if parent is not None:
        inside = _count_sections_within_parent(tube.axis, tube.s_mm, parent)
        shift[:inside] *= np.linspace(0, 1, inside + 1)[:-1, None]
    _, normal, binormal = tube.axis.frame(tube.s_mm)
    points = tube.axis.point(tube.s_mm) + shift[:, :1] * normal + shift[:, 1:] * binormal
    if parent is not None:
        to_parent = parent.axis.point(parent.axis.nearest(points[:1])) - points[:1]
        points[:inside] += np.linspace(1, 0, inside + 1)[:-1, None] * to_parent
    return paths.smooth_curve(points, 0.04)


def _document(segmentation, settings, image_name, centreline_given, volume, stented):
    """The content of segmentation.json (docs/design.md). segmentation: the result of segment()."""
    branches = []
    for line, tube, bad in zip(segmentation["lines"], segmentation["tubes"], segmentation["replaced"]):
        branches.append(
            {
                "name": tube.name,
                "parent": tube.parent,
                "end": segmentation["ends"][line.end][0],
                "length_mm": tube.axis.length_mm,
                "replaced_rays_percent": float(100 * bad.mean()),
                "s_mm": tube.s_mm.round(4).tolist(),
                "points_mm": volume.to_patient(tube.axis.point(tube.s_mm)).round(4).tolist(),
                "equivalent_radius_mm": tube.radius(tube.s_mm).round(5).tolist(),
                "blood_hu": line.blood(tube.s_mm).round(1).tolist(),
            }
        )
    return {
        "schema": SCHEMA,
        "image": image_name,
        "centreline": "given by the user"
        if centreline_given
        else "cheapest paths through the contrast, centred on its sections",
        "method": settings["method"],
        "stented": stented,
        "blood_hu": segmentation["blood_hu"],
        "noise_hu": segmentation["noise_hu"],
        "tissue_hu": segmentation["tissue_hu"],
        "threshold_hu": segmentation["level_hu"],
        "point_spread_fwhm_mm": segmentation["sigma_mm"] / SIGMA_PER_FWHM,
        "settings": settings,
        "ends": [
            {"name": name, "centre_mm": volume.to_patient(centre).tolist()} for name, centre in segmentation["ends"]
        ],
        "branches": branches,
        "warnings": segmentation["warnings"],
    }
