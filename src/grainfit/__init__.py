"""Calibrates the material parameters of discrete element (DEM) models of bulk solids.

The stub beside this file lists the public names.
"""

from typing import Any

from grainfit.lazy import public_names

_imported, __dir__, __all__ = public_names(__name__, __file__)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("grainfit")
    return _imported(name)
