"""Straight extensions of the outlets: the cap's rim extruded along the cap's outward normal."""

import numpy as np

from flow.surface import WALL, INLET, Surface


def extend_outlets(surface, diameters):
    """(surface, {region_id: length_mm}) with every outlet longer by `diameters` of its own diameters.

    The cap moves, the wall grows by layers about as long as the rim's edges.
    """
    lengths = {}
    if diameters == 0:
        return surface, lengths
    for cap in surface.caps:
        if cap != INLET:
            surface, lengths[cap] = _extend(surface, cap, diameters)
    return surface, lengths


def _extend(surface, cap, diameters):
    in_cap = surface.region == cap
    vector = surface.area_vectors()[in_cap].sum(axis=0)
    area = np.linalg.norm(vector)
    normal, length = vector / area, diameters * 2.0 * np.sqrt(area / np.pi)
    rim = _rim(surface.triangles[in_cap])
    spacing = np.linalg.norm(surface.points[rim[:, 1]] - surface.points[rim[:, 0]], axis=1).mean()
    layers = max(1, round(length / spacing))
    # the cap's own vertices move to the end; the old rim and the layers between are new copies of it
    loop = np.unique(rim)
    place = np.full(len(surface.points), -1)
    place[loop] = np.arange(len(loop))
    points = surface.points.copy()
    members = np.unique(surface.triangles[in_cap])
    copies = [surface.points[loop] + normal * length * k / layers for k in range(layers)]
    points[members] += normal * length
    count = len(points)
    triangles = surface.triangles.copy()
    outside = ~in_cap & np.isin(triangles, loop).any(axis=1)
    changed = triangles[outside]
    at_rim = place[changed] >= 0
    changed[at_rim] = count + place[changed[at_rim]]
    triangles[outside] = changed
    rings = [count + k * len(loop) + place for k in range(layers)] + [np.arange(len(points))]
    wall = []
    for k in range(layers):
        a, b = rings[k][rim[:, 0]], rings[k][rim[:, 1]]
        c, d = rings[k + 1][rim[:, 0]], rings[k + 1][rim[:, 1]]
        # `rim` runs as in the cap's triangles, so the wall has it the other way round
        wall += [np.stack([b, a, c], axis=1), np.stack([b, c, d], axis=1)]
    wall = np.concatenate(wall)[:, ::-1]
    region = np.concatenate([surface.region, np.full(len(wall), WALL)])
    extended = Surface(np.concatenate([points] + copies), np.concatenate([triangles, wall]), region)
    return extended, float(length)


def _rim(triangles):
    """Directed boundary edges (r, 2) of a patch, in the direction of its triangles."""
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    _, inverse, counts = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    return sides[counts[inverse] == 1]
