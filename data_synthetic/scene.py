"""Reads the keys of a scene that data_synthetic needs: devices, and the steps that use them."""

import pathlib

from common.documents import config
from common.errors import InputError


def load(path):
    """The scene (dict) at `path`, plan.json or scene.json. Raises InputError if it is not one."""
    path = pathlib.Path(path)
    if not path.is_file():
        raise InputError("no such file", path, "missing", "write the scene with the planning command")
    return config.load(path, "reference_scene")
