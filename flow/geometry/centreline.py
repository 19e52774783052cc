"""Centrelines of a tree: polylines with arc length and radius, read from centreline.vtp."""

import dataclasses

import numpy as np
from scipy.spatial import cKDTree
from vtk.util.numpy_support import vtk_to_numpy

from common import polyline, vtp
from common.errors import InputError
from flow.geometry.surface import INLET

# Limits of a ratio: the distance from a centreline point to the nearest wall node, over the centreline's radius there.
# In the study the ratio is 1.00 to 1.05. With the centreline of the state before or after an intervention it falls to
# .52 in places and rises to 1.82 in others.
NEAREST_WALL, FURTHEST_WALL = 0.7, 1.5
CAP_DISTANCE_RADII = (
    1.5  # largest distance of a branch's end from the centre of its cap, in radii of the cap (study: .015)
)
LENGTH_TOLERANCE = 0.01  # largest difference of s_mm from the arc length, over the branch's length (study: .0005)
# The nearest wall node may always be this much further away than the radius: in a throat, nodes may be a diameter
# apart.
WALL_ALLOWANCE_MM = 0.3


@dataclasses.dataclass
class Branch:
    """One branch: name, id, points (n, 3) in mm, their arc lengths s_mm (n,) and radii radius_mm (n,)."""

    name: str
    branch_id: int
    points: np.ndarray
    s_mm: np.ndarray
    radius_mm: np.ndarray

    @property
    def length_mm(self):
        """Arc length in mm of the last point."""
        return float(self.s_mm[-1])

    def point(self, s_mm):
        """Point (3,) or points (m, 3) in mm at arc length s_mm (clamped to the branch)."""
        return polyline.point_at(self.points, self.s_mm, s_mm)

    def radius(self, s_mm):
        """Radius in mm at arc length s_mm (clamped to the branch)."""
        return np.interp(s_mm, self.s_mm, self.radius_mm)

    def project(self, point):
        """(s_mm, distance_mm): place of the point on the polyline that is nearest to `point` (3,), and its distance."""
        return polyline.project(self.points, self.s_mm, point)

    def outside_parent(self, parent, radii):
        """Whether each point (n,) of this side branch comes after the branch has left its parent's lumen.

        The branch has left where its axis is `radii` parent radii away from the axis of the Branch `parent`.
        """
        found = [parent.project(point) for point in self.points]
        return np.logical_or.accumulate([distance > radii * parent.radius(s) for s, distance in found])


class Tree:
    """The branches of an artery; iterates over them, main first, and finds them by name."""

    def __init__(self, branches):
        self.branches = sorted(branches, key=lambda branch: (branch.name != "main", branch.branch_id))

    def __iter__(self):
        return iter(self.branches)

    def __getitem__(self, name):
        for branch in self.branches:
            if branch.name == name:
                return branch
        known = ", ".join(branch.name for branch in self.branches)
        raise InputError("no such branch", "centreline", name, f"known: {known}")

    @property
    def main(self):
        """The Branch named main, which starts at the inlet."""
        return self.branches[0]

    def project_probe(self, probe):
        """(Branch, s_mm, distance_mm) of the place on its branch's axis that is nearest to a probe of boundary.json."""
        branch = self[probe["branch"]]
        return branch, *branch.project(np.array(probe["point_mm"]))

    def nearest(self, points, within_mm=np.inf):
        """(number (m,) of the nearest centreline point, its distance (m,) in mm) for points (m, 3) in mm.

        The centreline points of all branches are numbered in the tree's order. Where none is nearer than `within_mm`,
        the distance is infinite, and the number is one beyond the last point's.
        """
        if not hasattr(self, "_kd"):
            self._kd = cKDTree(np.concatenate([branch.points for branch in self.branches]))
        distance, index = self._kd.query(points, distance_upper_bound=within_mm)
        return index, distance


def check_wall(tree, wall_mm, where):
    """Raises InputError unless the tree fits the wall with the nodes wall_mm (n, 3) of the file `where`.

    This refuses the centreline of another state of the vessel. The distance to the nearest wall node must fit the
    tree's radii, which are radii of largest inscribed spheres. Where a branch is still inside another one, the wall may
    be further away.
    """
    nodes = cKDTree(wall_mm)
    for branch in tree:
        distance, _ = nodes.query(branch.points)
        own = np.ones(len(branch.points), bool)
        for other in tree:
            if other is not branch:
                gap, nearest = cKDTree(other.points).query(branch.points)
                own &= gap > other.radius_mm[nearest]
        furthest = np.maximum(FURTHEST_WALL * branch.radius_mm, branch.radius_mm + WALL_ALLOWANCE_MM)
        for k in np.flatnonzero((distance < NEAREST_WALL * branch.radius_mm) | (own & (distance > furthest)))[:1]:
            value = f"{distance[k]:.4g} mm, where the centreline's radius is {branch.radius_mm[k]:.4g} mm"
            place = f"{where}: wall's distance from {branch.name} at {branch.s_mm[k]:.4g} mm"
            raise InputError("centreline of another lumen", place, value, "give that of this lumen, both in mm")


