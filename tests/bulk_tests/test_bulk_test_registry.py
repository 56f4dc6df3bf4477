"""Bulk tests of other packages: found by their entry point, wherever tests are named."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import ClassVar

import pytest

import grainfit as gf
from grainfit.bulk_tests import registry
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.heap import Heap
from grainfit.calibration_file.build import build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.schema import calibration_file_schema
from grainfit.errors import InputError
from grainfit.run_definition import RunDefinition
from grainfit.solvers.registry import types_of_test

EXAMPLES = Path(__file__).parents[2] / "examples"
GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")


class SlowHeap(Heap):
    """A heap test of another package."""

    type: ClassVar[str] = "slow_heap"


class Unfinished(BulkTest):
    """A test of another package that lacks nearly everything."""

    type: ClassVar[str] = "other"


def _clear() -> None:
    registry.bulk_tests.cache_clear()
    types_of_test.cache_clear()


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch) -> Iterator[object]:
    """Give a function that provides an entry point."""

    def install(name: str, value: str) -> None:
        point = EntryPoint(name, value, registry.ENTRY_POINTS)
        monkeypatch.setattr(
            registry, "entry_points", lambda group: [point] if group == point.group else []
        )
        _clear()

    yield install
    monkeypatch.undo()
    _clear()


def test_it_can_be_used_in_a_calibration_file_and_in_python(install, tmp_path: Path) -> None:
    install("slow_heap", f"{__name__}:SlowHeap")
    path = tmp_path / "calibration.toml"
    path.write_text(GLASS_BEADS.replace('type = "heap"', 'type = "slow_heap"\nviews = 6'))
    setup = build_calibration(load_calibration_file(path))
    middle = {parameter.name: parameter.minimum for parameter in setup.problem.parameters}
    definition = setup.solvers["slow_heap"].definition(middle, 1)

    assert definition.model["test"]["type"] == "slow_heap"
    assert definition.model["test"]["views"] == 6
    assert isinstance(registry.recreate_test(definition), SlowHeap)
    assert gf.tests.SlowHeap is SlowHeap
    # What is published does not depend on what is installed.
    assert "slow_heap" not in str(calibration_file_schema())


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("no_such_package:Test", "no_such_package:Test cannot be loaded: ModuleNotFoundError"),
        ("pathlib:Path", "pathlib:Path is not a BulkTest whose type is 'other'"),
        (f"{__name__}:Unfinished", "is incomplete: title is missing, responses is missing, "),
        (f"{__name__}:SlowHeap", "is not a BulkTest whose type is 'other'"),
    ],
)
def test_one_that_cannot_be_used_is_named(install, value: str, said: str) -> None:
    install("other", value)
    with pytest.raises(InputError, match=said):
        registry.bulk_tests()


def test_a_run_of_a_model_of_the_user_has_no_bulk_test() -> None:
    for model in ({}, {"test": "heap"}, {"test": {"type": "other"}}, {"test": {"type": 3}}):
        definition = RunDefinition(model, {}, 1)
        assert registry.class_of_test(definition) is None
        assert registry.recreate_test(definition) is None
