"""The order of the rooms: which parts of the package may know which (docs/architecture.md)."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from pathlib import Path

import pytest

import grainfit
from tools.house import (
    FLOORS,
    OUTSIDE,
    PICTURE,
    ROOT,
    circles,
    drawing,
    imports,
    modules,
    room_of,
    upward_imports,
)
from tools.house_figures import ABILITIES, lines_of, old_lines


def test_every_room_has_a_floor() -> None:
    rooms = {room_of(module) for module in modules()}

    assert rooms == {room for rooms in FLOORS for room in rooms} | set(OUTSIDE)


def test_no_room_imports_one_that_is_not_below_it() -> None:
    assert list(map(str, upward_imports(imports()))) == []


def test_no_modules_import_each_other_in_a_circle() -> None:
    assert circles(imports()) == []


def test_an_upward_import_and_a_circle_are_seen(tmp_path: Path) -> None:
    package = tmp_path / "grainfit"
    for name, text in {
        "__init__.py": "",
        "problem.py": "def late():\n    from grainfit.solvers import base\n",
        "solvers/__init__.py": "",
        "solvers/base.py": "import grainfit.problem\n",
    }.items():
        path = package / name
        path.parent.mkdir(exist_ok=True, parents=True)
        path.write_text(text)
    found = imports(tmp_path)

    assert list(map(str, upward_imports(found))) == [
        "grainfit.problem (line 2) imports grainfit.solvers.base"
    ]
    assert circles(found) == [["grainfit.problem", "grainfit.solvers.base"]]


def _packages() -> list[str]:
    return [
        module.name
        for module in pkgutil.walk_packages(grainfit.__path__, "grainfit.")
        if module.ispkg
    ]


@pytest.mark.parametrize("package", ["grainfit", *_packages()])
def test_nothing_in_a_package_shadows_one_of_its_modules(package: str) -> None:
    loaded = importlib.import_module(package)
    for module in pkgutil.iter_modules(loaded.__path__):
        importlib.import_module(f"{package}.{module.name}")
        assert inspect.ismodule(getattr(loaded, module.name)), module.name


def test_the_picture_of_the_house_is_current() -> None:
    drawn = PICTURE.read_text(encoding="utf-8")
    assert drawn == drawing(), "run: python tools/house.py --draw"


def test_each_module_counts_once_among_old_lines_and_new_abilities() -> None:
    new = sum(lines_of(ROOT, globs) for _, globs in ABILITIES.values())
    whole = sum(len(path.read_text("utf-8").splitlines()) for path in modules().values())

    assert sum(old_lines(ROOT).values()) + new == whole
