"""JSON schemas for the configuration: reads them, fills in defaults, and says in plain words which value is wrong.

Schemas are JSON Schema (2020-12) written as YAML in config/schemas/. A `$ref` names another schema file, whose content
takes its place when the schema is read. `x-partial: true` marks a group of keys that override other settings. They are
checked, but none is required, and no default is filled in. `unit` gives the unit of a number whose name does not.
"""

import copy
import difflib
import functools
import pathlib
import re

import jsonschema

from common.documents import yaml_reader
from common.errors import InputError

# Schema of a forbidden key, in place of the plain `false`. For `false`, jsonschema 4.19 does not report the key.
FORBIDDEN_KEY = {"not": {}}

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "config" / "schemas"


@functools.lru_cache(maxsize=None)
def read(name):
    """The schema `config/schemas/<name>.schema.yaml`, its references expanded."""
    return _expand_references(yaml_reader.read(FOLDER / f"{name}.schema.yaml").data, partial=False)


def _expand_references(schema, partial):
    if isinstance(schema, list):
        return [_expand_references(item, partial) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if "$ref" in schema:
        other = read(schema["$ref"].removesuffix(".schema.yaml"))
        schema = {**other, **{key: value for key, value in schema.items() if key != "$ref"}}
    inside = partial or schema.get("x-partial") is True
    expanded = {}
    for key, value in schema.items():
        if partial and key in ("required", "default"):
            continue
        if key == "properties":  # here "default" or "required" would be the name of a setting
            expanded[key] = {
                name: FORBIDDEN_KEY if item is False else _expand_references(item, inside)
                for name, item in value.items()
            }
        else:
            expanded[key] = _expand_references(value, inside)
    return expanded


def validate(document, schema, kind="", remedy=""):
    """Raises InputError for the first value of `document` (in file order) that `schema` does not allow.

    kind: what the document should be, in words; the message then begins with `not {kind}`. remedy: what else the user
    can do, besides mending the value.
    """
    validator = jsonschema.Draft202012Validator(schema)
    errors = [_most_specific(error) for error in validator.iter_errors(document.data)]
    if errors:
        error = _input_error(document, min(errors, key=lambda error: _sort_key(document, error)))
        what = f"not {kind}: {error.what}" if kind else error.what
        raise InputError(what, error.where, error.value, "; ".join(filter(None, (error.remedy, remedy))))


def _sort_key(document, error):
    """Sort key: errors in the file's order. Within a line: a key not allowed there, then an unknown key, then others.

    An unknown key comes before a missing one, because it is often the missing key misspelt. A wrong `schema` comes
    first of all, because the document is of another kind.
    """
    rank = 0 if error.schema == FORBIDDEN_KEY else 1 if error.validator == "additionalProperties" else 2
    of_this_kind = list(error.absolute_path) != ["schema"]
    return of_this_kind, document.line(error.absolute_path), rank, str(error.message)


def with_defaults(data, schema):
    """A copy of `data` in which every missing key that has a default in `schema` is filled in."""
    data = copy.deepcopy(data)
    _fill_defaults(data, schema)
    return data


def _fill_defaults(data, schema):
    if isinstance(data, dict):
        for key, sub in schema.get("properties", {}).items():
            if key not in data and "default" in sub:
                data[key] = copy.deepcopy(sub["default"])
            if key in data:
                if sub.get("type") == "integer" and isinstance(data[key], float):
                    data[key] = int(data[key])  # JSON Schema accepts 24.0 as a whole number, range() does not
                _fill_defaults(data[key], sub)
    elif isinstance(data, list) and "items" in schema:
        if schema["items"].get("type") == "integer":
            data[:] = [int(item) if isinstance(item, float) else item for item in data]
        for item in data:
            _fill_defaults(item, schema["items"])
    for branch in schema.get("anyOf", ()):
        if jsonschema.Draft202012Validator({"type": branch.get("type", [])}).is_valid(data):
            _fill_defaults(data, branch)


def _most_specific(error):
    """The error to report for a jsonschema error, which may contain the errors of several alternatives (anyOf).

    If no alternative fits, the author probably meant the one that fits best, so its error is reported. But the value
    itself may be wrong in every alternative, by its type or range. Then the error of the anyOf is reported, which names
    them all.
    """
    while any(
        inner.absolute_path != error.absolute_path or inner.validator not in _WHOLE_VALUE_RULES
        for inner in error.context
    ):
        error = max(
            error.context, key=lambda inner: (len(inner.absolute_path), inner.validator not in ("type", "const"))
        )
    return error


def _input_error(document, error):
    """One jsonschema error as an InputError: file, line, key, value and the allowed values."""
    path, value, rule = list(error.absolute_path), error.instance, error.validator_value
    allowed = describe(error.schema) if isinstance(error.schema, dict) else ""
    if error.validator == "additionalProperties":
        known = sorted(error.schema.get("properties", {}))
        key = next(key for key in value if key not in known)
        similar = difflib.get_close_matches(str(key), known, n=1, cutoff=0.5)
        remedy = (f"did you mean {similar[0]}? " if similar else "") + f"known keys here: {', '.join(known)}"
        return InputError("unknown key", document.where(path + [key]), _shortened(value[key]), remedy)
    if error.validator == "required":
        missing = next(key for key in rule if key not in value)
        missing_schema = error.schema.get("properties", {}).get(missing, {})
        where = document.where(path) + (": " if path else ", ") + f"key {missing} is missing"
        remedy = (
            f"add {missing}: {describe(missing_schema)}"
            if isinstance(missing_schema, dict) and missing_schema
            else f"add {missing}"
        )
        return InputError("key is missing", where, "none", remedy)
    if error.schema == FORBIDDEN_KEY:
        return InputError("key has no place here", document.where(path), _shortened(value), "remove it")
    return InputError("value is not allowed", document.where(path), _shortened(value), f"allowed: {allowed}")


def describe(schema):
    """The values that a schema allows, in words: type, range, unit, choices, default and description."""
    words = []
    if "enum" in schema:
        words.append("one of " + ", ".join(map(str, schema["enum"])))
    elif "const" in schema:
        words.append(str(schema["const"]))
    elif "anyOf" in schema:
        words.append(" or ".join(describe(branch) for branch in schema["anyOf"]))
    elif "type" in schema:
        types = [schema["type"]] if isinstance(schema["type"], str) else schema["type"]
        words.append(" or ".join(_TYPES.get(name, name) for name in types))
    limits = {key: schema[key] for key in _LIMITS if key in schema}
    if "minItems" in limits and limits["minItems"] == limits.get("maxItems"):
        words.append(f"of {limits.pop('minItems')} entries")
        del limits["maxItems"]
    words += [_LIMITS[key].format(limit) for key, limit in limits.items()]
    if "items" in schema and schema["items"].get("type") in ("number", "integer"):
        words.append("each " + describe(schema["items"]))
    if schema.get("unit", "1") not in ("1", 1):
        words.append(f"in {schema['unit']}")
    if "default" in schema and not isinstance(schema["default"], (dict, list)):
        words.append(f"(default {schema['default']})")
    text = " ".join(words)
    return (
        f"{text}: {schema['description']}"
        if "description" in schema and text
        else text or schema.get("description", "")
    )


_NUMBER = re.compile(r"\s*[-+]?[.\d]")
_WHOLE_VALUE_RULES = (
    "type",
    "const",
    "enum",
    "minimum",
    "exclusiveMinimum",
    "maximum",
    "exclusiveMaximum",
)  # rules about a value itself, not about the keys or entries in it
_TYPES = {
    "number": "a number",
    "integer": "a whole number",
    "string": "text",
    "boolean": "true or false",
    "array": "a list",
    "object": "a group of keys",
}
_LIMITS = {
    "minimum": "at least {}",
    "exclusiveMinimum": "above {}",
    "maximum": "at most {}",
    "exclusiveMaximum": "below {}",
    "minItems": "with at least {} entries",
    "maxItems": "with at most {} entries",
    "minLength": "of at least {} characters",
    "pattern": "that matches {}",
    "multipleOf": "in multiples of {}",
}


def _shortened(value):
    """A value for a message, cut if it is long. A number in quotes keeps the quotes, since they are the mistake."""
    text = repr(value) if isinstance(value, str) and _NUMBER.match(value) else str(value)
    return text if len(text) <= 80 else text[:77] + "..."
