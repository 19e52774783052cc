"""Places and types of the tissues round the lumen of the diseased branch, for the solid models."""

import numpy as np

from . import materials

WALL_TRANSITION_MM = 0.04  # width of the transition from plaque to wall
CALCIUM_TRANSITION_MM = 0.06  # width of the transition at the inner face of a calcified sheet


def inner_outer_radii(branch, wall_mm, s_mm, theta_rad):
    """(inner, outer) radii in mm, each of the common shape of s_mm and theta_rad, about the lumen's axis."""
    s_mm, theta_rad = np.broadcast_arrays(np.asarray(s_mm, float), theta_rad)
    inner = branch.radius(s_mm)
    return inner, inner + branch.plaque_thickness(s_mm, theta_rad) + wall_mm


def material_constants(branch, s_mm, theta_rad, radius_mm):
    """(share of plaque, shear MPa, yield MPa, hardening MPa), each (n,), at points (n,) about the lumen's axis."""
    thickness = branch.plaque_thickness(s_mm, theta_rad)
    depth = radius_mm - branch.radius(s_mm)
    share = (
        0.5 * (1 - np.tanh((depth - thickness) / WALL_TRANSITION_MM)) * np.clip(thickness / WALL_TRANSITION_MM, 0, 1)
    )
    # Calcium is a sheet in the outer half of the plaque: with an arc of calcium at the lumen the slice does not
    # converge.
    in_outer_half = 0.5 * (1 + np.tanh((depth - 0.5 * thickness) / CALCIUM_TRANSITION_MM))
    calcium = branch.calcium_share(s_mm, theta_rad) * in_outer_half
    types = branch.uncalcified_type(s_mm)
    values = np.empty((3, len(share)))
    for kind in np.unique(types):
        at = types == kind
        values[:, at] = materials.blend_with_calcium(materials.BY_PLAQUE_TYPE[int(kind)], calcium[at])
    return share, *values
