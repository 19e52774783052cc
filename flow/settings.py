"""The settings of the flow step. Their names, defaults and ranges are in config/schemas/flow.schema.yaml."""

import argparse
import math
import pathlib
import types

import numpy as np

from common.documents import json_reader, schema, yaml_reader
from common.errors import InputError


def properties():
    """{name: JSON schema} of all settings, in the order of the schema file."""
    return schema.read("flow")["properties"]


def commands_of(name):
    """Names of the commands on which a setting has an effect."""
    return properties()[name]["x-commands"]


def option_name(name):
    """The command-line option of a setting."""
    return "--" + name.replace("_", "-")


def add_options(parser, command):
    """Adds --settings and one option for each setting of `command` to an argparse parser.

    An option overrides the file. All commands can share one settings file, so it may hold settings of other commands.
    """
    group = parser.add_argument_group("settings (config section `flow`)")
    group.add_argument("--settings", metavar="FILE.json", help="file with keys of the section, also of other commands")
    for name, rule in properties().items():
        if command in commands_of(name):
            kind = {"type": str if rule["type"] == "string" else _number, "help": schema.describe(rule)}
            several = {"nargs": "+"} if rule["type"] == "array" else {}
            group.add_argument(option_name(name), dest=name, default=argparse.SUPPRESS, **kind, **several)


def _number(text):
    """The finite number in a text, else the text itself: `make` then refuses it with the usual message."""
    for kind in (int, float):
        try:
            value = kind(text)
        except ValueError:
            continue
        return value if math.isfinite(value) else text
    return text


def check_unknown_arguments(command, words):
    """Raises InputError if one of `words`, arguments that a command did not know, is a setting of another command."""
    options = {option_name(name): name for name in properties()}
    for word in words:
        given = word.partition("=")[0]
        if given in options:
            owners = " or ".join(f"`flow {owner}`" for owner in commands_of(options[given]))
            raise InputError("setting that does not act here", f"flow {command}", given, f"give it to {owners}")


def from_arguments(arguments):
    """Namespace of all settings: those given as options, else those of the settings file, else the defaults.

    arguments: parsed arguments of the command. Raises InputError for a value that is not allowed, or an option that has
    no effect.
    """
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
    settings = make(**{**values, **given})
    check_switches(vars(settings), "flow settings", given)
    return settings


def make(**values):
    """Namespace of all settings: the given values, the other settings at their defaults. Raises InputError."""
    rules = schema.read("flow")
    schema.validate(json_reader.Document("flow settings", values), rules)
    return types.SimpleNamespace(**schema.with_defaults(values, rules))


def check_switches(values, where, given=()):
    """Raises InputError for a setting that has no effect because of the value of another one (`x-with` in the schema).

    values: {setting: value} of all settings. A setting counts as wished for if it differs from its default, or if its
    name is in `given`.
    """
    for name, rule in properties().items():
        for switch, needed in rule.get("x-with", {}).items():
            if values[switch] != needed and (name in given or values[name] != rule["default"]):
                what = f"setting that does not act while {switch} is {values[switch]}"
                remedy = f"set {switch} to {needed}, or leave {name} out (default {rule['default']})"
                raise InputError(what, f"{where}: {name}", values[name], remedy)


def check_meshes(values, where):
    """Raises InputError unless the settings make each mesh coarser than the next, as the error estimate needs it.

    values: {setting: value} of all settings.
    """
    for coarse, fine in (("coarse_rings", "rings"), ("coarse_cells_per_radius", "cells_per_radius")):
        sizes = [*np.atleast_1d(values[coarse]), values[fine]]
        if any(size >= finer for size, finer in zip(sizes, sizes[1:])):
            remedy = f"less than {fine}, which is {values[fine]}, the least first"
            raise InputError(
                "the coarse mesh is not coarser than the fine one", f"{where}: {coarse}", values[coarse], remedy
            )
