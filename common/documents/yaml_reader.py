"""Strict YAML: duplicate keys and non-finite numbers are refused, 1e-3 is a number, and every value knows its line.

PyYAML follows YAML 1.1. There `1e-3` is a string, `no` is a boolean, `2:10` is 130 and `0130` is 88. The last of two
equal keys wins silently. A configuration that people write by hand needs none of these surprises. Here plain values are
those of YAML 1.2's core schema (https://yaml.org/spec/1.2.2/#103-core-schema). Anchors, aliases and merge keys work.
"""

import math
import pathlib
import re

import yaml

from common.errors import InputError


MOST_VALUES = 100_000  # most values in a file; a study's have some hundreds, nested aliases can expand to billions
LONGEST_NUMBER = 300  # most characters of a whole number; a longer one might not be finite as a float
TAG_PREFIX = "tag:yaml.org,2002:"
# The kinds of plain value in YAML 1.2: {kind: (pattern of its text, characters that the text may begin with)}
PLAIN_SCALARS = {
    "null": (r"^(~|null|Null|NULL|)$", ["~", "n", "N", ""]),
    "bool": (r"^(true|false)$", list("tf")),
    "int": (r"^([-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+)$", list("-+0123456789")),
    "float": (
        r"^[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$|^[-+]?\.inf$|^\.nan$",
        list("-+.0123456789"),
    ),
    "merge": (r"^<<$", ["<"]),
}
CORE_TAGS = {TAG_PREFIX + name for name in (*PLAIN_SCALARS, "str", "seq", "map")}


class _Loader(yaml.SafeLoader):
    """SafeLoader with the plain values of YAML 1.2."""

    yaml_implicit_resolvers = {}

    def construct_integer(self, node):
        """The integer of a scalar node: octal after 0o, hexadecimal after 0x, else decimal, even with leading zeros."""
        text = self.construct_scalar(node)
        return int(text, 0) if text[:2] in ("0o", "0x") else int(text)


for _name, (_pattern, _first) in PLAIN_SCALARS.items():
    _Loader.add_implicit_resolver(TAG_PREFIX + _name, re.compile(_pattern), _first)
_Loader.add_constructor(TAG_PREFIX + "int", _Loader.construct_integer)


class Document:
    """A YAML file's content (`data`) with the place of each value.

    A value is addressed by its path, a tuple of keys and list positions, e.g. ("plan", 0, "devices").
    """

    def __init__(self, file, data, lines):
        self.file, self.data, self._lines = pathlib.Path(file), data, lines

    def line(self, path):
        """Line (from 1) of the value at `path`, or of its nearest ancestor in the file."""
        path = tuple(path)
        while path not in self._lines:
            path = path[:-1]
        return self._lines[path]

    def where(self, path):
        """File, line and dotted key of the value at `path`, for an error message."""
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

    Raises InputError when the file is missing, is not YAML or repeats a key. Four more things are refused: a number
    that is not finite, a tag outside YAML's core schema, a key that is not text, and more than MOST_VALUES values.
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
            _check_node(loader, node, (), file, lines)
        data = loader.construct_document(node) if node is not None else {}
    except RecursionError:
        remedy = "write the values out; no alias (*) within its own anchor (&)"
        raise InputError("nested too deeply, or within itself", file, "too many levels", remedy) from None
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        remedy = "mend the line; indent with spaces and quote text that holds ': ' or ' #'"
        raise InputError("not valid YAML", f"{file}, line {line}", error.problem, remedy) from None
    finally:
        loader.dispose()
    document = Document(file, data, lines)
    _refuse_non_finite(document, data, ())
    return document


def _check_node(loader, node, path, file, lines):
    """Records the line of every value below `node`; refuses values outside the core schema and repeated keys."""
    line = node.start_mark.line + 1
    where = f"{file}, line {line}" + (f", key {key_name(path)}" if path else "")
    lines[path] = line
    if len(lines) > MOST_VALUES:
        remedy = "write them out; aliases (*) of lists that hold aliases multiply"
        raise InputError("too many values", where, f"more than {MOST_VALUES}", remedy)
    if node.tag not in CORE_TAGS:
        remedy = "leave the tag out: text, numbers, true, false, null, lists and groups of keys need none"
        raise InputError("tag that a configuration does not have", where, node.tag.replace(TAG_PREFIX, "!!"), remedy)
    if isinstance(node, yaml.SequenceNode):
        for position, child in enumerate(node.value):
            _check_node(loader, child, path + (position,), file, lines)
    elif isinstance(node, yaml.MappingNode):
        for key_node, child in node.value:
            if key_node.tag not in (TAG_PREFIX + "str", TAG_PREFIX + "merge"):
                where = f"{file}, line {key_node.start_mark.line + 1}" + (f", in {key_name(path)}" if path else "")
                value = key_node.value if isinstance(key_node, yaml.ScalarNode) else "a list or a group of keys"
                remedy = "keys are words; a decimal comma parts two entries: write a point"
                raise InputError("key that is no word", where, value, remedy)
            key = path + (key_node.value,)
            if key in lines:
                where = f"{file}, line {key_node.start_mark.line + 1}, key {key_name(key)}"
                raise InputError(
                    "key given twice", where, key_node.value, f"keep one; the first is on line {lines[key]}"
                )
            _check_node(loader, child, key, file, lines)
            lines[key] = key_node.start_mark.line + 1
    else:
        _check_scalar(loader, node, where)


def _check_scalar(loader, node, where):
    """Refuses a scalar that its tag does not fit, a whole number that is too long, and half a surrogate pair."""
    plain = loader.resolve(yaml.ScalarNode, node.value, (True, False))
    if node.tag not in (TAG_PREFIX + "str", plain):
        value = f"{node.tag.replace(TAG_PREFIX, '!!')} {node.value}"
        raise InputError("value that its tag does not fit", where, value, "leave the tag out")
    if node.tag == TAG_PREFIX + "int" and len(node.value) > LONGEST_NUMBER:
        value = node.value[:20] + "..."
        raise InputError("number of too many digits", where, value, f"at most {LONGEST_NUMBER} characters")
    try:
        node.value.encode()
    except UnicodeEncodeError as error:
        value = f"#x{ord(node.value[error.start]):04x}"
        raise InputError("half a character (a surrogate)", where, value, "write the character itself") from None


def _refuse_non_finite(document, value, path):
    children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, child in children:
        _refuse_non_finite(document, child, path + (key,))
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError("number is not finite", document.where(path), value, "give a finite number")
