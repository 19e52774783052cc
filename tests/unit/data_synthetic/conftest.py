import importlib.util
import pathlib

import pytest

_spec = importlib.util.spec_from_file_location("vessels", pathlib.Path(__file__).with_name("vessels.py"))
_vessels = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_vessels)


@pytest.fixture(scope="session")
def vessel():
    """vessel(**changes) -> description of a small vessel, with the schema's defaults filled in."""
    return _vessels.vessel


@pytest.fixture(scope="session")
def branches():
    """The branches that data_synthetic grows for the small vessel."""
    from data_synthetic import tree

    return tree.grow(_vessels.vessel())


def _module(name):
    spec = importlib.util.spec_from_file_location(name, pathlib.Path(__file__).with_name(f"{name}.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def ct_tubes():
    """The module ct_tubes, which makes straight tubes for the CT tests."""
    return _module("ct_tubes")
