"""The axes of a lumen as evenly spaced points, by which a registration compares two lumens."""

import dataclasses
import pathlib

import numpy as np
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp

from ..lumen_results import read_summary

STEP_MM = 0.5  # distance between the points of an axis
MIRROR = np.array([1.0, 1.0, -1.0])  # factors of x, y and z that turn a vessel into its mirror image


@dataclasses.dataclass(frozen=True)
class Line:
    """One axis: points (n, 3) in mm about STEP_MM apart, with their inscribed radii (n,) in mm and branches (n,)."""

    points: np.ndarray
    radius: np.ndarray
    branch: np.ndarray


@dataclasses.dataclass(frozen=True)
class Tree:
    """The axes of a lumen.

    branches: {name of a branch: its Line}. routes: {name of a branch: Line from the inlet to the branch's end}.
    summary: content of anatomy.json.
    """

    branches: dict
    routes: dict
    summary: dict

    def mirrored(self):
        """The Tree of the mirror image, with z negated; the summary stays as it is."""
        branches, routes = (
            {name: dataclasses.replace(line, points=line.points * MIRROR) for name, line in lines.items()}
            for lines in (self.branches, self.routes)
        )
        return Tree(branches, routes, self.summary)

    @property
    def points(self):
        """All points (n, 3) of the branches, in their order."""
        return np.concatenate([line.points for line in self.branches.values()])

    @property
    def radius(self):
        """Inscribed radii (n,) in mm of all points, in the same order."""
        return np.concatenate([line.radius for line in self.branches.values()])

    @property
    def names(self):
        """Names (n,) of the branches of all points, in the same order."""
        return np.concatenate([line.branch for line in self.branches.values()])

    @property
    def usual_radius_mm(self):
        """Median inscribed radius (mm) of the main vessel, the unit in which distances between axes are stated."""
        return float(np.median(self.branches["main"].radius))


def read(folder):
    """The Tree of a folder made by `lumen process`. Raises InputError."""
    folder = pathlib.Path(folder)
    summary = read_summary(folder)
    poly = vtp.read(folder / "centreline.vtp", "run `lumen process` again")
    names = poly.GetCellData().GetAbstractArray("branch_name")
    s, radius = (vtk_to_numpy(poly.GetPointData().GetArray(key)).astype(float) for key in ("s_mm", "radius_mm"))
    points, branches, routes = vtp.points(poly), {}, {}
    for cell, rows in enumerate(vtp.lines(poly)):
        name = str(names.GetValue(cell))
        branches[name] = _resampled(name, s[rows], points[rows], radius[rows])
    parents = {branch["name"]: (branch["parent"], branch["s_on_parent_mm"]) for branch in summary["branches"]}
    for name in branches:
        routes[name] = _route(name, branches, parents)
    return Tree(branches, routes, summary)


def _resampled(name, s, points, radius):
    count = max(2, 1 + int(round((s[-1] - s[0]) / STEP_MM)))
    at = np.linspace(s[0], s[-1], count)
    placed = np.stack([np.interp(at, s, points[:, k]) for k in range(3)], axis=1)
    return Line(placed, np.interp(at, s, radius), np.full(count, name))


def _route(name, branches, parents):
    """The Line from the inlet through the parents to the branch's end.

    parents: {branch: (parent or None, s_on_parent_mm)}.
    """
    pieces, take_off_mm = [], None
    while name is not None:
        line = branches[name]
        last = len(line.points) if take_off_mm is None else 1 + int(round(take_off_mm / STEP_MM))
        pieces.insert(0, (line.points[:last], line.radius[:last], line.branch[:last]))
        name, take_off_mm = parents[name]
    return Line(*(np.concatenate([piece[k] for piece in pieces]) for k in range(3)))
