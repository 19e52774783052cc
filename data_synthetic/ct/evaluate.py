"""Compares a lumen with the true one: cross-sectional area and resistance in the same sections."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

END_CLEARANCE_RADII = 1.5


def section_area(points, triangles, centre, normal):
    """Area (mm2) within the outline of a closed surface that goes round `centre`, in the plane across `normal`.

    points (n, 3) mm, triangles (m, 3). NaN if no outline goes round the centre.
    """
    height = (points - centre) @ normal
    above = height > 0
    cut = triangles[above[triangles].any(axis=1) & ~above[triangles].all(axis=1)]
    near = np.linalg.norm(points[cut[:, 0]] - centre, axis=1) < 8
    cut = cut[near]
    if len(cut) < 3:
        return np.nan
    # Each cut triangle gives one segment of an outline. It begins (`a`) on the edge that rises through the plane, and
    # ends (`b`) on the edge that falls.
    starts, stops = [], []
    for k in range(3):
        i, j = cut[:, k], cut[:, (k + 1) % 3]
        starts.append(np.where(~above[i] & above[j], 1, 0))
        stops.append(np.where(above[i] & ~above[j], 1, 0))
    rise, fall = np.argmax(starts, axis=0), np.argmax(stops, axis=0)
    rows = np.arange(len(cut))
    ends = []
    for edge in (rise, fall):
        i, j = cut[rows, edge], cut[rows, (edge + 1) % 3]
        share = height[i] / (height[i] - height[j])
        place = points[i] + share[:, None] * (points[j] - points[i])
        low, high = np.minimum(i, j), np.maximum(i, j)
        ends.append((place, low * len(points) + high))
    keys, number = np.unique(np.concatenate([ends[0][1], ends[1][1]]), return_inverse=True)
    first, second = number[: len(cut)], number[len(cut) :]
    _, label = connected_components(coo_matrix((np.ones(len(cut)), (first, second)), shape=(len(keys),) * 2), False)
    label = label[first]
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    a, b = (np.stack([(p - centre) @ u, (p - centre) @ v], axis=1) for p, _ in ends)
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    angle = np.arctan2(cross, np.sum(a * b, axis=1))
    turns = np.bincount(label, angle) / (2 * np.pi)
    area = 0.5 * np.bincount(label, cross)
    round_centre = np.abs(turns) > 0.5
    return float(np.abs(area[round_centre]).min()) if round_centre.any() else np.nan


def comparison_sections(branches, spacing_mm=0.5):
    """[(branch name, s_mm, centre (3,), tangent (3,))] of sections of all branches.

    Sections near ends and ostia are left out, since they would cut a cap or another branch.
    """
    found = []
    for branch in branches:
        radius = branch.radius_mm
        start = 0.0 if not branch.parent else None
        children = [b for b in branches if b.parent == branch.name]
        s = np.arange(0.0, branch.axis.length_mm, spacing_mm)
        keep = s < branch.axis.length_mm - END_CLEARANCE_RADII * radius[-1]
        if start is not None:
            keep &= s > END_CLEARANCE_RADII * radius[0]
        else:
            parent = next(b for b in branches if b.name == branch.parent)
            points = branch.axis.point(s)
            on_parent = parent.axis.nearest(points)
            away = np.linalg.norm(points - parent.axis.point(on_parent), axis=1)
            keep &= away > parent.radius(on_parent) + 2.0 * branch.radius(s)
        for child in children:
            # Sections at the child's ostium are left out, with room for its rounded edge and an oblique exit.
            keep &= np.abs(s - child.s_on_parent_mm - 1.0) > 2.5 * child.radius_mm[0] + 1.0
        s = s[keep]
        tangent = branch.axis.frame(s)[0]
        found += [(branch.name, *row) for row in zip(s, branch.axis.point(s), tangent)]
    return found


def compare_areas(true, found, sections, compared_spans=None):
    """Compares the section areas of two surfaces, each (points, triangles), at `sections`.

    sections: result of `comparison_sections`. compared_spans: {branch: (start, end)} in mm, to compare only this part
    of a branch.

    Returns a dictionary. Differences are found minus true, over the sections with an outline in both surfaces.

    - `sections` is the number of sections compared; `lost_sections` is the number of the others.
    - mean_difference_mm2 and sd_mm2 are of the areas; lower_limit_mm2 and upper_limit_mm2 are their limits at +-1.96
    sd.
    - mean_radius_difference_mm and sd_radius_mm are of the radii of circles of equal area.
    - resistance_ratio is the sum of A^-2 in `found` over the sum in `true`, where A is a section's area.
    - true_minimal_area_mm2 and found_minimal_area_mm2 are the smallest areas.
    """
    if compared_spans:
        sections = [
            p for p in sections if p[0] in compared_spans and compared_spans[p[0]][0] <= p[1] <= compared_spans[p[0]][1]
        ]
    area = np.array([[section_area(*s, centre, normal) for s in (true, found)] for _, _, centre, normal in sections])
    known = np.isfinite(area).all(axis=1)
    a, b = area[known].T
    difference = b - a
    mean, sd = float(difference.mean()), float(difference.std(ddof=1))
    radius = np.sqrt(b / np.pi) - np.sqrt(a / np.pi)
    return {
        "sections": int(known.sum()),
        "lost_sections": int((~known).sum()),
        "mean_difference_mm2": mean,
        "sd_mm2": sd,
        "lower_limit_mm2": mean - 1.96 * sd,
        "upper_limit_mm2": mean + 1.96 * sd,
        "mean_radius_difference_mm": float(radius.mean()),
        "sd_radius_mm": float(radius.std(ddof=1)),
        "resistance_ratio": float(np.sum(b**-2.0) / np.sum(a**-2.0)),
        "true_minimal_area_mm2": float(a.min()),
        "found_minimal_area_mm2": float(b.min()),
    }
