"""The directive {schema}: the keys of a schema of config/schemas as a table, for the page settings.md of the site."""

import re

from docutils import nodes
from docutils.parsers.rst import Directive
from docutils.statemachine import StringList

from common.documents import schema

HEADINGS = ("key", "value", "default", "meaning")


class SchemaTable(Directive):
    """Table of the schema that is named, one row a key; keys of groups are joined by a point."""

    required_arguments = 1

    def run(self):
        found = schema.read(self.arguments[0])
        rows = list(_rows(found))
        rule = ["---"] * len(HEADINGS)
        lines = ["| " + " | ".join(_cell(text) for text in row) + " |" for row in (HEADINGS, rule, *rows)]
        title = found.get("description", "")
        source = StringList([_sentence(title), "", *lines], source=f"{self.arguments[0]}.schema.yaml")
        node = nodes.container()
        self.state.nested_parse(source, self.content_offset, node)
        return node.children


def _rows(found, prefix=""):
    required = found.get("required", ())
    for key, inner in found.get("properties", {}).items():
        name = prefix + key
        if inner is False:
            continue
        yield f"`{name}`", _value(inner), _default(inner, key in required), inner.get("description", "")
        yield from _rows(inner, name + ".")
        if isinstance(inner.get("items"), dict):
            yield from _rows(inner["items"], name + "[].")


def _value(inner):
    """The values that a key may have, in words; both ends of a range together."""
    low, high = inner.get("minimum"), inner.get("maximum")
    left_out = {"description", "default"} | ({"minimum", "maximum"} if None not in (low, high) else set())
    words = schema.describe({key: value for key, value in inner.items() if key not in left_out})
    return words if None in (low, high) else f"{words}, {low} to {high}"


def _default(inner, required):
    if required:
        return "required"
    if "default" not in inner or isinstance(inner["default"], dict):
        return ""
    return str(inner["default"])


def _sentence(text):
    return f"{text[:1].upper()}{text[1:]}."


def _cell(text):
    return re.sub(r"([|<>*])", r"\\\1", str(text))


def setup(app):
    """Called by Sphinx."""
    app.add_directive("schema", SchemaTable)
    return {"parallel_read_safe": True}
