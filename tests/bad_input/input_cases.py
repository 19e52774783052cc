"""Inputs by name. For each a function makes the input in an empty folder and returns the command to run on it."""

import pathlib

from places import build_folder

BUILD = build_folder()
PYTHON = "/usr/bin/python3"
INPUT_CASES = {}  # name: function(folder) -> command, a list


def input_case(name):
    """Decorator that registers a function as the maker of the input of this name; each name is used once."""

    def register(make):
        assert name not in INPUT_CASES, name
        INPUT_CASES[name] = make
        return make

    return register


def lumen(command, surface, *options):
    """`lumen check` or `lumen process` of a surface. Results of `process` would go to the folder out beside it."""
    out = ["--out", pathlib.Path(surface).parent / "out"] if command == "process" else []
    return [BUILD / "lumen", command, surface, *options, *out]


def module(part, *arguments):
    """`python3 -m part ...`."""
    return [PYTHON, "-m", part, *arguments]
