"""Files are written whole or not at all: under a temporary name first, then moved into place."""

import contextlib
import hashlib
import json
import os
import pathlib

from common.errors import InputError


@contextlib.contextmanager
def replacing(path):
    """Yields a temporary path (same folder, same suffix) that becomes `path` if the block succeeds.

    The temporary file is removed if the block raises. Raises InputError if the folder cannot be made.
    """
    path = pathlib.Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("no folder can be made here", path.parent, error.strerror, "another folder") from error
    if path.is_dir():
        raise InputError("a file cannot replace a folder", path, "a folder", "another name")
    partial = path.with_name(f".partial-{os.getpid()}-{path.name}")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def write_json(path, document):
    """Writes `document` as indented JSON; NaN and infinity are refused (ValueError)."""
    with replacing(path) as partial:
        partial.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n")


def write_table(path, table, digits=6):
    """Writes a DataFrame as CSV without its index; a missing value becomes an empty field.

    digits: significant digits of the numbers; with None, as many as are needed to read the same number again.
    """
    with replacing(path) as partial:
        table.to_csv(partial, index=False, float_format=None if digits is None else f"%.{digits}g", lineterminator="\n")


def sha256(path):
    """SHA-256 of a file's content, in hexadecimal."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
