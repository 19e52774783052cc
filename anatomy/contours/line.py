"""A vessel's centreline as a smooth curve, with two directions across it that do not twist along it."""

import numpy as np
from scipy.interpolate import CubicSpline, make_lsq_spline
from vtkmodules.util.numpy_support import vtk_to_numpy

from common import vtp
from common.errors import InputError

from .reading.tables import MILLIMETRES

SPACING_MM = 0.05  # distance between the points of a Line
FEWEST_POINTS = 4  # a cubic curve needs this many points
SHORTEST_MM = 1.0  # a shorter line is refused: its coordinates are metres that were declared as mm
LONGEST_MM = 400.0  # no coronary artery with its aorta is longer: coordinates in mm were declared as cm or m
RADIUS_ARRAYS = (
    "MaximumInscribedSphereRadius",
    "radius_mm",
    "Radius",
)  # names of the radius array in files of VMTK, of this package, of other programs
END_SHARE, WIDENING_RATIO = (
    0.2,  # share of the line's points that counts as one end
    1.1,  # ratio of the radii, last end over first end, above which a warning is given
)
KNOTS_MM = 3.0  # distance of the smoothing spline's knots: bends of arteries are longer, noise of voxels is shorter


class Line:
    """Smoothed curve through points (n, 3) in mm, from the proximal end on.

    s_mm (k,): arc lengths of the curve's own points, in mm from the proximal end. At each of them there are a tangent
    and two unit vectors across it. These two do not twist along the curve (parallel transport by double reflection:
    Wang et al., ACM Trans Graph 27 (2008) 2). warnings: sentences about the line.
    """

    def __init__(self, points, warnings=()):
        self.warnings = list(warnings)
        points = _smooth_points(np.asarray(points, float))
        along = _arc_lengths(points)
        count = max(int(np.ceil(along[-1] / SPACING_MM)), 3) + 1
        curve = CubicSpline(along, points)
        self.s_mm = np.linspace(0, along[-1], count)
        self._points = curve(self.s_mm)
        self._tangents = _unit(curve(self.s_mm, 1))
        self._first = _parallel_transport(self._points, self._tangents)

    @property
    def length_mm(self):
        """Length of the curve in mm."""
        return self.s_mm[-1]

    def frame_at(self, s_mm):
        """(points in mm, tangents, first, second), each (k, 3), at arc lengths s_mm (k,) on the curve.

        first and second are the unit vectors across the tangents.
        """
        found = [
            np.column_stack([np.interp(s_mm, self.s_mm, values[:, k]) for k in range(3)])
            for values in (self._points, self._tangents, self._first)
        ]
        points, tangents = found[0], _unit(found[1])
        first = found[2] - (found[2] * tangents).sum(axis=1)[:, None] * tangents
        first = _unit(first)
        return points, tangents, first, np.cross(tangents, first)

    def nearest(self, point):
        """Arc length in mm of the curve's place nearest to a point (3,) in mm."""
        return float(self.s_mm[np.linalg.norm(self._points - point, axis=1).argmin()])


def read(path, units, number=None):
    """The Line of a .vtp file whose lines begin at the proximal end. Raises InputError.

    units: unit of the file's coordinates. number: which of several lines, from 1.
    """
    poly = vtp.read(path, "a centreline in a .vtp file: lines that begin at the proximal end")
    found = vtp.lines(poly)
    if not found:
        remedy = "export the centreline as a line along the vessel (VMTK's centrelines are), not as points alone"
        raise InputError("no lines in the centreline's file", path, "no line cells", remedy)
    which = f"say which by line: 1 to {len(found)} (--line)"
    if number is None and len(found) > 1:
        raise InputError("several lines to lay the pull-back on", path, f"{len(found)} lines", which)
    if number is not None and not 1 <= number <= len(found):
        raise InputError("no such line", path, f"line {number} of {len(found)}", which)
    rows = found[(number or 1) - 1]
    points = vtp.points(poly)[rows] * MILLIMETRES[units]
    if not np.isfinite(points).all():
        value = f"point {int((~np.isfinite(points)).any(axis=1).argmax()) + 1} of line {number or 1}"
        raise InputError("a point of the centreline is not finite", path, value, "remove it and export the line again")
    points = points[np.concatenate([[True], np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-6])]
    if len(points) < FEWEST_POINTS:
        remedy = f"at least {FEWEST_POINTS} points at different places, along the whole vessel"
        raise InputError("too few points on the centreline", path, f"{len(points)} in line {number or 1}", remedy)
    if not SHORTEST_MM <= (length := _arc_lengths(points)[-1]) <= LONGEST_MM:
        remedy = "declare the units of the centreline's file (centreline: units, --centreline-units)"
        which = "shorter" if length < SHORTEST_MM else "longer"
        raise InputError(f"the centreline is {which} than any vessel", path, f"{length:.3g} mm as {units}", remedy)
    return Line(points, _widening(poly, rows))


def _widening(poly, rows):
    """Yields a warning if the file has radii and they grow along the line: it probably begins at the distal end."""
    radii = next((array for name in RADIUS_ARRAYS if (array := poly.GetPointData().GetArray(name))), None)
    if radii is None:
        return
    radius, end = vtk_to_numpy(radii)[rows], max(1, int(END_SHARE * len(rows)))
    first, last = np.median(radius[:end]), np.median(radius[-end:])
    if last > WIDENING_RATIO * first > 0:
        yield (
            f"the centreline's radius grows from {first:.3g} to {last:.3g} along it: does it begin at the proximal end?"
            " Otherwise turn it round"
        )


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def _arc_lengths(points):
    """Arc lengths (n,) of points (n, 3) from the first point on."""
    return np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _smooth_points(points):
    """Points (n, 3) about SPACING_MM apart on a least-squares cubic spline with knots KNOTS_MM apart.

    The fit needs points SPACING_MM apart. Between more than 50 given points they are interpolated linearly. Fewer
    points lie far apart, and straight pieces between them would have corners, so the interpolation is cubic there.
    """
    along = _arc_lengths(points)
    fine = np.linspace(0, along[-1], int(np.ceil(along[-1] / SPACING_MM)) + 1)
    points = (
        np.column_stack([np.interp(fine, along, points[:, k]) for k in range(3)])
        if len(points) > 50
        else CubicSpline(along, points)(fine)
    )
    inner = np.linspace(0, along[-1], max(int(along[-1] / KNOTS_MM), 1) + 1)
    knots = np.concatenate([[0] * 3, inner, [along[-1]] * 3])
    return make_lsq_spline(fine, points, knots, 3)(fine)


def _parallel_transport(points, tangents):
    """Unit vectors (n, 3) across the tangents (n, 3) that do not twist along points (n, 3), by double reflection."""
    first = np.empty_like(points)
    first[0] = np.cross(tangents[0], np.eye(3)[np.abs(tangents[0]).argmin()])
    first[0] /= np.linalg.norm(first[0])
    for i in range(len(points) - 1):
        step = points[i + 1] - points[i]
        c = step @ step
        reflected = first[i] - 2 / c * (step @ first[i]) * step
        tangent = tangents[i] - 2 / c * (step @ tangents[i]) * step
        turn = tangents[i + 1] - tangent
        d = turn @ turn
        first[i + 1] = reflected - (2 / d * (turn @ reflected) * turn if d > 1e-24 else 0)
        first[i + 1] /= np.linalg.norm(first[i + 1])
    return first
