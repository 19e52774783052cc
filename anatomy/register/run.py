"""The command `register`: moves the lumen after the procedure onto the lumen before, and names its ends."""

import copy
import pathlib
import sys

import numpy as np

from common import vtp
from common.documents import config
from common.files import write_json

from . import axes_refinement, placement_checks, search, tree
from .match import match_branches
from .placement import Target


def run(case_file, pre_folder, post_folder, out):
    """Writes lumen.vtp, like.json and registration.json (docs/design.md) into the folder `out`.

    pre_folder, post_folder: folders made by `lumen process` from the case's `lumen` and `post`, each in its own
    coordinates. Raises InputError if no placement fits, or several do.
    """
    out = pathlib.Path(out)
    for name in ("lumen.vtp", "like.json", "registration.json"):
        (out / name).unlink(missing_ok=True)
    settings = config.load_case(case_file).get("registration", {"compare": "flow"})
    landmarks = _landmarks(settings)
    pre, post = tree.read(pre_folder), tree.read(post_folder)
    placement_checks.check_landmarks(case_file, pre, post, landmarks)
    where, target = f"{case_file}: post", Target(pre)
    result = axes_refinement.refine_by_axes(target, post, search.find_placement(pre, post, landmarks), landmarks)
    match = match_branches(target, post, result.placement)
    placement_checks.check_handedness(where, pre, post, target, result, match, landmarks)
    placement_checks.check_direction(where, pre, post, target, result, landmarks)
    placement_checks.check_fit(where, target, post, result, match, landmarks)
    placement_checks.check_place_along(where, target, post, result, match, landmarks)
    if settings["compare"] == "flow":
        placement_checks.check_outlets(where, match, landmarks)
    surface = vtp.read_triangles(pathlib.Path(post_folder) / "lumen.vtp", "run `lumen process` again")
    surface.GetPoints().SetData(_vtk_points(result.placement.apply(vtp.points(surface))))
    vtp.write(out / "lumen.vtp", surface)
    write_json(out / "like.json", like_document(post.summary, result.placement, match))
    for warning in placement_checks.warnings(target, post, result, match, landmarks):
        print(f"warning: {where}: {warning}", file=sys.stderr)
    write_json(
        out / "registration.json", registration_document(target, post, result, match, landmarks, settings["compare"])
    )


def like_document(summary, placement, match):
    """like.json as a dict: the ends of the moved lumen, with the names that the branches had before.

    `lumen process --like` gives the moved lumen the same names by it. summary: anatomy.json of the lumen afterwards.
    """
    ends = copy.deepcopy(summary["ends"])
    for end in ends:
        end["centre_mm"] = placement.apply(np.array([end["centre_mm"]]))[0].tolist()
        end["normal"] = placement.rotation.apply(end["normal"]).tolist()
        end["branch"] = match.names[end["branch"]]
        if end["kind"] == "outlet":
            number = 0 if end["branch"] == "main" else int(end["branch"].removeprefix("side"))
            end["region_id"], end["name"] = 2 + number, f"outlet{1 + number}"
    return {"schema": "vci-anatomy-1", "ends": ends}


def registration_document(target, post, result, match, landmarks, compare):
    """The content of registration.json. compare: `flow` or `areas`, as in the case."""
    placement, residual = result.placement, match.residual_mm
    both, contained = placement_checks.axis_shares(target, post, placement)
    alone = search.spans_a_plane(landmarks[1])
    return {
        "schema": "vci-registration-1",
        "method": "landmarks" if alone else "axes and landmarks" if len(landmarks[0]) else "axes",
        "compare": compare,
        "rotation_deg": float(np.degrees(placement.rotation.magnitude())),
        "rotation": placement.rotation.as_matrix().tolist(),
        "translation_mm": np.asarray(placement.translation).tolist(),
        "residual_mm": {
            "trimmed_rms": match.trimmed_mm,
            "rms": float(np.sqrt(np.mean(residual**2))),
            "largest": float(residual.max()),
        },
        "usual_radius_mm": match.usual_radius_mm,
        "landmarks_off_mm": placement_checks.landmark_distances_mm(placement, landmarks).tolist(),
        "shared": {branch: {"s_start_mm": a, "s_end_mm": b} for branch, (a, b) in match.shared_ranges.items()},
        "share_of_both": both,
        "share_of_the_shorter": contained,
        "branches": match.names,
        "missing": match.missing_branches,
        "new": match.new_branches,
        "next_best": None
        if result.rival is None
        else {"misfit": result.rival_cost, "apart_mm": result.placement.mean_distance_mm(result.rival, post.points)},
        "misfit": result.cost,
        "warnings": placement_checks.warnings(target, post, result, match, landmarks),
        "turn_about_axis_known": bool(axes_refinement.deviates_from_line(target.points) or len(landmarks[0]) > 1),
    }


def _landmarks(settings):
    """(pre (m, 3), post (m, 3)) in mm from the case's section `registration`."""
    pairs = settings.get("landmarks", [])
    return tuple(np.array([pair[key] for pair in pairs], float).reshape(-1, 3) for key in ("pre_mm", "post_mm"))


def _vtk_points(points_mm):
    poly = vtp.surface(points_mm, np.zeros((0, 3), int))
    return poly.GetPoints().GetData()
