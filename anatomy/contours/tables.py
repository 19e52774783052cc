"""Reads contour tables (text with frame, x, y, z) into closed outlines and checks them."""

import gzip
import pathlib
import re

import numpy as np

from common.errors import InputError
from common.files import replacing

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 0.001}
FEWEST_POINTS = 8  # of an outline; with fewer a round lumen cannot be told from a square one
PLANE_MM = 0.01  # scatter of z within a frame, by rounding to two decimals or by rotating there and back
WIDEST_MM = 15.0  # coronary arteries, even with ectasia, are narrower; outlines in pixels are wider
LEAST_AREA_MM2 = 0.03  # a radius of 0.1 mm, less than the catheter's own


def read_rows(path, units):
    """Rows (n, 4) of frame, x, y, z in mm, of a text table, compressed by gzip if the name ends in .gz.

    Columns are separated by tabs, commas, semicolons or blanks. A first line of names and lines that begin with # are
    skipped. Raises InputError with the line that cannot be read.
    """
    path = pathlib.Path(path)
    if not path.is_file():
        raise InputError("no such contour table", path, "missing", "check the path, or VCI_DATA_DIR")
    try:
        content = gzip.open(path).read() if path.suffix == ".gz" else path.read_bytes()
        lines = content.decode("utf-8-sig").splitlines()
    except (OSError, EOFError, UnicodeDecodeError) as error:
        remedy = "a spreadsheet: export it as CSV; a compressed table: copy it again, it is damaged"
        raise InputError("the contour table is not text", path, error, remedy) from error
    rows, named = [], False
    for number, line in enumerate(lines, start=1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        fields = [field for field in re.split(r"[,;\t ]+", line) if field]
        try:
            row = [float(field) for field in fields]
        except ValueError:
            if not rows and not named:
                named = True
                continue
            raise InputError("not a number", f"{path}, line {number}", line, "frame, x, y, z; decimal points") from None
        if len(row) != 4 or not np.isfinite(row).all():
            raise InputError(
                "not a point of a contour",
                f"{path}, line {number}",
                line,
                "four numbers: frame, x, y, z; decimal points",
            )
        rows.append(row)
    if not rows:
        raise InputError("no points in the contour table", path, f"{len(lines)} lines", "lines of frame, x, y, z")
    table = np.array(rows)
    table[:, 1:] *= MILLIMETRES[units]
    return table


def read_outlines(path, units, what, wanted=None):
    """{frame: (z in mm, outline (n, 2) in mm, counter-clockwise, its last point not the first again)}.

    what: the table's name in errors. wanted(frame, z): whether a frame is used; other frames are not checked. Raises
    InputError for an outline that is not in one plane, crosses itself, has too few points, or is too small or too large
    for a coronary artery.
    """
    rows = read_rows(path, units)
    found = {}
    for frame in dict.fromkeys(rows[:, 0]):
        of_frame = rows[rows[:, 0] == frame]
        if wanted is None or wanted(_name(frame), of_frame[0, 3]):
            found[_name(frame)] = _outline(of_frame, f"{path}: {what}, frame {_name(frame)}")
    return found


def read_points(path, units):
    """[(frame, z in mm, point (2,) in mm)] of a table of single points, in its order."""
    return [(_name(row[0]), row[3], row[1:3]) for row in read_rows(path, units)]


def area_mm2(outline):
    """Signed area of a closed outline (n, 2) by its corners; positive if it runs counter-clockwise."""
    x, y = outline.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def centroid(outline):
    """Centroid (2,) of the area within a closed outline (n, 2)."""
    step = np.roll(outline, -1, axis=0)
    cross = outline[:, 0] * step[:, 1] - step[:, 0] * outline[:, 1]
    return ((outline + step) * cross[:, None]).sum(axis=0) / (3 * cross.sum())


def _name(frame):
    return int(frame) if frame == int(frame) else float(frame)


def _outline(rows, where):
    if np.ptp(rows[:, 3]) > PLANE_MM:
        value = f"z from {rows[:, 3].min():g} to {rows[:, 3].max():g} mm"
        remedy = "one z for each frame, its way in the pull-back; contours that lie in space go in as a surface"
        raise InputError("a frame's points do not lie in one plane", where, value, remedy)
    points = rows[:, 1:3]
    points = points[np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1) > 1e-6]
    if len(points) < FEWEST_POINTS:
        remedy = f"at least {FEWEST_POINTS} different ones, or leave the frame out (drop_frames)"
        raise InputError("too few points for an outline", where, len(points), remedy)
    size = np.ptp(points, axis=0).max()
    if size > WIDEST_MM:
        remedy = f"at most {WIDEST_MM:g} mm: image pixels must be multiplied by their size, and units declared"
        raise InputError("too wide for a coronary artery", where, f"{size:.4g} mm", remedy)
    crossing = _crossing(points)
    if crossing is not None:
        place = np.round(crossing, 3).tolist()
        raise InputError(
            "the outline crosses itself", where, f"at x, y = {place} mm", "trace the frame again, or drop_frames"
        )
    area = area_mm2(points)
    if abs(area) < LEAST_AREA_MM2:
        remedy = f"at least {LEAST_AREA_MM2} mm2: check units, or leave out what is no outline"
        raise InputError("hardly any area within the outline", where, f"{abs(area):.3g} mm2", remedy)
    return float(rows[0, 3]), points if area > 0 else points[::-1]


def _crossing(points):
    """A place (2,) where two edges of the closed outline cross, or None."""
    begin, along = points, np.roll(points, -1, axis=0) - points

    def side(i, j):  # (n, n): on which side of edge i edge j begins
        return along[i, 0] * (points[j, 1] - begin[i, 1]) - along[i, 1] * (points[j, 0] - begin[i, 0])

    n = len(points)
    i, j = np.triu_indices(n, 2)
    keep = ~((i == 0) & (j == n - 1))
    i, j = i[keep], j[keep]
    first = side(i, j) * side(i, (j + 1) % n) < 0
    i, j = i[first], j[first]
    both = side(j, i) * side(j, (i + 1) % n) < 0
    return begin[i[both][0]] if both.any() else None


def thin(source, target, points):
    """Writes a table of outlines with `points` evenly chosen rows of each frame, and coordinates to 0.0001 mm.

    The first line names the columns. It is for tables with hundreds of points a frame, more than a catheter resolves.
    """
    rows = read_rows(source, "mm")
    lines = ["frame,x_mm,y_mm,z_mm"]
    for frame in dict.fromkeys(rows[:, 0]):
        of_frame = rows[rows[:, 0] == frame]
        if len(of_frame) > 1 and np.allclose(of_frame[0], of_frame[-1]):
            of_frame = of_frame[:-1]
        taken = of_frame[np.unique(np.linspace(0, len(of_frame), points, endpoint=False).astype(int))]
        lines += [f"{_name(frame)},{x:.4f},{y:.4f},{z:.4f}" for _, x, y, z in taken]
    with replacing(target) as partial:
        partial.write_text("\n".join(lines) + "\n")
