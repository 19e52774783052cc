"""The deployment engine in Python: balloons and stents in a lumen, on numpy arrays.

    import vci
    lumen = vci.Lumen.read("lumen.vtp", "centreline.vtp")
    result = vci.deploy(lumen, devices, steps)

docs/python.md has examples. The names in __all__ come from the compiled module vci._engine. This module is loaded when
a name is first used, so that the benchmarks in vci/benchmarks run without it.
"""

import importlib
import pkgutil

__all__ = ["ComputationError", "Deployment", "Device", "InputError", "Lumen", "Result", "deploy", "radius_correct"]

# In a clone the compiled module is not in this folder but in build/python/vci, whose parent is on PYTHONPATH.
__path__ = pkgutil.extend_path(__path__, __name__)


def __getattr__(name):
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        engine = importlib.import_module("vci._engine")
    except ModuleNotFoundError as error:
        remedy = "run `make build` and set PYTHONPATH=build/python, or use an installation (vci/library.md)"
        raise ImportError(f"the compiled module vci._engine is not found: {remedy}") from error
    return getattr(engine, name)
