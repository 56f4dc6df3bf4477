"""Names that modules of the standard library have on a system, according to their type stubs."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace


def folder_of(package: str) -> str:
    """Return the folder of a package, without importing it."""
    found = find_spec(package)
    places = None if found is None else found.submodule_search_locations
    assert places, f"{package} is not installed"
    return places[0]


def missing_on(system: str, module: str) -> set[str]:
    """Return the names that a module has on Linux, but not on a system: win32 or darwin."""
    return _names_on("linux", module) - _names_on(system, module)


def _names_on(system: str, module: str) -> set[str]:
    stubs = Path(folder_of("mypy"), "typeshed", "stdlib")
    (stub,) = (
        path
        for path in (stubs / f"{module}.pyi", stubs / module / "__init__.pyi")
        if path.is_file()
    )
    about = {"sys": SimpleNamespace(platform=system, version_info=sys.version_info)}

    def bound(body: list[ast.stmt]) -> Iterator[str]:
        for node in body:
            if isinstance(node, ast.If):
                holds = eval(ast.unparse(node.test), {**about, "TYPE_CHECKING": True})
                yield from bound(node.body if holds else node.orelse)
            elif isinstance(node, ast.FunctionDef | ast.ClassDef):
                yield node.name
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                yield node.target.id

    return set(bound(ast.parse(stub.read_text(encoding="utf-8")).body))
