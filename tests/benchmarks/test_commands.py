"""Benchmarks and studies are commands that fit the code of today."""

from __future__ import annotations

import ast
import importlib
import re
import sys
from pathlib import Path

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


def test_scripts_import_no_package_of_the_repository() -> None:
    # `python benchmarks/NAME.py` finds only what is in its own folder; `python -m` finds all.
    folders = [ROOT / "benchmarks", ROOT / "docs"]
    texts = [path.read_text("utf-8") for f in folders for path in f.rglob("*") if _is_text(path)]
    documented = set(re.findall(r"python benchmarks/(\w+)\.py", "\n".join(texts)))
    scripts = {name: (ROOT / "benchmarks" / f"{name}.py").read_text("utf-8") for name in documented}
    assert len(scripts) > 50
    assert [
        name
        for name, text in scripts.items()
        if {"benchmarks", "studies", "tests", "tools"} & _packages(text) and "sys.path" not in text
    ] == []


def _is_text(path: Path) -> bool:
    return path.suffix in (".py", ".md")


def _packages(text: str) -> set[str]:
    """Return the packages from which a module imports."""
    nodes = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)]
    return {(node.module or "").partition(".")[0] for node in nodes}