def check_ends(tree, surface, where):
    """Raises InputError unless the tree of the file `where` covers the whole lumen of a geometry.surface.Surface.

    The main branch must start at the inlet, and the branches must end at the outlets, one at each.
    """
    caps, free = surface.cap_circles(), set(surface.caps)
    remedy = "give the surface and the centreline of one lumen, both in mm"
    places = [("start of", tree.main, 0)] + [("end of", branch, -1) for branch in tree]
    for name, branch, end in places:
        gaps = {cap: np.linalg.norm(caps[cap][0] - branch.points[end]) / caps[cap][2] for cap in sorted(free)}
        gaps = {cap: gap for cap, gap in gaps.items() if (cap == INLET) == (end == 0)}
        nearest = min(gaps, key=gaps.get, default=None)
        if nearest is None or gaps[nearest] > CAP_DISTANCE_RADII:
            value = "none is left" if nearest is None else f"the nearest is {gaps[nearest]:.3g} of its radii away"
            place = f"{where}: {name} {branch.name}"
            raise InputError("centreline does not end at an inlet or outlet of the lumen", place, value, remedy)
        free.remove(nearest)
    if free:
        raise InputError("outlet of the lumen without a branch", where, f"region_id {sorted(free)}", remedy)


def read(path):
    """Tree from centreline.vtp, its branches checked. Raises InputError."""
    data = vtp.read(path, "make it with the anatomy step")
    arrays = {}
    for name in ("s_mm", "radius_mm"):
        array = data.GetPointData().GetArray(name)
        if array is None:
            raise InputError("centreline lacks a point array", path, name, "make it with the anatomy step")
        arrays[name] = vtk_to_numpy(array).astype(float)
    ids, names = data.GetCellData().GetArray("branch_id"), data.GetCellData().GetAbstractArray("branch_name")
    if ids is None or names is None or data.GetNumberOfLines() == 0:
        raise InputError("centreline lacks branches", path, "branch_id, branch_name", "make it with the anatomy step")
    points = vtp.points(data)
    branches = []
    for k, index in enumerate(vtp.lines(data)):
        branches.append(
            Branch(
                names.GetValue(k),
                int(ids.GetTuple1(k)),
                points[index],
                arrays["s_mm"][index],
                arrays["radius_mm"][index],
            )
        )
        _check_branch(branches[-1], f"{path}: {branches[-1].name}")
    found = [branch.name for branch in branches]
    if len(set(found)) < len(found):
        raise InputError("two branches have the same name", path, found, "make it with the anatomy step")
    return Tree(branches)


def _check_branch(branch, where):
    """Raises InputError for a Branch of the file `where` that cannot be used.

    Its numbers must be finite, its radii positive, successive points different, and s_mm the arc length from the first
    point.
    """
    remedy = "make it with the anatomy step"
    if len(branch.points) < 2:
        raise InputError("branch of a centreline without a length", where, f"{len(branch.points)} points", remedy)
    for name, values in (("point", branch.points), ("s_mm", branch.s_mm), ("radius_mm", branch.radius_mm)):
        bad = np.flatnonzero(~np.isfinite(values.reshape(len(values), -1)).all(axis=1))
        if len(bad):
            raise InputError(f"{name} of a centreline is not finite", where, f"number {bad[0]}", remedy)
    steps = np.linalg.norm(np.diff(branch.points, axis=0), axis=1)
    along = np.append(0.0, np.cumsum(steps))
    for bad, what in (
        (branch.radius_mm <= 0, "radius_mm of a centreline is not positive"),
        (np.append(steps <= 0, False), "two points of a centreline at one place"),
        (np.append(np.diff(branch.s_mm) <= 0, False), "s_mm of a centreline does not ascend"),
    ):
        if bad.any():
            k = int(np.argmax(bad))
            value = f"point {k}, s_mm {branch.s_mm[k]:.4g}, radius_mm {branch.radius_mm[k]:.4g}"
            raise InputError(what, where, value, remedy)
    k = int(np.argmax(np.abs(branch.s_mm - along)))
    if abs(branch.s_mm[k] - along[k]) > LENGTH_TOLERANCE * along[-1]:
        value = f"{branch.s_mm[k]:.4g} mm where {along[k]:.4g} mm of the line lie before it"
        raise InputError("s_mm of a centreline is not its arc length", where, value, f"{remedy}, all in mm")
