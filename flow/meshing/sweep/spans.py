"""Which stretches of a tree can be swept: those whose cross-sections touch no other branch."""

import numpy as np

from flow.geometry.surface import INLET
from flow.geometry.vectors import dot, length
from flow.meshing.sweep.axis import Axis

CLEARANCE_RADII = 1.15  # least distance of a section from the axis of another branch, in radii of that branch
LEFT_PARENT_RADII = (
    0.8  # a side branch has left its parent when its axis is this many parent radii from the parent's axis
)
CAP_REACH_RADII = 0.8  # a free stretch that ends within this many radii of a cap is prolonged to the cap
TRIM_RADII = 0.25  # gap in radii between the end of a span and the end of the free stretch
SHORTEST_RADII = 2.0  # least length of a span, in radii at the wider of its ends


def branch_axes(surface, tree):
    """{branch name: Axis} of a tree. `cap_ids` of an axis: region ids of the caps at its start and end, or None."""
    caps = surface.cap_circles()
    found = {}
    for branch in tree:
        ids, ends = [None, None], [None, None]
        for cap, (centre, normal, radius) in caps.items():
            end = 0 if cap == INLET else -1
            gap = centre - branch.points[end]
            along = dot(gap, normal)
            radial = length(gap - along * normal)
            if radial < radius and along > -radius and (branch is tree.main or cap != INLET):
                ids[end], ends[end] = cap, (centre, -normal if cap == INLET else normal, radius)
        found[branch.name] = Axis(branch, *ends)
        found[branch.name].cap_ids = tuple(ids)
    return found


def clear_of_others(axis, tree, s_mm):
    """Whether the section at each s_mm (m,) keeps clear of all other branches, (m,) bool.

    Another branch counts as the union of its inscribed spheres. If it is a side branch of this one, it counts only from
    where it has left this one.
    """
    branch = axis.branch
    origins, normals = axis.planes(s_mm)
    own = axis.radius(s_mm)
    result = np.ones(len(s_mm), bool)
    for other in tree:
        if other is branch:
            continue
        keep = np.ones(len(other.points), bool)
        if _starts_on(other, branch):
            keep = other.outside_parent(branch, LEFT_PARENT_RADII)
        for point, radius in zip(other.points[keep], other.radius_mm[keep]):
            gap = point - origins
            along = dot(gap, normals)
            radial = length(gap - along[:, None] * normals)
            result &= np.hypot(along, np.maximum(radial - own, 0.0)) > CLEARANCE_RADII * radius
    return result


def _starts_on(branch, parent):
    """Whether a branch starts near the axis of `parent`."""
    s, distance = parent.project(branch.points[0])
    return distance < 0.5 * parent.radius(s)


def sweepable_stretches(axis, allowed, s_mm):
    """[(start_mm, end_mm, first cap id or None, last cap id or None)] of the stretches that can be swept.

    allowed (m,) bool: whether the section at s_mm (m,) can be swept. Stretches shorter than SHORTEST_RADII are left
    out.
    """
    padded = np.concatenate([[False], allowed, [False]])
    starts = np.flatnonzero(~padded[:-1] & padded[1:])
    ends = np.flatnonzero(padded[:-1] & ~padded[1:]) - 1
    found = []
    for a, b in zip(s_mm[starts], s_mm[ends]):
        radius_a, radius_b = axis.radius(a), axis.radius(b)
        first = axis.cap_ids[0] if a <= CAP_REACH_RADII * radius_a else None
        last = axis.cap_ids[1] if axis.length_mm - b <= CAP_REACH_RADII * radius_b else None
        a = 0.0 if first is not None else a + TRIM_RADII * radius_a
        b = axis.length_mm if last is not None else b - TRIM_RADII * radius_b
        if b - a >= SHORTEST_RADII * max(radius_a, radius_b):
            found.append((float(a), float(b), first, last))
    return found
