"""Reads the results of `lumen process`: the summary anatomy.json and the table sections.csv."""

import csv
import pathlib

from common.documents import json_reader, schema
from common.errors import InputError

_NUMBERS = (
    "s_mm x_mm y_mm z_mm area_mm2 equivalent_diameter_mm min_diameter_mm max_diameter_mm inscribed_radius_mm "
    "reference_diameter_mm curvature_per_mm"
).split()


def read_summary(folder):
    """anatomy.json of a folder made by `lumen process`, as a dict. Raises InputError if there is no such document."""
    document = json_reader.read(pathlib.Path(folder) / "anatomy.json", "anatomy.json", "write it by `lumen process`")
    schema.validate(document, schema.read("anatomy_summary"), "an anatomy summary", "run `lumen process` again")
    return document.data


def read_sections(folder):
    """sections.csv of a folder made by `lumen process`: {branch: [row]}, each row a dict by the columns' names.

    Columns in _NUMBERS are floats, others text. Rows are in the file's order, by rising s_mm. Raises InputError.
    """
    path = pathlib.Path(folder) / "sections.csv"
    try:
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
    except OSError as error:
        raise InputError("no readable table of sections", path, error, "run `lumen process` first") from error
    branches = {}
    for line, row in enumerate(rows, 2):
        try:
            numbers = {key: float(row[key]) for key in _NUMBERS}
        except (KeyError, TypeError, ValueError) as error:
            where = f"{path}, line {line}"
            raise InputError("not a table of sections", where, error, "run `lumen process` again") from error
        branches.setdefault(row["branch"], []).append({**row, **numbers})
    if not branches:
        raise InputError("no section in the table", path, "no rows", "run `lumen process` again")
    return branches


def branch_named(summary, name, where):
    """The entry of a branch in anatomy.json (`summary`). Raises InputError with the known names if there is none.

    where: the place of the name in the user's input, for the message.
    """
    for branch in summary["branches"]:
        if branch["name"] == name:
            return branch
    known = ", ".join(branch["name"] for branch in summary["branches"])
    raise InputError("no such branch", where, name, f"branches of this lumen: {known}")


def lesion_numbered(summary, number, where):
    """The entry of the n-th most severe lesion (from 1) in anatomy.json (`summary`). Raises InputError if it has fewer.

    where: the place of the number in the user's input, for the message.
    """
    if number > len(summary["lesions"]):
        raise InputError(
            "no such lesion",
            where,
            f"lesion {number}, {len(summary['lesions'])} found",
            "place the device by centre_s_mm, or choose a lesion of anatomy.json",
        )
    return summary["lesions"][number - 1]
