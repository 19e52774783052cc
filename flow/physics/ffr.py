"""FFR of a solved flow: at the probes, along every branch, at the outlets.

FFR = p / MAP. A sampler is a geometry.locate.FieldSampler, or a reduced.answer.Sampler for a reduced model.
"""

import numpy as np
import pandas as pd

from common.errors import InputError
from flow.physics.units import M_PER_MM

PULLBACK_SPACING_MM = 0.5  # distance of the points of the pull-back along a branch
SLOPE_WINDOW_MM = 1.0  # the slope of FFR at a probe is fitted within this distance along the branch
LARGEST_SLOPE_PER_MM = (
    5e-4  # rise of FFR per mm: with a steeper slope the third decimal depends on the probe's exact place
)
# Further than this from the centreline, in local radii, a probe belongs to another vessel (in the study at most .25).
PROBE_DISTANCE_RADII = 2.0
# Further than both along the vessel from its `s_mm`, a probe is misplaced, or in another unit. A stent that straightens
# a bent vessel moves a probe behind it by up to 7 % of its arc length.
PROBE_SHIFT_RADII = 4.0  # local radii
PROBE_SHIFT_SHARE = 0.2  # of `s_mm`
WARNED_DISTANCE_RADII = (
    0.5  # local radii: a probe moved further gets a warning; a stent's deployment moves the axis by up to .15
)


def pullback_places(branch):
    """Arc lengths s_mm (n,) of the points of the pull-back along a branch."""
    return np.linspace(0, branch.length_mm, max(2, int(round(branch.length_mm / PULLBACK_SPACING_MM)) + 1))


def pressure_along(branch, sampler):
    """(s_mm (n,), points_mm (n, 3), pressure (n,) in Pa) of the pull-back's points that lie inside the mesh."""
    s = pullback_places(branch)
    points = branch.point(s)
    _, pressure, inside = sampler(points * M_PER_MM)
    return s[inside], points[inside], pressure[inside]


def pullback(tree, sampler, map_pa, flow_at):
    """Table of pullback.csv for a flow, given by its sampler. flow_at(branch name, s_mm) -> flow in m3/s."""
    tables = []
    for branch in tree:
        s, points, pressure = pressure_along(branch, sampler)
        tables.append(
            pd.DataFrame(
                {
                    "branch": branch.name,
                    "branch_id": branch.branch_id,
                    "s_mm": s,
                    "x_mm": points[:, 0],
                    "y_mm": points[:, 1],
                    "z_mm": points[:, 2],
                    "pressure_pa": pressure,
                    "ffr": pressure / map_pa,
                    "flow_m3_per_s": [flow_at(branch.name, x) for x in s],
                }
            )
        )
    return pd.concat(tables, ignore_index=True)


def _project_probe(probe, tree):
    """(branch, s_mm, shift_mm): the point of this state's centreline that is nearest to a probe of boundary.json.

    shift_mm is its distance from the probe. Raises InputError where this is above PROBE_DISTANCE_RADII, or where s_mm
    differs from the probe's s_mm by more than both PROBE_SHIFT_RADII and PROBE_SHIFT_SHARE.
    """
    branch, s_mm, shift = tree.project_probe(probe)
    if shift > PROBE_DISTANCE_RADII * branch.radius(s_mm):
        remedy = "boundary.json and centreline of one patient, both in mm"
        raise InputError(
            "probe is far from this state's vessel", f"probe {probe['name']}", f"{shift:.2f} mm", f"give {remedy}"
        )
    planned = probe.get("s_mm", s_mm)
    if abs(s_mm - planned) > max(PROBE_SHIFT_RADII * branch.radius(s_mm), PROBE_SHIFT_SHARE * planned):
        value, remedy = f"{s_mm:.4g} mm, its s_mm says {planned:.4g}", "give point_mm and s_mm of one place, both in mm"
        raise InputError("probe lies at another place along the vessel", f"probe {probe['name']}", value, remedy)
    return branch, s_mm, shift


def check_probes(probes, tree):
    """Raises InputError for a probe of boundary.json that does not belong to the tree (`_project_probe`)."""
    for probe in probes:
        _project_probe(probe, tree)


