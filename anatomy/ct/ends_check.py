"""Reads the end points of the vessels. Checks that they lie in the volume, and that the inlet lies in contrast.

Messages state places in the user's coordinates.
"""

import numpy as np

from common.documents import json_reader, schema
from common.errors import InputError

from . import paths, volumes

ENDS_FILE_REMEDY = "give the vessels' end points as JSON (--ends): ends [{name, centre_mm}], the inlet first"
END_POINTS_REMEDY = "give the end points in mm, in the volume's own coordinates"
CLOSEST_MM = 1.0  # end points nearer to each other are one end given twice, since no vessel is shorter
LEAST_BLOOD_HU = 100.0  # blood without contrast has 30 to 60 HU; coronary angiograms have 200 and more
RAS_TO_LPS = np.array([-1.0, -1.0, 1.0])  # factors from right-anterior-superior to left-posterior-superior coordinates


def load_ends(path):
    """[(name, centre (3,))] from a JSON file with `ends: [{name, centre_mm}]`, the inlet first. Raises InputError."""
    document = json_reader.read(path, "ends", ENDS_FILE_REMEDY)
    schema.validate(document, schema.read("ends"), "end points of vessels", ENDS_FILE_REMEDY)
    entries = enumerate(document.data["ends"], start=1)
    return checked_ends([(entry.get("name", f"end{k}"), entry["centre_mm"]) for k, entry in entries], path)


def checked_ends(points, where):
    """Checked end points [(name, centre (3,))] from `points`, a list of (name, [x, y, z]) as the user gave them.

    where: the file or options that hold them, for messages. Raises InputError for fewer than two end points, a
    coordinate that is not finite, a name given twice, or two points nearer than CLOSEST_MM.
    """
    found = []
    if len(points) < 2:
        remedy = "at least two: the inlet first, then an outlet for each branch"
        raise InputError("too few end points", f"{where}: ends", len(points), remedy)
    for number, (name, centre) in enumerate(points, start=1):
        key = f"{where}: ends[{number}]"
        if not np.all(np.isfinite(centre)):
            raise InputError("not a point", f"{key}.centre_mm", centre, "three numbers, mm")
        name, centre = str(name), np.array(centre, float)
        if name in [other for other, _ in found]:
            raise InputError("two end points of one name", f"{key}.name", name, "a name for each")
        too_near = [other for other, place in found if np.linalg.norm(place - centre) < CLOSEST_MM]
        if too_near:
            remedy = f"at least {CLOSEST_MM} mm from {too_near[0]}: one point for each end of a vessel"
            raise InputError("two end points at one place", f"{key}.centre_mm", centre.tolist(), remedy)
        found.append((name, centre))
    return found


def check(volume, ends):
    """Raises InputError for an end point outside the Volume, or for an inlet that is not in contrast-filled blood.

    ends: [(name, centre (3,) mm)], the inlet first, in the volume's coordinates.
    """
    size = np.array(volume.image.values.shape) - 1
    corners = [volume.image.origin_mm + volume.image.spacing_mm * np.array(k) * size for k in np.ndindex(2, 2, 2)]
    corners = volume.to_patient(corners)
    low, high = (np.round(bound(corners, axis=0), 1).tolist() for bound in (np.min, np.max))
    for name, centre in ends:
        if _hu(volume, centre) is None:
            value = f"{np.round(centre, 2).tolist()} mm, the volume reaches from {low} to {high}"
            remedy = f"{END_POINTS_REMEDY} ({volumes.FRAMES_HINT}){_ras_lps_hint(volume, centre)}"
            raise InputError("the end point lies outside the image", name, value, remedy)
    name, inlet = ends[0]
    hu = _hu(volume, inlet)
    if hu < LEAST_BLOOD_HU:
        value = f"{hu:.0f} HU at {np.round(inlet, 2).tolist()} mm, contrast-filled blood has {LEAST_BLOOD_HU:g} or more"
        remedy = f"{END_POINTS_REMEDY}, on the vessel's axis; mm, not voxel numbers ({volumes.FRAMES_HINT})"
        remedy += _ras_lps_hint(volume, inlet)
        raise InputError("the end point is not in a contrast-filled vessel", name, value, remedy)


def _hu(volume, point):
    """Mean CT number round a point (3,) in mm, in the volume's coordinates; None if it lies outside the image."""
    inside = volume.to_image(np.asarray(point, float))
    return paths.blood_hu(volume.image, inside) if volume.image.index(inside)[1] else None


def _ras_lps_hint(volume, point):
    """Text to add to a remedy if the point, with x and y negated, lies in contrast; otherwise empty.

    Such a point is probably given in the convention of NIfTI for a DICOM volume, or the other way round.
    """
    other = RAS_TO_LPS * point
    hu = _hu(volume, other)
    if hu is None or hu < LEAST_BLOOD_HU:
        return ""
    return (
        f"; {np.round(other, 2).tolist()}, with x and y reversed, has {hu:.0f} HU: the point is of the other convention"
    )
