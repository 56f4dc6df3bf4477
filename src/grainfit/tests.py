"""Bulk tests by class: ``gf.tests.Heap(diameter="10 mm")``, those of other packages included."""

from __future__ import annotations

from typing import Any

from grainfit.bulk_tests.own_scene import OwnScene as OwnScene
from grainfit.bulk_tests.registry import *  # noqa: F403
from grainfit.bulk_tests.registry import bulk_tests


def __getattr__(name: str) -> Any:
    for test in bulk_tests().values():
        if test.__name__ == name:
            return test
    raise AttributeError(f"module {__name__!r} has no bulk test {name!r}")


def __dir__() -> list[str]:
    return sorted({OwnScene.__name__, *(test.__name__ for test in bulk_tests().values())})