def check_inside(probes, tree, space):
    """Raises InputError for a probe whose place on the centreline lies outside the mesh.

    space: discretisation.spaces.LumenSpace on that mesh.
    """
    projected = [_project_probe(probe, tree) for probe in probes]
    places = np.array([branch.point(s_mm) for branch, s_mm, _ in projected])
    _, _, inside = space.locator.find(places * M_PER_MM)
    for probe, place, found in zip(probes, places, inside):
        if not found:
            value, remedy = f"{place.round(3).tolist()} mm", "give the centreline of the mesh's lumen"
            raise InputError("probe lies outside the mesh", f"probe {probe['name']}", value, remedy)


def at_probes(document, tree, sampler):
    """[{name, branch, s_mm, point_mm, shift_mm, ffr}] of the probes, moved to this state's centreline.

    document: content of boundary.json, whose first probe is `distal`.
    """
    found = []
    for probe in document["probes"]:
        branch, s_mm, shift = _project_probe(probe, tree)
        point = branch.point(s_mm)
        _, pressure, _ = sampler(point[None] * M_PER_MM)
        found.append(
            {
                "name": probe["name"],
                "branch": branch.name,
                "s_mm": s_mm,
                "point_mm": point.tolist(),
                "shift_mm": shift,
                "ffr": float(pressure[0] / document["map_pa"]),
            }
        )
    return found


def at_outlets(names, pressures, case, sampler):
    """[FFR] at the outlets `names`. pressures (o,) in Pa at the mesh's outlets; case: reduced.extended.ExtendedLumen.

    At an outlet with an extension, FFR is read where the vessel ends without it.
    """
    extended = {one.region_id for one in case.extensions}
    ends = {outlet["name"]: outlet["branch"] for outlet in case.document["outlets"] if outlet["region_id"] in extended}
    found = []
    for name, pressure in zip(names, pressures):
        if name in ends:
            branch = case.original_tree[ends[name]]
            pressure = sampler(branch.point(branch.length_mm)[None] * M_PER_MM)[1][0]
        found.append(float(pressure / case.document["map_pa"]))
    return found


def displacement_warnings(probes, tree, table):
    """Warnings that the centreline may be another lumen's.

    They name probes (entries of `at_probes`) that were moved by more than WARNED_DISTANCE_RADII, and branches that
    leave the mesh. table: result of `pullback`.
    """
    found = []
    for probe in probes:
        radius = tree[probe["branch"]].radius(probe["s_mm"])
        if probe["shift_mm"] > WARNED_DISTANCE_RADII * radius:
            found.append(
                f"the probe {probe['name']} lies {probe['shift_mm']:.2f} mm, {probe['shift_mm'] / radius:.2f} radii,"
                " beside this state's centreline and was moved there; is it of this patient?"
            )
    for branch in tree:
        wanted, inside = len(pullback_places(branch)), int((table["branch"] == branch.name).sum())
        if inside < wanted:
            found.append(
                f"{wanted - inside} of {wanted} points of the centreline of {branch.name} lie outside the mesh and are"
                " left out of pullback.csv; is it the centreline of this lumen?"
            )
    return found


def slope_warnings(probes, table):
    """Warnings, one for each probe at which FFR rises by more than LARGEST_SLOPE_PER_MM along the vessel.

    probes: result of `at_probes`; table: result of `pullback`. FFR rises behind a narrowing until the jet has
    reattached, and where a side branch takes flow.
    """
    found = []
    for probe in probes:
        line = table[(table["branch"] == probe["branch"]) & ((table["s_mm"] - probe["s_mm"]).abs() <= SLOPE_WINDOW_MM)]
        slope = np.polyfit(line["s_mm"], line["ffr"], 1)[0] if len(line) > 1 else 0.0
        if slope > LARGEST_SLOPE_PER_MM:
            found.append(
                f"FFR at the probe {probe['name']} depends on its place: it still rises by {slope:.4f} a mm, as behind"
                " a narrowing whose jet has not reattached; a probe further on reads more"
            )
    return found
