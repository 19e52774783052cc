"""Fixtures of the flow tests."""

import sys
import pathlib

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from flow import settings as settings_module  # noqa: E402


@pytest.fixture
def settings():
    """The flow's settings with their defaults."""
    return settings_module.make()
