"""Schemas: references, partial trees, defaults, and complaints in plain words."""

import jsonschema
import pytest

from common.documents import schema, yaml_reader
from common.errors import InputError

RULES = {
    "type": "object",
    "additionalProperties": False,
    "required": ["size_mm"],
    "properties": {
        "size_mm": {"type": "number", "minimum": 1, "maximum": 8, "unit": "mm", "description": "a size"},
        "kind": {"enum": ["soft", "hard"], "default": "soft"},
        "group": {
            "type": "object",
            "additionalProperties": False,
            "default": {},
            "properties": {"depth": {"type": "integer", "exclusiveMinimum": 0, "default": 3, "unit": "1"}},
        },
        "steps": {
            "anyOf": [
                {"const": "auto"},
                {"type": "array", "items": {"type": "object", "properties": {"branch": {"default": "main"}}}},
            ]
        },
    },
}


def document(data):
    return yaml_reader.Document("a.yaml", data, {(): 1})


def refusal_text(data):
    with pytest.raises(InputError) as error:
        schema.validate(document(data), RULES)
    return str(error.value)


def test_defaults_are_filled_in_at_every_depth():
    filled = schema.with_defaults({"size_mm": 2, "steps": [{}]}, RULES)
    assert filled == {"size_mm": 2, "kind": "soft", "group": {"depth": 3}, "steps": [{"branch": "main"}]}


def test_defaults_do_not_touch_what_is_given_nor_the_schema():
    given = {"size_mm": 2, "group": {}}
    schema.with_defaults(given, RULES)["group"]["depth"] = 99
    assert given == {"size_mm": 2, "group": {}}
    assert schema.with_defaults(given, RULES)["group"] == {"depth": 3}


def test_valid_document_passes():
    schema.validate(document({"size_mm": 2.5, "kind": "hard", "group": {"depth": 1}, "steps": "auto"}), RULES)


@pytest.mark.parametrize(
    "data, words",
    [
        ({"size_mm": 9}, ["key size_mm", "value:  9", "a number at least 1 at most 8 in mm: a size"]),
        ({"size_mm": "big"}, ["key size_mm", "big", "a number"]),
        ({"size_mm": True}, ["key size_mm", "True"]),
        ({"size_mm": 2, "kind": "medium"}, ["one of soft, hard"]),
        ({"size_mm": 2, "group": {"depht": 2}}, ["key group.depht", "did you mean depth?"]),
        ({"size_mm": 2, "group": {"depth": 0}}, ["key group.depth", "above 0 (default 3)"]),
        ({"size_mm": "2.5"}, ["key size_mm", "value:  '2.5'", "a number"]),
        ({"size_mm": 2, "steps": "never"}, ["key steps", "never", "auto or a list"]),
        ({"size_mm": 2, "steps": None}, ["key steps", "None", "auto or a list"]),
        ({"size_mm": 2, "steps": ["stent"]}, ["key steps[1]", "stent", "a group of keys"]),
        ({"kind": "soft"}, ["key size_mm is missing", "a size"]),
        ({"size": 2}, ["unknown key", "key size", "did you mean size_mm?"]),
    ],
)
def test_refused_in_plain_words(data, words):
    text = refusal_text(data)
    for word in words:
        assert word in text, text


def test_the_kind_of_document_is_named_first_and_the_remedy_last():
    rules = {"required": ["schema", "names"], "properties": {"schema": {"const": "a-1"}, "names": {"type": "array"}}}
    schema.validate(document({"schema": "a-1", "names": []}), rules, "a list of names", "write it anew")
    for data, what, remedy in (
        ({"schema": "b-1"}, "value is not allowed", "allowed: a-1; write it anew"),
        ({"names": 3}, "key is missing", "add schema: a-1; write it anew"),
    ):
        with pytest.raises(InputError) as caught:
            schema.validate(document(data), rules, "a list of names", "write it anew")
        assert (caught.value.what, caught.value.remedy) == (f"not a list of names: {what}", remedy)


@pytest.mark.parametrize(
    "rules, words",
    [
        (
            {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}},
            "a list of 3 entries each a number",
        ),
        ({"type": "array", "minItems": 1, "maxItems": 3}, "a list with at least 1 entries with at most 3 entries"),
        ({"type": ["string", "null"]}, "text or null"),
        ({"type": "integer", "minimum": 0}, "a whole number at least 0"),
    ],
)
def test_allowed_values_in_words(rules, words):
    assert schema.describe(rules) == words


def test_partial_tree_requires_nothing_and_fills_in_nothing():
    settings = schema.read("case")["properties"]["settings"]
    assert schema.with_defaults({"flow": {}}, settings) == {"flow": {}}
    with pytest.raises(InputError, match="unknown key"):
        schema.validate(document({"flow": {"viscosity": 1}}), settings)


@pytest.mark.parametrize("file", sorted(schema.FOLDER.glob("*.schema.yaml")), ids=lambda file: file.name)
def test_shipped_schemas_are_valid_and_describe_every_key(file):
    rules = schema.read(file.name.removesuffix(".schema.yaml"))
    jsonschema.Draft202012Validator.check_schema(rules)
    undescribed, cut = [], []

    def visit(rule, name):
        # In YAML's short form an unquoted comma ends a description, and what follows becomes a key without a value.
        cut.extend(f"{name}: {key}" for key, value in rule.items() if value is None and key not in ("default", "const"))
        for key, sub in rule.get("properties", {}).items():
            if isinstance(sub, dict):
                if not (sub.get("description") or "const" in sub):
                    undescribed.append(f"{name}.{key}")
                visit(sub, f"{name}.{key}")
        if isinstance(rule.get("items"), dict):
            visit(rule["items"], name + "[]")

    visit(rules, file.name)
    assert undescribed == [] and cut == []


@pytest.mark.parametrize("section", ["anatomy", "deployment", "flow", "reference", "metrics"])
def test_every_setting_has_a_default_that_it_allows(section):
    rules = schema.read(section)
    schema.validate(document(schema.with_defaults({}, rules)), rules)

    def visit(rule, name):
        for key, sub in rule["properties"].items():
            assert "default" in sub, f"{name}.{key} has no default"
            if "properties" in sub:
                assert sub["additionalProperties"] is False
                visit(sub, f"{name}.{key}")

    visit(rules, section)


def test_whole_numbers_with_a_point_are_whole_in_lists_too():
    rules = {"properties": {"rings": {"type": "array", "items": {"type": "integer"}}}}
    (first, second) = schema.with_defaults({"rings": [2.0, 3]}, rules)["rings"]
    assert (type(first), first, second) == (int, 2, 3)
