"""Strict JSON: numbers that are not finite are refused. documents.schema can check the documents read here."""

import json
import math
import pathlib

from common.errors import InputError
from common.documents.yaml_reader import key_name


class Document:
    """Content (`data`) of a JSON file, read or not yet written.

    A value is addressed by its path, a tuple of keys and list positions, e.g. ("plan", 0, "devices").
    """

    def __init__(self, file, data):
        self.file, self.data = file, data

    def line(self, path):
        """Rank of the value at `path` in the file's order, in place of a line. documents.schema sorts errors by it."""
        return next(number for number, (place, _) in enumerate(_walk(self.data, ())) if place == tuple(path))

    def where(self, path):
        """File and dotted key of the value at `path`, for an error message."""
        key = key_name(path)
        return f"{self.file}, key {key}" if key else str(self.file)

    def check_finite(self, remedy="give a finite number"):
        """Raises InputError for the first number that is not finite, since no limit of a schema catches NaN."""
        for path, value in _walk(self.data, ()):
            if isinstance(value, float) and not math.isfinite(value):
                raise InputError("number is not finite", self.where(path), value, remedy)


def read(file, kind, remedy=None):
    """Reads one JSON file into a Document.

    kind: the expected file in words, say plan.json. remedy: advice for the error messages; by default, to give a file
    of that kind. Raises InputError when the file cannot be read, is not JSON, is no group of keys or has a number that
    is not finite.
    """
    file, finite_remedy = pathlib.Path(file), remedy or "give a finite number"
    remedy = remedy or f"give a file of the kind {kind}"
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        what = "no such file" if isinstance(error, FileNotFoundError) else "file cannot be read"
        raise InputError(what, file, error.strerror, remedy) from None
    except (ValueError, RecursionError) as error:  # bad JSON or UTF-8, a number too long, or nesting too deep
        raise InputError("not a JSON file", file, error, remedy) from None
    document = Document(file, data)
    if not isinstance(data, dict):
        raise InputError("not a group of keys", file, str(data)[:80], remedy)
    document.check_finite(finite_remedy)
    return document


def _walk(value, path):
    """Yields (path, value) of `value` itself and of every value inside it, in the file's order."""
    pending = [(path, value)]  # no recursion: JSON may be nested nearly to Python's recursion limit
    while pending:
        path, value = pending.pop()
        yield path, value
        children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        pending += [(path + (key,), child) for key, child in children][::-1]
