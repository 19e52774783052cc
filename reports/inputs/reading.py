"""Readers of the study's JSON, CSV and VTP files. They refuse missing or malformed data, NaN and infinity."""

import math
import pathlib

import numpy as np
import pandas as pd
from vtkmodules.util.numpy_support import vtk_to_numpy

from common import vtp
from common.documents import json_reader, schema
from common.errors import InputError


def require_file(path, made_by):
    """`path` as a pathlib.Path; InputError that names the step `made_by` if there is no such file."""
    path = pathlib.Path(path)
    if not path.is_file():
        raise InputError("a file is missing", path, "no such file", f"run the step that writes it: {made_by}")
    return path


def read_json(path, made_by):
    """The JSON object in `path`. Raises InputError for a missing or malformed file, NaN and infinity."""
    return json_reader.read(require_file(path, made_by), made_by, f"repeat: {made_by}").data


def read_failed(path):
    """The list `failed` of failed.json, which `workflow failed` makes; empty if no path is given."""
    if not path:
        return []
    document = json_reader.Document(path, read_json(path, "workflow failed"))
    schema.validate(document, schema.read("failed"), "a list of failed steps", "repeat: workflow failed")
    return document.data["failed"]


def entry(document, keys, path):
    """document[k1][k2]... for keys "k1.k2"; InputError with the missing key. `path` is named in the message."""
    value = document
    for key in keys.split("."):
        if not isinstance(value, dict) or key not in value:
            raise InputError("a key is missing", path, keys, "repeat the step that writes the file; see docs/design.md")
        value = value[key]
    return value


def number(document, keys, path):
    """A finite float at `keys` of `document` (see entry); InputError otherwise."""
    value = entry(document, keys, path)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError("a finite number is expected", f"{path}: {keys}", value, "repeat the step that writes it")
    return float(value)


def read_table(path, numeric, text, made_by):
    """A CSV as a DataFrame with at least the columns `numeric` (finite floats) and `text`.

    Raises InputError for a missing file or column, an empty table, or a number that is missing, NaN or infinite.
    """
    path = require_file(path, made_by)
    try:
        table = pd.read_csv(
            path, dtype={name: str for name in text}, keep_default_na=False, float_precision="round_trip"
        )
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise InputError("a table cannot be read", path, str(error), f"repeat: {made_by}") from error
    for name in (*numeric, *text):
        if name not in table.columns:
            raise InputError("a column is missing", path, name, f"repeat: {made_by}; see docs/design.md")
    if table.empty:
        raise InputError("a table has no rows", path, 0, f"repeat: {made_by}")
    for name in numeric:
        values = pd.to_numeric(table[name], errors="coerce").to_numpy(float)
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            where = f"{path}: row {bad[0] + 2}, column {name}"
            raise InputError("a finite number is expected", where, table[name][bad[0]], f"repeat: {made_by}")
        table[name] = values
    return table


def read_polydata(path, made_by):
    """The vtkPolyData in a VTP file; InputError if it is missing or holds no point."""
    return vtp.read(path, f"run the step that writes it: {made_by}")


def read_array(attributes, name, path):
    """The numeric array `name` of vtkPointData or vtkCellData; InputError if it is not there."""
    array = attributes.GetArray(name)
    if array is None:
        raise InputError(
            "a VTK array is missing", path, name, "repeat the step that writes the file; see docs/design.md"
        )
    return np.array(vtk_to_numpy(array))
