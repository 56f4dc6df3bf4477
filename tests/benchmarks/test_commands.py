"""Benchmarks and studies are commands that fit the code of today."""

from __future__ import annotations

import importlib
import sys

import pytest

from tools.house import ROOT

BENCHMARKS = sorted(path.stem for path in (ROOT / "benchmarks").glob("*.py"))
STUDIES = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for path in (ROOT / "studies").rglob("*.py")
    if not path.stem.startswith("__")
)


def test_every_module_can_be_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    # Their scripts import one another without a package, as `python benchmarks/NAME.py` does.
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    # They set it when they are imported.
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    faults = {}
    for name in (*BENCHMARKS, *STUDIES):
        try:
            importlib.import_module(name)
        except ModuleNotFoundError as error:
            # Programs of others that a benchmark compares with.
            if (error.name or "").partition(".")[0] in {"grainfit", "studies", *BENCHMARKS}:
                faults[name] = str(error)
        except ImportError as error:
            faults[name] = str(error)
    for name in BENCHMARKS:
        sys.modules.pop(name, None)
    assert faults == {}
