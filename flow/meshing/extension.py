"""Straight extensions of inlets or outlets too close to a narrowing: the cap's rim extruded along its normal.

A jet that leaves through an outlet takes its kinetic energy with it, and the pressure that it would have won back
behind the outlet is missing upstream. So an outlet too near behind a narrowing gets a straight tube. It then
lies `outlet_clearance_diameters` of its own diameters behind the end of a strong narrowing, less far behind a milder
one. An inlet nearer than `inlet_clearance_diameters` before the start of a narrowing likewise gets a tube.
`outlet_extension_diameters` lengthens each outlet at least so far. FFR is read in the original anatomy (physics.ffr).
"""

import dataclasses

import numpy as np

from flow.geometry import vectors
from flow.geometry.centreline import Branch, Tree
from flow.geometry.surface import INLET, WALL, Surface, border
from flow.meshing.sweep import spans, stations

SPACING_MM = 0.25  # of the centreline's points in an extension
# Shares of the healthy radius. Narrowings milder than NARROW need no room behind them, STRONG ones the whole clearance,
# others a share. A vessel cut off 2 diameters behind narrowings to .58, .54, .5 and .45 has an FFR .0006, .0015, .0029
# and .0056 off its value with 8 diameters (axisymmetric model, 170 to 190 mL/min). With its share: .0015 at most.
NARROW, STRONG = 0.6, 0.4


@dataclasses.dataclass
class Extension:
    """A straight tube at the cap region_id of a branch's end: length_mm along the unit vector direction (3,).

    distance_mm: from the cap to the narrowing's end (outlet) or start (inlet); None if the settings give the length.
    """

    region_id: int
    branch: str
    length_mm: float
    direction: list
    distance_mm: float


def needed(surface, tree, settings):
    """[Extension] for the caps that lie too close to a narrowing, or for which the settings give a length."""
    found = []
    for axis in spans.axes(surface, tree).values():
        for cap, at_end in zip(axis.cap_ids, (False, True)):
            if cap is None:
                continue
            normal, diameter = _cap(surface, cap)
            clearance = settings.outlet_clearance_diameters if at_end else settings.inlet_clearance_diameters
            missing, distance = _missing(axis.branch, at_end, clearance * diameter)
            asked = settings.outlet_extension_diameters * diameter if at_end else 0.0
            length = max(asked, missing)
            if length > 0:
                reason = float(distance) if length > asked else None
                found.append(Extension(cap, axis.branch.name, float(length), normal.tolist(), reason))
    return found


def _missing(branch, from_end, clearance_mm):
    """(missing length, distance) in mm between a branch's end, or start, and a narrowing.

    They are for the narrowing that misses most; the length is not positive if none is missing. A narrowing is below
    NARROW of the healthy radius (meshing.sweep.stations) somewhere and reaches to 0.95 of it. Behind it a share of
    clearance_mm is wanted, the larger the stronger the narrowing; before it all of clearance_mm.
    """
    s, share = branch.s_mm, stations.healthy_share(branch)
    if from_end:
        s, share = branch.length_mm - s[::-1], share[::-1]
        wanted = clearance_mm * np.clip((NARROW - share) / (NARROW - STRONG), 0, 1)
    else:
        wanted = np.where(share <= NARROW, clearance_mm, 0.0)
    distance = np.maximum.accumulate(np.where(share >= stations.HEALTHY, s, 0.0))
    k = int(np.argmax(wanted - distance))
    return float(wanted[k] - distance[k]), float(distance[k])


def extend(surface, extensions):
    """The surface with its caps moved out: the wall grows by layers about as long as the rim's edges."""
    for one in extensions:
        surface = _extend(surface, one.region_id, one.length_mm)
    return surface


def prolonged(tree, extensions):
    """The tree, its centrelines continued straight through the extensions; s = 0 moves to a longer inlet's start."""
    branches = {branch.name: branch for branch in tree}
    for one in extensions:
        branch = branches[one.branch]
        steps = max(2, int(np.ceil(one.length_mm / SPACING_MM)))
        along = np.linspace(0.0, one.length_mm, steps + 1)
        at_start = one.region_id == INLET
        k = 0 if at_start else -1
        more = branch.points[k] + along[1:, None] * np.asarray(one.direction)
        radius = np.full(steps, branch.radius_mm[k])
        if at_start:
            points, radius = np.concatenate([more[::-1], branch.points]), np.append(radius, branch.radius_mm)
            s = np.concatenate([branch.s_mm[0] + along[:-1], branch.s_mm + one.length_mm])
        else:
            points, radius = np.concatenate([branch.points, more]), np.append(branch.radius_mm, radius)
            s = np.concatenate([branch.s_mm, branch.s_mm[-1] + along[1:]])
        branches[one.branch] = Branch(branch.name, branch.branch_id, points, s, radius)
    return Tree(list(branches.values()))


def _cap(surface, cap):
    """(unit normal outwards (3,), diameter in mm of the circle of its area) of a cap."""
    vector = surface.area_vectors()[surface.region == cap].sum(axis=0)
    area = float(vectors.length(vector))
    return vector / area, 2.0 * np.sqrt(area / np.pi)


def _extend(surface, cap, length):
    in_cap = surface.region == cap
    normal, _ = _cap(surface, cap)
    rim = border(surface.triangles[in_cap])
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
    return Surface(np.concatenate([points] + copies), np.concatenate([triangles, wall]), region)
