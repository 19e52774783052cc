"""Whether end points lie in a volume and in its contrast, before any work; errors are in the user's coordinates."""

import numpy as np

from common.errors import InputError

from . import paths, volumes

LEAST_BLOOD_HU = 100.0  # blood without contrast has 30 to 60 HU; coronary angiograms have 200 and more
REVERSED = np.array([-1.0, -1.0, 1.0])  # between right-anterior-superior and left-posterior-superior


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
            remedy = f"{paths.OUTSIDE} ({volumes.FRAMES}){_reversed(volume, centre)}"
            raise InputError("the end point lies outside the image", name, value, remedy)
    name, inlet = ends[0]
    hu = _hu(volume, inlet)
    if hu < LEAST_BLOOD_HU:
        value = f"{hu:.0f} HU at {np.round(inlet, 2).tolist()} mm, contrast-filled blood has {LEAST_BLOOD_HU:g} or more"
        remedy = f"{paths.OUTSIDE}, on the vessel's axis; mm, not voxel numbers ({volumes.FRAMES})"
        remedy += _reversed(volume, inlet)
        raise InputError("the end point is not in a contrast-filled vessel", name, value, remedy)


def _hu(volume, point):
    """Mean CT number about a point (3,) mm of the volume's coordinates; None outside."""
    inside = volume.to_image(np.asarray(point, float))
    return paths.blood_hu(volume.image, inside) if volume.image.index(inside)[1] else None


def _reversed(volume, point):
    """What to add to a remedy if the point is in contrast once x and y change sign; empty otherwise."""
    other = REVERSED * point
    hu = _hu(volume, other)
    if hu is None or hu < LEAST_BLOOD_HU:
        return ""
    return (
        f"; {np.round(other, 2).tolist()}, with x and y reversed, has {hu:.0f} HU: the point is of the other convention"
    )
