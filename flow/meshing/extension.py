"""Straight extensions of inlets or outlets too close to a narrowing: the cap's rim extruded along its normal.

Behind a narrowing the pressure first rises, as the jet's kinetic energy turns back into pressure. A resistance attached
where the pressure still rises changes the flow and FFR (mesh.md). So an outlet too close behind a narrowing gets a
straight tube. It then lies `outlet_clearance_diameters` of its own diameters behind the end of a strong narrowing, and
less far behind a milder one. An inlet closer than `inlet_clearance_diameters` before a narrowing also gets a tube.
Setting `outlet_extension_diameters` lengthens every outlet by at least this many of its diameters. FFR is read in the
original anatomy (physics.ffr).
"""

import dataclasses

import numpy as np

from flow.geometry.centreline import Branch, Tree
from flow.geometry.surface import INLET, WALL, Surface, border_edges
from flow.meshing.sweep import spans, stations

POINT_SPACING_MM = 0.25  # distance of the centreline's points in an extension
# Shares of the healthy radius. Behind a narrowing to at least MILD_NARROWING an outlet needs no clearance, behind one
# to at most STRONG_NARROWING all of it. Between the two it needs a share of the clearance. The reason: vessels with
# narrowings to .58, .54, .5 and .45 were cut off 2 and 8 diameters behind them. Their FFRs differ by .0006, .0015,
# .0029 and .0056 (axisymmetric model, 170 to 190 mL/min). With the share of the clearance, they differ by .0015 at
# most.
MILD_NARROWING, STRONG_NARROWING = 0.6, 0.4


@dataclasses.dataclass
class Extension:
    """A straight tube at the cap `region_id` of the branch named `branch`, length_mm long.

    direction: unit vector (3,) out of the lumen; distance_mm: distance from the cap to the end of the narrowing
    (outlet) or its start (inlet), or None if setting outlet_extension_diameters gives the length.
    """

    region_id: int
    branch: str
    length_mm: float
    direction: list
    distance_mm: float


def find_extensions(surface, tree, settings):
    """[Extension] for the caps that lie too close to a narrowing, or for which the settings give a length."""
    found, circles = [], surface.cap_circles()
    for axis in spans.branch_axes(surface, tree).values():
        for cap, at_end in zip(axis.cap_ids, (False, True)):
            if cap is None:
                continue
            _, normal, radius = circles[cap]
            diameter = 2.0 * radius
            clearance = settings.outlet_clearance_diameters if at_end else settings.inlet_clearance_diameters
            missing, distance = _missing_clearance(axis.branch, at_end, clearance * diameter)
            asked = settings.outlet_extension_diameters * diameter if at_end else 0.0
            length = max(asked, missing)
            if length > 0:
                reason = float(distance) if length > asked else None
                found.append(Extension(cap, axis.branch.name, float(length), normal.tolist(), reason))
    return found


def _missing_clearance(branch, from_end, clearance_mm):
    """(missing clearance, distance) in mm from a branch's end (from_end), or its start, to a narrowing.

    The missing clearance is the wanted distance minus the actual one; it is not positive if none is missing. Of several
    narrowings the one with the largest counts. A narrowing is below MILD_NARROWING of the healthy radius somewhere, and
    ends where it reaches 0.95 of it (meshing.sweep.stations). Before a narrowing the wanted distance is clearance_mm.
    Behind one it is a share of clearance_mm, the larger the stronger the narrowing.
    """
    s, share = branch.s_mm, stations.healthy_share(branch)
    if from_end:
        s, share = branch.length_mm - s[::-1], share[::-1]
        wanted = clearance_mm * np.clip((MILD_NARROWING - share) / (MILD_NARROWING - STRONG_NARROWING), 0, 1)
    else:
        wanted = np.where(share <= MILD_NARROWING, clearance_mm, 0.0)
    distance = np.maximum.accumulate(np.where(share >= stations.HEALTHY_SHARE, s, 0.0))
    k = int(np.argmax(wanted - distance))
    return float(wanted[k] - distance[k]), float(distance[k])


def extend_surface(surface, extensions):
    """The Surface with the caps of [Extension] moved out. The new wall has layers about as long as rim edges."""
    for one in extensions:
        surface = _extend_cap(surface, one.region_id, one.length_mm)
    return surface


def extend_tree(tree, extensions):
    """The Tree with its centrelines continued straight through [Extension].

    With an extended inlet s = 0 is at the start of the extension.
    """
    branches = {branch.name: branch for branch in tree}
    for one in extensions:
        branch = branches[one.branch]
        steps = max(2, int(np.ceil(one.length_mm / POINT_SPACING_MM)))
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


def _extend_cap(surface, cap, length):
    """The Surface with the cap of region id `cap` moved out by `length` mm, and new wall between."""
    in_cap = surface.region == cap
    _, normal, _ = surface.cap_circles()[cap]
    rim = border_edges(surface.triangles[in_cap])
    spacing = np.linalg.norm(surface.points[rim[:, 1]] - surface.points[rim[:, 0]], axis=1).mean()
    layers = max(1, round(length / spacing))
    # the cap's vertices, rim included, move to the end of the tube; the old rim and the layers get new vertices
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
        # the edges of `rim` run as in the cap's triangles; in the wall's triangles they run in the other direction
        wall += [np.stack([b, a, c], axis=1), np.stack([b, c, d], axis=1)]
    wall = np.concatenate(wall)[:, ::-1]
    region = np.concatenate([surface.region, np.full(len(wall), WALL)])
    return Surface(np.concatenate([points] + copies), np.concatenate([triangles, wall]), region)
