"""python3 -m anatomy register: moves the lumen after the procedure onto the lumen before, and names its ends."""

import copy
import pathlib
import sys

import numpy as np

from common import vtp
from common.documents import config
from common.files import write_json

from . import judge, search, settling, tree
from .match import matched
from .placement import Target


def run(case_file, pre_folder, post_folder, out):
    """Writes lumen.vtp, like.json and registration.json (docs/design.md) into the folder `out`.

    pre_folder, post_folder: made by `lumen process` from the case's `lumen` and `post`, each in its own coordinates.
    Raises InputError if no placement fits, or several do.
    """
    out = pathlib.Path(out)
    for name in ("lumen.vtp", "like.json", "registration.json"):
        (out / name).unlink(missing_ok=True)
    wanted = config.load_case(case_file).get("registration", {"compare": "flow"})
    landmarks = _landmarks(wanted)
    pre, post = tree.read(pre_folder), tree.read(post_folder)
    judge.check_landmarks(case_file, pre, post, landmarks)
    where, target = f"{case_file}: post", Target(pre)
    found = settling.settled(target, post, search.best(pre, post, landmarks), landmarks)
    match = matched(target, post, found.placement)
    judge.check_handedness(where, pre, post, target, found, match, landmarks)
    judge.check_direction(where, pre, post, target, found, landmarks)
    judge.check_fit(where, target, post, found, match, landmarks)
    judge.check_place(where, target, post, found, match, landmarks)
    if wanted["compare"] == "flow":
        judge.check_outlets(where, match, landmarks)
    surface = vtp.read_triangles(pathlib.Path(post_folder) / "lumen.vtp", "run `lumen process` again")
    surface.GetPoints().SetData(_points(found.placement.apply(vtp.points(surface))))
    vtp.write(out / "lumen.vtp", surface)
    write_json(out / "like.json", like(post.summary, found.placement, match))
    for said in judge.warnings(target, post, found, match, landmarks):
        print(f"warning: {where}: {said}", file=sys.stderr)
    write_json(out / "registration.json", document(target, post, found, match, landmarks, wanted["compare"]))


def like(summary, placement, match):
    """like.json as a dict, for `lumen process --like`: the ends of the moved lumen, with the branches' names before.

    summary: anatomy.json of the lumen afterwards.
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


def document(target, post, found, match, landmarks, compare):
    """The content of registration.json. compare: `flow` or `areas`, as in the case."""
    placement, residual = found.placement, match.residual_mm
    both, contained = judge.shares(target, post, placement)
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
        "landmarks_off_mm": judge.landmark_misses(placement, landmarks).tolist(),
        "shared": {branch: {"s_start_mm": a, "s_end_mm": b} for branch, (a, b) in match.shared.items()},
        "share_of_both": both,
        "share_of_the_shorter": contained,
        "branches": match.names,
        "missing": match.missing,
        "new": match.new,
        "next_best": None
        if found.rival is None
        else {"misfit": found.rival_cost, "apart_mm": found.placement.apart_mm(found.rival, post.points)},
        "misfit": found.cost,
        "warnings": judge.warnings(target, post, found, match, landmarks),
        "turn_about_axis_known": bool(settling.has_width(target.points) or len(landmarks[0]) > 1),
    }


def _landmarks(wanted):
    """(pre (m, 3), post (m, 3)) in mm from the case's section `registration`."""
    pairs = wanted.get("landmarks", [])
    return tuple(np.array([pair[key] for pair in pairs], float).reshape(-1, 3) for key in ("pre_mm", "post_mm"))


def _points(points_mm):
    poly = vtp.surface(points_mm, np.zeros((0, 3), int))
    return poly.GetPoints().GetData()
