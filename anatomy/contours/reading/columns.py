"""The columns of a contour table by their names: where frame, x, y, z stand, and the units that the names state."""

import csv
import re

from common.errors import InputError

PLACES = ("x", "y", "z")
OUTLINE = re.compile(r"|(?:outline|contour|part|deposit|region|number)(?:[ _.-]?(?:no|nr|number|id|index))?")
USUAL = [0, 1, 2, 3]  # frame, x, y, z, where no names say otherwise
DECLARED = ("mm", "cm", "m")  # units that a case and the command line can declare
UNITS = {"µm": "um", "μm": "um", "micron": "um", "microns": "um", "pixel": "px", "pixels": "px"}
NAME = re.compile(
    r"(frame(?:[ _.-]?(?:no|nr|number|id|index))?|[xyz])(?:[ _.\[(]+(mm|cm|m|um|µm|μm|microns?|px|pixels?)[\])]?)?"
)


def fields(line):
    """The fields of a line, divided by tabs, commas, semicolons or blanks; quotes hold a field together."""
    if '"' not in line:
        return [field for field in re.split(r"[,;\t ]+", line) if field]
    divider = next((sign for sign in "\t;," if sign in line), " ")
    return [field.strip() for field in next(csv.reader([line], delimiter=divider, skipinitialspace=True))]


def names_in(line):
    """The names in a line of names; blanks divide them only if nothing else does, as in `x [mm], y [mm]`."""
    if '"' in line or not any(sign in line for sign in "\t;,"):
        return fields(line)
    return [name.strip() for name in re.split("[,;\t]", line)]


def order(names, units, where):
    """Numbers of the columns of frame, x, y, z, and of the outline's number if there is one, by names (fields).

    A further column of another name is not read, nor is one without a name before the others: a spreadsheet's row
    number.

    Names that are not known leave the columns where they usually are. Raises InputError if the names contradict the
    units declared, or if x, y and z stand at other places and the frame cannot be told.
    """
    found = {}
    for number, name in enumerate(names):
        match = NAME.fullmatch(name.strip().lower())
        if match:
            found.setdefault(match[1][:5], number)
            _check_units(match[2], units, f"{where}, column {name.strip()}")
    usual = USUAL + [4] * (len(names) == 5)
    if len(names) < len(USUAL) or any(place not in found for place in PLACES):
        return usual
    others = [number for number in range(len(names)) if number not in [found[place] for place in PLACES]]
    frame = found.get("frame", 0 if 0 in others else None)
    if frame is None and len(others) == 1:
        frame = others[0]
    if frame is None or ("frame" not in found and len(others) > 1 and [found[p] for p in PLACES] != USUAL[1:]):
        remedy = "name the frame's column frame; a further one may be named outline, the number of an outline"
        raise InputError("no column is named frame", where, ", ".join(names), remedy)
    fifth = [k for k in others if k != frame and (names[k].strip() or k == len(names) - 1 == 4)]
    fifth = [k for k in fifth if OUTLINE.fullmatch(names[k].strip().lower())]
    return [frame, *(found[place] for place in PLACES), *fifth[:1]]


def picked(line, names, order_of_names):
    """The numbers in the columns `order_of_names` of a line that has as many fields as there are names, else None.

    Other columns are not looked at: they may hold words, or nothing.
    """
    for cells in (fields(line), names_in(line)):
        if len(cells) == len(names) and all(is_number(cells[k]) for k in order_of_names):
            return [float(cells[k]) for k in order_of_names]
    return None


def name_places(names):
    """Whether the names say which columns are x, y and z."""
    found = [NAME.fullmatch(name.strip().lower()) for name in names]
    return {match[1] for match in found if match} >= set(PLACES)


def is_number(field):
    """Whether a field is a number."""
    try:
        float(field)
    except ValueError:
        return False
    return True


def _check_units(named, units, where):
    named = UNITS.get(named, named)
    if named == "px":
        raise InputError(
            "the table is in image pixels", where, named, "multiply by a pixel's size in mm, in the names too"
        )
    if named not in (None, units):
        remedy = f"declare the units of all columns (units: {named}, --units {named}), or correct the names"
        if named not in DECLARED:
            remedy = "multiply x, y, z by 0.001, and the names say mm; declare mm (units: mm, --units mm)"
        raise InputError("the names of the columns state other units", where, f"{named}, declared {units}", remedy)
