"""The engine's settings agree with the schema that describes and checks them."""

import json
import subprocess

import pytest
import yaml

LIMITS = ("type", "enum", "minimum", "maximum", "default")


@pytest.fixture(scope="module")
def table(binary):
    """Settings of the engine: {section: {key: {limit: value}}}, nested once more for plaque."""
    result = subprocess.run([str(binary("vci")), "settings", "--json"], capture_output=True, text=True, check=True)
    return json.loads(result.stdout)


def flat(entries, path=()):
    """{path: {limit: value}} of a table nested by sections."""
    settings = {}
    for key, entry in entries.items():
        if any(isinstance(value, dict) for value in entry.values()):
            settings |= flat(entry, (*path, key))
        else:
            settings[(*path, key)] = {limit: entry[limit] for limit in LIMITS if limit in entry}
    return settings


def described(schema):
    """The properties of a schema, nested by sections as the engine's table is."""
    return {
        key: described(entry) if entry.get("type") == "object" else entry for key, entry in schema["properties"].items()
    }


def test_schema_and_engine_agree_on_every_setting(table, repo_root):
    """Each key has the type, the choices, the limits and the default in the schema that the engine has."""
    schema = yaml.safe_load((repo_root / "config/schemas/deployment.schema.yaml").read_text())
    of_schema, of_engine = flat(described(schema)), flat(table)
    assert of_schema.keys() == of_engine.keys()
    assert {key: of_engine[key] for key in of_schema} == of_schema
    assert len(of_engine) > 40, "all settings are compared"


def test_limits_are_inside(table, repo_root):
    """The schema has no exclusive limit, because all limits of the engine are inclusive."""
    schema = (repo_root / "config/schemas/deployment.schema.yaml").read_text()
    assert "exclusive" not in schema


def row(path, entry):
    """The line of vci/settings.md that describes a setting as the schema has it."""
    default = "null" if entry["default"] is None else f"{entry['default']:g}"
    return f"| `{'.'.join(path)}` | {default} | {entry['minimum']:g} to {entry['maximum']:g} | {entry['description']} |"


def choice_row(path, entry):
    return f"| `{'.'.join(path)}` | {entry['default']} | {', '.join(entry['enum'])} | {entry['description']} |"


def test_the_page_of_settings_has_each_as_the_schema_does(repo_root):
    """vci/settings.md has one row a setting of wall and numerics, with default and limits, and no other."""
    schema = yaml.safe_load((repo_root / "config/schemas/deployment.schema.yaml").read_text())
    entries = flat_entries(described(schema))
    expected = [choice_row(*item) if "enum" in item[1] else row(*item) for item in entries.items()]
    page = (repo_root / "vci/settings.md").read_text().splitlines()
    assert [line for line in page if line.startswith(("| `wall.", "| `numerics."))] == expected
    assert len(expected) > 40, "all settings are on the page"


def flat_entries(entries, path=()):
    """{path: entry of the schema} of a table nested by sections."""
    settings = {}
    for key, entry in entries.items():
        nested = any(isinstance(value, dict) for value in entry.values())
        settings |= flat_entries(entry, (*path, key)) if nested else {(*path, key): entry}
    return settings
