"""Strict YAML: duplicate keys and non-finite numbers are refused, 1e-3 is a number, and every value knows its line.

PyYAML follows YAML 1.1, where `1e-3` is a string, `no` is a boolean and the last of two equal keys wins silently;
a configuration that people write by hand needs none of these surprises.
"""

import math
import pathlib
import re

import yaml

from common.errors import InputError


class _Loader(yaml.SafeLoader):
    """SafeLoader with the numbers and booleans of YAML 1.2."""


_Loader.yaml_implicit_resolvers = {
    first: [
        (tag, pattern) for tag, pattern in resolvers if tag not in ("tag:yaml.org,2002:bool", "tag:yaml.org,2002:float")
    ]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver("tag:yaml.org,2002:bool", re.compile(r"^(true|false)$"), list("tf"))
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$|^[-+]?\.inf$|^\.nan$"),
    list("-+.0123456789"),
)


class Document:
    """A YAML file's content (`data`) with the place of each value.

    A value is addressed by its path, a tuple of keys and list positions, e.g. ("plan", 0, "devices").
    """

    def __init__(self, file, data, lines):
        self.file, self.data, self._lines = pathlib.Path(file), data, lines

    def line(self, path):
        """Line (from 1) of the value at `path`, or of its nearest ancestor that stands in the file."""
        path = tuple(path)
        while path not in self._lines:
            path = path[:-1]
        return self._lines[path]

    def where(self, path):
        """File, line and dotted key for an error message."""
        key = key_name(path)
        return f"{self.file}, line {self.line(path)}" + (f", key {key}" if key else "")


def key_name(path):
    """("plan", 0, "devices") -> "plan[1].devices"; list positions count from 1 as people do."""
    name = ""
    for part in path:
        name += f"[{part + 1}]" if isinstance(part, int) else f".{part}" if name else str(part)
    return name


def read(file):
    """Reads one YAML file into a `Document`.

    Raises InputError when the file is missing, is not YAML, repeats a key or holds a number that is not finite.
    """
    file = pathlib.Path(file)
    try:
        text = file.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(
            "configuration file cannot be read", file, error.strerror, "give an existing YAML file"
        ) from None
    except UnicodeDecodeError as error:
        raise InputError("configuration file is not UTF-8 text", file, error.reason, "save it as UTF-8") from None
    try:
        loader = _Loader(text)
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        where, remedy = f"{file}, line {line}", "remove it; the file may be another kind than text"
        raise InputError("character that YAML does not allow", where, f"#x{error.character:02x}", remedy) from None
    try:
        node = loader.get_single_node()
        lines = {(): 1}
        if node is not None:
            _check(node, (), file, lines)
        data = loader.construct_document(node) if node is not None else {}
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        remedy = "mend the line; indent with spaces and quote text that holds ': ' or ' #'"
        raise InputError("not valid YAML", f"{file}, line {line}", error.problem, remedy) from None
    finally:
        loader.dispose()
    document = Document(file, data, lines)
    _refuse_non_finite(document, data, ())
    return document


def _check(node, path, file, lines):
    """Records the line of every value below `node` and refuses repeated keys."""
    lines[path] = node.start_mark.line + 1
    if isinstance(node, yaml.SequenceNode):
        for position, child in enumerate(node.value):
            _check(child, path + (position,), file, lines)
    elif isinstance(node, yaml.MappingNode):
        for key_node, child in node.value:
            key = path + (key_node.value,)
            if key in lines:
                where = f"{file}, line {key_node.start_mark.line + 1}, key {key_name(key)}"
                raise InputError(
                    "key given twice", where, key_node.value, f"keep one; the first is on line {lines[key]}"
                )
            _check(child, key, file, lines)
            lines[key] = key_node.start_mark.line + 1


def _refuse_non_finite(document, value, path):
    children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, child in children:
        _refuse_non_finite(document, child, path + (key,))
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError("number is not finite", document.where(path), value, "give a finite number")
