"""The engine's settings and the schema that describes and checks them say the same."""

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
    """Every limit of the schema is a limit: none is exclusive, which the engine's numbers are not."""
    schema = (repo_root / "config/schemas/deployment.schema.yaml").read_text()
    assert "exclusive" not in schema
