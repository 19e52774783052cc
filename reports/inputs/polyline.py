"""A line in space with its arc length, and the projection of points on it."""

import dataclasses

import numpy as np
from scipy.spatial import cKDTree

from common import polyline, vtp
from common.errors import InputError
from reports.inputs.reading import read_array, read_polydata


@dataclasses.dataclass(frozen=True)
class Polyline:
    """Points (n, 3) in mm with increasing arc length s_mm (n,); `source` is the file, for messages.

    anatomy_curvature_per_mm: the curvature (n,) in 1/mm that the anatomy step wrote at these points, or None.
    """

    points: np.ndarray
    s_mm: np.ndarray
    source: str
    anatomy_curvature_per_mm: np.ndarray = None

    def __post_init__(self):
        if len(self.s_mm) < 2:
            raise InputError("a line needs two points", self.source, len(self.s_mm), "repeat the anatomy step")
        steps = np.diff(self.s_mm)
        if not np.all(np.isfinite(self.points)) or not np.all(np.isfinite(self.s_mm)):
            raise InputError("a line holds a value that is not a number", self.source, "NaN", "repeat the anatomy step")
        if steps.min() <= 0.0:
            where = f"{self.source}: point {int(steps.argmin()) + 1}"
            raise InputError("arc length does not increase along a line", where, steps.min(), "repeat the anatomy step")

    def point_at(self, s_mm):
        """Points (..., 3) in mm at arc lengths s_mm (...), by linear interpolation. Beyond an end: the end point."""
        return polyline.point_at(self.points, self.s_mm, s_mm)

    def project(self, point):
        """Arc length and distance (mm) of the point of the line nearest to `point` (3,)."""
        return polyline.project(self.points, self.s_mm, point)


def read_centreline(path, branch):
    """The Polyline of the named branch in a centreline.vtp.

    Raises InputError if the file, its arrays or the branch are missing.
    """
    lines = read_branches(path)
    if branch not in lines:
        raise InputError("the centreline has no such branch", path, branch, f"branches there: {', '.join(lines)}")
    return lines[branch]


def read_branches(path):
    """{name: Polyline} of all branches in a centreline.vtp. Raises InputError if the file or its arrays are missing."""
    polydata = read_polydata(path, "anatomy")
    names = polydata.GetCellData().GetAbstractArray("branch_name")
    if names is None:
        raise InputError("a VTK array is missing", path, "branch_name", "repeat the anatomy step; see docs/design.md")
    points = vtp.points(polydata)
    s_mm, curvature = (
        read_array(polydata.GetPointData(), key, path).astype(float) for key in ("s_mm", "curvature_per_mm")
    )
    return {
        str(names.GetValue(k)): Polyline(points[rows], s_mm[rows], str(path), curvature[rows])
        for k, rows in enumerate(vtp.lines(polydata))
    }


def nearest_places(lines, points, spacing_mm=0.05):
    """Branch names (n,) and arc lengths (n,) in mm of the places on `lines` nearest to points (n, 3) in mm.

    lines: {name: Polyline}. The lines are sampled, so an arc length may be off by half of `spacing_mm`.
    """
    samples = {
        name: np.linspace(line.s_mm[0], line.s_mm[-1], 1 + int(np.ceil(np.ptp(line.s_mm) / spacing_mm)))
        for name, line in lines.items()
    }
    _, nearest = cKDTree(np.vstack([lines[name].point_at(s) for name, s in samples.items()])).query(points)
    branches = np.repeat(list(samples), [len(s) for s in samples.values()])
    return branches[nearest], np.concatenate(list(samples.values()))[nearest]
