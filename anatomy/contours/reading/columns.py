"""Tells which columns of a contour table hold frame, x, y and z, and in which units, by the columns' names."""

import csv
import re

from common.errors import InputError

COORDINATES = ("x", "y", "z")
OUTLINE_NAME = re.compile(r"|(?:outline|contour|part|deposit|region|number)(?:[ _.-]?(?:no|nr|number|id|index))?")
USUAL_ORDER = [0, 1, 2, 3]  # columns of frame, x, y, z if no names say otherwise
DECLARABLE_UNITS = ("mm", "cm", "m")  # units that a case file and the command line can declare
UNIT_SPELLINGS = {"µm": "um", "μm": "um", "micron": "um", "microns": "um", "pixel": "px", "pixels": "px"}
COLUMN_NAME = re.compile(
    r"(frame(?:[ _.-]?(?:no|nr|number|id|index))?|[xyz])(?:[ _.\[(]+(mm|cm|m|um|µm|μm|microns?|px|pixels?)[\])]?)?"
)


def split_fields(line):
    """The fields [str] of a line, divided by tabs, commas, semicolons or blanks. Signs within quotes do not divide."""
    if '"' not in line:
        return [field for field in re.split(r"[,;\t ]+", line) if field]
    divider = next((sign for sign in "\t;," if sign in line), " ")
    return [field.strip() for field in next(csv.reader([line], delimiter=divider, skipinitialspace=True))]


def column_names(line):
    """The column names [str] in a line. Blanks divide names only if no other sign does: `x [mm], y [mm]` has two."""
    if '"' in line or not any(sign in line for sign in "\t;,"):
        return split_fields(line)
    return [name.strip() for name in re.split("[,;\t]", line)]


def column_order(names, units, where):
    """Indices of the columns of frame, x, y, z, and of the outline's number if there is such a column.

    names: [str] of all columns. units: the units that the user declared. where: the place in the file, for messages.
    Columns with other names are not read. Beside a column named frame, a first column without a name is not read
    either: it holds a spreadsheet's row numbers. If x, y or z is not among the names, the columns are taken in the
    usual order. Raises InputError if the names state units other than the declared ones, or do not tell the frame's
    column.
    """
    found = {}
    for number, name in enumerate(names):
        match = COLUMN_NAME.fullmatch(name.strip().lower())
        if match:
            found.setdefault(match[1][:5], number)
            _check_units(match[2], units, f"{where}, column {name.strip()}")
    usual = USUAL_ORDER + [4] * (len(names) == 5)
    if len(names) < len(USUAL_ORDER) or any(place not in found for place in COORDINATES):
        return usual
    others = [number for number in range(len(names)) if number not in [found[place] for place in COORDINATES]]
    frame = found.get("frame", 0 if 0 in others else None)
    if frame is None and len(others) == 1:
        frame = others[0]
    if frame is None or (
        "frame" not in found and len(others) > 1 and [found[p] for p in COORDINATES] != USUAL_ORDER[1:]
    ):
        remedy = "name the frame's column frame; a further one may be named outline, the number of an outline"
        raise InputError("no column is named frame", where, ", ".join(names), remedy)
    fifth = [k for k in others if k != frame and (names[k].strip() or k == len(names) - 1 == 4)]
    fifth = [k for k in fifth if OUTLINE_NAME.fullmatch(names[k].strip().lower())]
    return [frame, *(found[place] for place in COORDINATES), *fifth[:1]]


def picked_numbers(line, names, order_of_names):
    """The numbers [float] in the columns `order_of_names` (indices) of a line. Other columns may hold words or nothing.

    None if the line has more or fewer fields than there are names, or if a picked field is not a number.
    """
    for cells in (split_fields(line), column_names(line)):
        if len(cells) == len(names) and all(is_number(cells[k]) for k in order_of_names):
            return [float(cells[k]) for k in order_of_names]
    return None


def names_coordinates(names):
    """Whether the names [str] tell which columns are x, y and z."""
    found = [COLUMN_NAME.fullmatch(name.strip().lower()) for name in names]
    return {match[1] for match in found if match} >= set(COORDINATES)


def is_number(field):
    """Whether a field is a number."""
    try:
        float(field)
    except ValueError:
        return False
    return True


def _check_units(named, units, where):
    """Raises InputError if a column's name states units other than the declared `units`.

    named: the stated units, or None if the name states none.
    """
    named = UNIT_SPELLINGS.get(named, named)
    if named == "px":
        raise InputError(
            "the table is in image pixels", where, named, "multiply by a pixel's size in mm, in the names too"
        )
    if named not in (None, units):
        remedy = f"declare the units of all columns (units: {named}, --units {named}), or correct the names"
        if named not in DECLARABLE_UNITS:
            remedy = "multiply x, y, z by 0.001, and the names say mm; declare mm (units: mm, --units mm)"
        raise InputError("the names of the columns state other units", where, f"{named}, declared {units}", remedy)
