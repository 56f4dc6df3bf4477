"""Public names of a package, imported when they are first used.

The stub ``__init__.pyi`` of a package is the only table of its names: type checkers read it, and so
does this module. The command line does without most of the package, and SciPy takes a second.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def public_names(
    package: str, file: str
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a package.

    Parameters
    ----------
    package : str
        Name of the package.
    file : str
        Its file, beside which the stub is.
    """
    homes = _homes(Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        home, own_name = homes[name]
        if home == package:
            return import_module(f"{package}.{own_name}")
        return getattr(import_module(home), own_name)

    names = sorted(homes)
    return get, lambda: names.copy(), names


def _homes(stub: str) -> dict[str, tuple[str, str]]:
    """Return module and name there by public name: ``import name as name``, or ``other = name``."""
    imported, public = {}, {}
    for node in ast.parse(stub).body:
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                imported[alias.name] = (str(node.module), alias.name)
                if alias.asname is not None:
                    public[alias.asname] = imported[alias.name]
        elif isinstance(node, ast.Assign):
            public[ast.unparse(node.targets[0])] = imported[ast.unparse(node.value)]
    return public
