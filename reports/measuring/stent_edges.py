"""How far the wall is stretched next to each edge of a stent: a hint of where a dissection may start."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from common import vtp
from common.errors import InputError
from reports.inputs.polyline import nearest_places, read_branches
from reports.inputs.reading import entry, read_array, read_polydata
from reports.inputs.surface import read_device

# OCT studies look for edge dissections in the segments of 5 mm proximal and distal to the stent (Radu et al.,
# EuroIntervention 2014; 9: 1085-1094; abstract read).
EDGE_SEGMENT_MM = 5.0
# Stretch at which strips of human artery tear: 1.50 +- 0.22 in mean and standard deviation, alike in media, adventitia
# and the whole wall, along and around the vessel (Teng et al., J Biomech 2009; 42: 2535-2539; abstract read;
# atherosclerotic carotid arteries). In coronary arteries it is alike in all layers too (Holzapfel et al., Am J Physiol
# Heart Circ Physiol 2005; 289: H2048-H2058; abstract read). Quoted from memory of that paper, not confirmed: 1.55 to
# 1.87 in the mean, least in the intima. The lower figure is taken, so that the hint comes early.
# The tests count from the unloaded strip, but `wall_stretch` counts from the lumen before PCI, under blood pressure.
# Diseased coronary arteries stretch by 1 to 10 % up to 250 kPa (Kural et al., J Biomech 2012; 45: 790-798; abstract
# read), so at most a tenth is left out.
RUPTURE_STRETCH = 1.5
ENDS = ("proximal", "distal")


def stent_edges(files, stents):
    """Rows {stent, device, branch, end, largest_stretch, beyond_limit} of every edge of the deployed stents.

    stents: the entry `stents` of deployment.json. stent: number from 1 in its order. end: one of ENDS. branch: the
    vessel's branch at the edge. largest_stretch: the wall's largest principal stretch within EDGE_SEGMENT_MM outside
    the edge, where no stent is; of the final state. An edge without such wall is left out: it lies in another stent.

    Raises InputError if a file or array is missing, if there are more or fewer surfaces than stents, or if a surface
    has no two open ends.
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
    """{branch: (first, last)} in mm of a stent whose points lie at `branches` and `s_mm` (n,)."""
    found = {branch: s_mm[branches == branch] for branch in np.unique(branches)}
    return {branch: (own.min(), own.max()) for branch, own in found.items()}


def within(spans, branches, s_mm):
    """Whether the places `branches` and `s_mm`, one or (n,), lie between the ends of a stent with these spans."""
    return np.any([(branches == branch) & (first < s_mm) & (s_mm < last) for branch, (first, last) in spans.items()], 0)


def end_places(lines, surface, path, branch):
    """[(branch, s_mm)] of a stent's proximal and its distal edge, each at the middle of its open loop.

    surface: the stent's surface, open at both ends; path: its file, for messages. branch: where the stent was placed;
    its proximal end may lie in the parent vessel. Raises InputError if the surface has no two open ends.
    """
    loops = open_loops(surface)
    if len(loops) != len(ENDS):
        raise InputError("a stent's surface needs two open ends", path, f"{len(loops)} ends", "repeat: vci deploy")
    places = zip(*nearest_places(lines, np.array([surface.points[loop].mean(axis=0) for loop in loops])))
    return sorted(((str(own), float(s_mm)) for own, s_mm in places), key=lambda place: (place[0] == branch, place[1]))


def open_loops(surface):
    """Arrays of the vertices of each connected open edge of a Surface."""
    triangles = surface.triangles
    sides = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    sides, uses = np.unique(sides, axis=0, return_counts=True)
    sides, count = sides[uses == 1], len(surface.points)
    graph = coo_matrix((np.ones(len(sides)), sides.T), (count, count))
    _, part = connected_components(graph, directed=False)
    vertices = np.unique(sides)
    return [vertices[part[vertices] == k] for k in np.unique(part[vertices])]
