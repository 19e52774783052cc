"""Reads contour tables: text with frame, x, y, z, and perhaps the number of an outline within its frame."""

import gzip
import pathlib

import numpy as np

from common.errors import InputError
from common.files import replacing

from . import REGION_TABLES, columns, outlines

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 0.001}
PLANE_TOLERANCE_MM = (
    0.01  # largest range of z within a frame: z may have been rounded to two decimals, or rotated and rotated back
)
COLUMNS_REMEDY = "four numbers: frame, x, y, z; decimal points; a fifth, the outline's number, in all lines or in none"
NUMBERING_REMEDY = "number several deposits of a frame in a fifth column, named outline if the table has names"


def read_rows(path, units):
    """Rows (n, 5) of a text table: frame, x, y, z in mm, and the outline's number, 0 if the table has none.

    path: file of the table, compressed if its name ends in .gz. units: unit of x, y, z. Columns are separated by tabs,
    commas, semicolons or blanks. Lines that begin with # are skipped. A first line may hold the columns' names, which
    tell the columns (columns.column_order). Raises InputError with the line that cannot be read.
    """
    lines = _lines(path)
    rows, names, by_name = [], None, None
    for number, line in enumerate(lines, start=1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        where = f"{path}, line {number}"
        if not rows and names is None and not all(map(columns.is_number, columns.split_fields(line))):
            names = columns.column_names(line)
            order = columns.column_order(names, units, where)
            continue
        if not rows:  # the first point decides whether the columns are read by their names or in the usual order
            known = names is not None and columns.names_coordinates(names)
            by_name = known and (len(names) > 5 or columns.picked_numbers(line, names, order) is not None)
        row = columns.picked_numbers(line, names, order) if by_name else _numbers(line, where, bool(rows))
        if row is None:
            raise _not_numbers_error(columns.split_fields(line), where, line, bool(rows))
        if len(row) not in (4, 5) or len(row) != len((rows or [row])[0]) or not np.isfinite(row).all():
            raise InputError("not a point of a contour", where, line, COLUMNS_REMEDY)
        rows.append(row)
    if not rows:
        raise InputError("no points in the contour table", path, f"{len(lines)} lines", "lines of frame, x, y, z")
    table = np.zeros((len(rows), 5))
    table[:, : len(rows[0])] = rows
    table[:, 1:4] *= MILLIMETRES[units]
    return table


def _numbers(line, where, after_points):
    """All fields of a line as numbers [float]. Raises InputError. after_points: whether points precede the line."""
    fields = columns.split_fields(line)
    if not all(map(columns.is_number, fields)):
        raise _not_numbers_error(fields, where, line, after_points)
    return [float(field) for field in fields]


def unknown_names_warning(path):
    """A warning if a table's column names do not tell which are x, y and z; None if they do, or if it has no names."""
    line = next((line for line in map(str.strip, _lines(path)) if line and not line.startswith("#")), "")
    if any(columns.is_number(field) for field in columns.split_fields(line)) or columns.names_coordinates(
        columns.column_names(line)
    ):
        return None
    return f"{path}: the names `{line}` are not known; the columns are read as frame, x, y, z"


def _lines(path):
    """The lines [str] of a text file, compressed if it ends in .gz. Raises InputError."""
    path = pathlib.Path(path)
    if not path.is_file():
        raise InputError("no such contour table", path, "missing", "check the path, or VCI_DATA_DIR")
    try:
        content = gzip.open(path).read() if path.suffix == ".gz" else path.read_bytes()
        return content.decode("utf-8-sig").splitlines()
    except (OSError, EOFError, UnicodeDecodeError) as error:
        remedy = "a spreadsheet: export it as CSV; a compressed table: copy it again, it is damaged"
        raise InputError("the contour table is not text", path, error, remedy) from error


def _not_numbers_error(fields, where, line, after_points):
    """The InputError for a line with fields that are not numbers: a second line of names, or a damaged point."""
    if not after_points and not any(character.isdigit() for field in fields for character in field):
        remedy = "one line of names; put # before further ones, and declare units by units (--units)"
        return InputError("a second line of names", where, line, remedy)
    return InputError("not a number", where, line, "numbers for frame, x, y, z; decimal points; a field for each name")


def read_outlines(path, units, what, is_used=None):
    """{frame's name: (z in mm, outline (n, 2) in mm)} of a table with one outline in each frame.

    Outlines run counter-clockwise, without repeated points. what: the table's name in messages. is_used: function of a
    frame's name and z that tells whether the frame is used; other frames are not checked. Raises InputError for a frame
    with several outlines or not in one plane, and for an outline that outlines.checked_outline() refuses.
    """
    name = what.replace("_", " ")
    one = f"one outline of the {name} in each frame, listed once; side branches have their own table (branches)"
    found = {}
    for frame, (z, several) in _read(path, units, what, is_used, one, False).items():
        if len(several) > 1:
            raise InputError("several outlines in one frame", _where(path, what, frame), len(several), one)
        found[frame] = z, several[0]
    return found


def read_regions(path, units, what, is_used=None):
    """{frame's name: (z in mm, [outline (n, 2) in mm])} of a table whose frames may have several outlines.

    Outlines are separated by their number, or because each ends on the point where it began. Parameters and errors are
    those of read_outlines(), but several outlines in a frame are no error.
    """
    return _read(path, units, what, is_used, NUMBERING_REMEDY, what in REGION_TABLES)


def _read(path, units, what, is_used, remedy, may_be_ring):
    """The result of read_regions(). remedy, may_be_ring: passed to outlines.checked_outline()."""
    found = {}
    for frame, rows in _frames(read_rows(path, units)):
        if is_used is None or is_used(frame, rows[0, 3]):
            where = _where(path, what, frame)
            _check_plane(rows, where)
            several = [outlines.checked_outline(part, where, remedy, may_be_ring) for part in _split_rows(rows)]
            found[frame] = float(rows[0, 3]), several
    return found


def _where(path, what, frame):
    return f"{path}: {what}, frame {frame}"


def _frames(rows):
    """[(frame's name, its rows)] in the order of the table."""
    return [(_name(frame), rows[rows[:, 0] == frame]) for frame in dict.fromkeys(rows[:, 0])]


def _split_rows(rows):
    """The outlines [points (n, 2) of each] in the rows of one frame."""
    numbered = (rows[rows[:, 4] == number, 1:3] for number in dict.fromkeys(rows[:, 4]))
    return [part for points in numbered for part in outlines.split_outlines(points)]


def _check_plane(rows, where):
    if np.ptp(rows[:, 3]) > PLANE_TOLERANCE_MM:
        value = f"z from {rows[:, 3].min():g} to {rows[:, 3].max():g} mm"
        remedy = "one z for each frame, its way in the pull-back; contours that lie in space go in as a surface."
        remedy += f" {outlines.COLUMNS_HINT}"
        raise InputError("a frame's points do not lie in one plane", where, value, remedy)


def read_points(path, units):
    """[(frame's name, z in mm, point (2,) in mm)] of a table of single points such as landmarks, in its order."""
    return [(_name(row[0]), row[3], row[1:3]) for row in read_rows(path, units)]


def _name(frame):
    return int(frame) if frame == int(frame) else float(frame)


def write_thinned(source, target, points):
    """Writes a contour table with fewer points: `points` evenly chosen rows of each outline, to 0.0001 mm.

    source: a table in mm. target: the table to write, whose first line names the columns. Some tables have hundreds of
    points in each frame, more than a catheter resolves.
    """
    frames = [(name, rows[0, 3], _split_rows(rows)) for name, rows in _frames(read_rows(source, "mm"))]
    numbered = any(len(parts) > 1 for _, _, parts in frames)
    lines = ["frame,x_mm,y_mm,z_mm" + ",outline" * numbered]
    for name, z, parts in frames:
        for number, part in enumerate(parts, start=1):
            part = part[:-1] if np.allclose(part[0], part[-1]) else part
            taken = part[np.unique(np.linspace(0, len(part), points, endpoint=False).astype(int))]
            lines += [f"{name},{x:.4f},{y:.4f},{z:.4f}" + f",{number}" * numbered for x, y in taken]
    with replacing(target) as partial:
        partial.write_text("\n".join(lines) + "\n")
