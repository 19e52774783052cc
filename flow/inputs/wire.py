"""The place of the pressure wire's sensor in a patient, as one more probe of FFR."""

import numpy as np

from common.errors import InputError

PROBE_NAME = "measured"
SENSOR_DISTANCE_RADII = 2.0  # a point further than this many local radii from the axis is taken as outside the vessel


def sensor_probe(given, tree, where="measured.probe"):
    """The probe `measured`: {name, branch, s_mm, point_mm} on the centreline before the procedure.

    given: {branch, s_mm} or {point_mm: [x, y, z]} in mm; tree: geometry.centreline.Tree. A place up to a radius beyond
    a branch's end is moved to the end. Raises InputError for a place that is not in the vessel.
    """
    if "branch" in given:
        names = [branch.name for branch in tree]
        if given["branch"] not in names:
            known = f"branches of this lumen: {', '.join(names)}"
            raise InputError("no such branch", f"{where}.branch", given["branch"], known)
        branch, s_mm = tree[given["branch"]], float(given["s_mm"])
        _check_within_end(branch, s_mm - branch.length_mm, f"{where}.s_mm")
        s_mm = min(s_mm, branch.length_mm)
    else:
        branch, s_mm = _nearest_place(np.array(given["point_mm"], float), tree, where)
    return {"name": PROBE_NAME, "branch": branch.name, "s_mm": s_mm, "point_mm": branch.point(s_mm).tolist()}


def ffr_warnings(measured):
    """[warning] if FFR after the procedure is below FFR before. measured: section `measured` of a case file."""
    before, after = measured.get("ffr_pre"), measured.get("ffr_post")
    if before is None or after is None or after >= before:
        return []
    return [f"measured.ffr_post, {after:g}, is below measured.ffr_pre, {before:g}: are they swapped?"]


def upstream_warnings(place, anatomy):
    """[warning] if no lesion starts between the inlet and the sensor: its reading then says nothing of the lesions.

    place: result of `sensor_probe`; anatomy: document of anatomy.json.
    """
    lesions, branches = anatomy.get("lesions", []), {b["name"]: b for b in anatomy.get("branches", [])}
    name, s_mm = place["branch"], place["s_mm"]
    while name is not None:
        if any(lesion["branch"] == name and lesion.get("s_start_mm", lesion["s_end_mm"]) < s_mm for lesion in lesions):
            return []
        here = branches.get(name, {})
        name, s_mm = here.get("parent"), here.get("s_on_parent_mm")
    if not lesions:
        return []
    first = min(lesions, key=lambda lesion: lesion["s_end_mm"])
    return [
        f"measured.probe, {place['branch']} at {place['s_mm']:.1f} mm, lies upstream of every lesion (the first ends at"
        f" {first['s_end_mm']:.1f} mm of {first['branch']}): a wire reads a lesion's FFR beyond it; give the sensor's"
        " place, in mm from the branch's start"
    ]


def _check_within_end(branch, beyond_mm, where):
    """Raises InputError for a place that lies `beyond_mm` beyond a branch's end, if this is more than the radius there.

    branch: geometry.centreline.Branch.
    """
    if beyond_mm > branch.radius_mm[-1]:
        value = f"{beyond_mm:.1f} mm beyond the end of {branch.name}, which is {branch.length_mm:.1f} mm long"
        remedy = f"a place in the vessel, or at most its radius ({branch.radius_mm[-1]:.1f} mm) beyond the end"
        raise InputError("the wire's sensor lies beyond its branch", where, value, remedy)


def _nearest_place(point, tree, where):
    """(Branch, s_mm) of the place on the tree's axes that is nearest to point (3,) in mm. Raises InputError.

    The nearest place is the one at the least distance in local radii.
    """
    s_mm, distance, branch = min(
        ((*branch.project(point), branch) for branch in tree), key=lambda found: found[1] / found[2].radius(found[0])
    )
    if distance > SENSOR_DISTANCE_RADII * branch.radius(s_mm):
        value = f"{distance:.1f} mm from the nearest axis ({branch.name} at {s_mm:.1f} mm)"
        remedy = "a point in the vessel, x, y, z in mm in the frame of the case's lumen"
        raise InputError("the wire's sensor lies outside the vessel", f"{where}.point_mm", value, remedy)
    along = branch.points[-1] - branch.point(branch.length_mm - branch.radius_mm[-1])
    beyond = float((point - branch.points[-1]) @ along / np.linalg.norm(along))
    _check_within_end(branch, beyond if s_mm == branch.length_mm else 0.0, f"{where}.point_mm")
    return branch, float(s_mm)
