"""How far the wall is stretched next to each edge of a stent: a hint of where a dissection may start."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from common import vtp
from common.errors import InputError
from reports.inputs.polyline import nearest_places, read_branches
from reports.inputs.reading import entry, read_array, read_polydata
from reports.inputs.surface import read_device

# OCT studies look for edge dissections within 5 mm proximal and distal to the stent (Radu et al., EuroIntervention
# 2014; 9: 1085-1094; only the abstract was read).
EDGE_SEGMENT_MM = 5.0
# Stretch at which strips of human artery tear. Of all papers here only the abstract was read. Atherosclerotic carotid
# arteries tear at 1.50 +- 0.22 (mean, standard deviation). Media, adventitia and whole wall are alike, along and around
# the vessel (Teng et al., J Biomech 2009; 42: 2535-2539). In coronary arteries the layers are alike too (Holzapfel et
# al., Am J Physiol Heart Circ Physiol 2005; 289: H2048-H2058). Their means, 1.55 (intima) to 1.87, are quoted from
# memory and not confirmed. The lower figure, 1.5, is taken, so that the hint comes early.
# The tests count stretch from the unloaded strip. `wall_stretch` counts it from the lumen before PCI, under blood
# pressure, and so misses at most a tenth: diseased coronary arteries stretch by 1 to 10 % up to 250 kPa (Kural et al.,
# J Biomech 2012; 45: 790-798).
RUPTURE_STRETCH = 1.5
ENDS = ("proximal", "distal")


def stent_edges(files, stents):
    """Rows {stent, device, branch, end, largest_stretch, beyond_limit} of every edge of the deployed stents.

    stents: the entry `stents` of deployment.json. stent: the stent's number in that order, from 1. end: one of ENDS.
    branch: the vessel's branch at the edge. largest_stretch: the largest principal stretch of the wall in the final
    state, within EDGE_SEGMENT_MM outside the edge and where no stent is. An edge within another stent is left out.

    Raises InputError if a file or array is missing, if there are more or fewer surfaces than stents, or if a surface
    does not have two open ends.
    """
    paths = files.stent_files()
    if len(paths) != len(stents):
        message = "the files of the stents do not match deployment.json"
        raise InputError(message, files.deployment, f"{len(paths)} files, {len(stents)} stents", "repeat: vci deploy")
    if not stents:
        return []
    lines = read_branches(files.anatomy("vci") / "centreline.vtp")
    lumen = read_polydata(files.deployed_lumen, "vci deploy")
    stretch = read_array(lumen.GetPointData(), "wall_stretch", files.deployed_lumen)
    branches, s_mm = nearest_places(lines, vtp.points(lumen))
    surfaces = [read_device(path) for path in paths]
    spans = [spans_by_branch(*nearest_places(lines, surface.points)) for surface in surfaces]
    bare = ~np.logical_or.reduce([within(span, branches, s_mm) for span in spans])
    rows = []
    for k, (path, surface, stent) in enumerate(zip(paths, surfaces, stents)):
        device, placed = (entry(stent, key, files.deployment) for key in ("device", "branch"))
        for end, (branch, edge) in zip(ENDS, end_places(lines, surface, path, placed)):
            outside = edge - s_mm if end == "proximal" else s_mm - edge
            near = bare & (branches == branch) & (outside >= 0.0) & (outside <= EDGE_SEGMENT_MM)
            in_another = any(within(span, branch, edge) for span in spans[:k] + spans[k + 1 :])
            if near.any() and not in_another:
                largest = float(stretch[near].max())
                row = {"stent": k + 1, "device": device, "branch": branch, "end": end, "largest_stretch": largest}
                rows.append(row | {"beyond_limit": largest > RUPTURE_STRETCH})
    return rows


def spans_by_branch(branches, s_mm):
    """{branch: (first, last)}: the arc lengths in mm that a stent covers. branches, s_mm (n,): places of its points."""
    found = {branch: s_mm[branches == branch] for branch in np.unique(branches)}
    return {branch: (own.min(), own.max()) for branch, own in found.items()}


def within(spans, branches, s_mm):
    """Whether places lie within a stent. branches, s_mm: one place or (n,). spans: result of spans_by_branch."""
    return np.any([(branches == branch) & (first < s_mm) & (s_mm < last) for branch, (first, last) in spans.items()], 0)


def end_places(lines, surface, path, branch):
    """[(branch, s_mm)] of a stent's proximal and distal edge. Each is the place of the middle of an open loop.

    surface: the stent's surface; path: its file, for messages. branch: the branch in which the stent was placed. The
    proximal end may lie in the parent vessel instead. Raises InputError if the surface does not have two open ends.
    """
    loops = open_loops(surface)
    if len(loops) != len(ENDS):
        raise InputError("a stent's surface needs two open ends", path, f"{len(loops)} ends", "repeat: vci deploy")
    places = zip(*nearest_places(lines, np.array([surface.points[loop].mean(axis=0) for loop in loops])))
    return sorted(((str(own), float(s_mm)) for own, s_mm in places), key=lambda place: (place[0] == branch, place[1]))


def open_loops(surface):
    """[vertex numbers] of each open loop of a Surface: connected sides of triangles that only one triangle has."""
    triangles = surface.triangles
    sides = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    sides, uses = np.unique(sides, axis=0, return_counts=True)
    sides, count = sides[uses == 1], len(surface.points)
    graph = coo_matrix((np.ones(len(sides)), sides.T), (count, count))
    _, part = connected_components(graph, directed=False)
    vertices = np.unique(sides)
    return [vertices[part[vertices] == k] for k in np.unique(part[vertices])]
