"""The settings of the flow step: names, defaults and ranges are those of config/schemas/flow.schema.yaml."""

import argparse
import math
import pathlib
import types

import numpy as np

from common.documents import json_reader, schema, yaml_reader
from common.errors import InputError


def properties():
    """{name: JSON schema of the setting} in the schema's order."""
    return schema.read("flow")["properties"]


def commands_of(name):
    """Names of the commands that a setting acts in."""
    return properties()[name]["x-commands"]


def option(name):
    """The option of a setting on the command line."""
    return "--" + name.replace("_", "-")


def add_options(parser, command):
    """Adds --settings and one option a setting of `command` to an argparse parser; options win over the file.

    The file is shared by the commands: it may hold all keys.
    """
    group = parser.add_argument_group("settings (config section `flow`)")
    group.add_argument("--settings", metavar="FILE.json", help="file with keys of the section, also of other commands")
    for name, rule in properties().items():
        if command in commands_of(name):
            kind = {"type": str if rule["type"] == "string" else _number, "help": schema.describe(rule)}
            several = {"nargs": "+"} if rule["type"] == "array" else {}
            group.add_argument(option(name), dest=name, default=argparse.SUPPRESS, **kind, **several)


def _number(text):
    """The number in a text, else the text itself, since `make` refuses wrong kinds and ranges with one message."""
    for kind in (int, float):
        try:
            value = kind(text)
        except ValueError:
            continue
        return value if math.isfinite(value) else text
    return text


def check_left(command, words):
    """Raises InputError for the first of the words that a command did not know which is another command's setting."""
    options = {option(name): name for name in properties()}
    for word in words:
        given = word.partition("=")[0]
        if given in options:
            owners = " or ".join(f"`flow {owner}`" for owner in commands_of(options[given]))
            raise InputError("setting that does not act here", f"flow {command}", given, f"give it to {owners}")


def from_arguments(arguments):
    """The settings of parsed arguments as a namespace. Raises InputError for a value that is not allowed."""
    path = getattr(arguments, "settings", None)
    values = {}
    if path:
        if not pathlib.Path(path).is_file():
            raise InputError("no such settings file", path, "missing", "give a JSON file with keys of section flow")
        values = yaml_reader.read(path).data
        if not isinstance(values, dict):
            raise InputError("not a group of keys", path, values, "give a JSON file with keys of section flow")
        values = dict(values)
    given = {name: getattr(arguments, name) for name in properties() if hasattr(arguments, name)}
    made = make(**{**values, **given})
    check_switches(vars(made), "flow settings", given)
    return made


def make(**values):
    """Settings namespace from keyword values; the rest are defaults. Raises InputError."""
    rules = schema.read("flow")
    schema.validate(json_reader.Document("flow settings", values), rules)
    return types.SimpleNamespace(**schema.with_defaults(values, rules))


def check_switches(values, where, given=()):
    """Raises InputError for a setting that another one (`x-with` of the schema) keeps from acting.

    values: {setting: value}, complete; those at their defaults were not wished for, but for the names in `given`.
    """
    for name, rule in properties().items():
        for switch, needed in rule.get("x-with", {}).items():
            if values[switch] != needed and (name in given or values[name] != rule["default"]):
                what = f"setting that does not act while {switch} is {values[switch]}"
                remedy = f"set {switch} to {needed}, or leave {name} out (default {rule['default']})"
                raise InputError(what, f"{where}: {name}", values[name], remedy)


def check_meshes(values, where):
    """Raises InputError unless each mesh is coarser than the next: the error estimate by two meshes rests on it.

    values: {setting: value}, complete.
    """
    for coarse, fine in (("coarse_rings", "rings"), ("coarse_cells_per_radius", "cells_per_radius")):
        sizes = [*np.atleast_1d(values[coarse]), values[fine]]
        if any(size >= finer for size, finer in zip(sizes, sizes[1:])):
            remedy = f"less than {fine}, which is {values[fine]}, the least first"
            raise InputError(
                "the coarse mesh is not coarser than the fine one", f"{where}: {coarse}", values[coarse], remedy
            )
