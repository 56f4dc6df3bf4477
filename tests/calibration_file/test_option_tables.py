"""The tables of options in the reference are those of the declarations."""

from __future__ import annotations

from pathlib import Path

import pytest

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.options.fields import option_keys
from grainfit.strategies.registry import strategies
from tools import option_tables
from tools.option_tables import FOLDER, page_of, pages


def test_the_tables_of_the_reference_are_up_to_date() -> None:
    for page, text in pages().items():
        assert page.read_text(encoding="utf-8") == text, "run: python tools/option_tables.py"


def tables(page: Path, name: str) -> str:
    text = page.read_text(encoding="utf-8")
    return text.split(f"<!-- {name}: ")[1].split(f"<!-- end of {name} -->")[0]


def test_every_option_and_response_is_in_its_table() -> None:
    for name, test in BUILT_IN.items():
        section = tables(page_of(name), name)
        for key in (*test.option_keys(), *test.responses):
            assert f"| `{getattr(key, 'name', key)}` |" in section


def test_every_option_of_a_strategy_is_in_its_table() -> None:
    section = tables(FOLDER / "strategy.md", "[strategy]")
    for name, strategy in strategies().items():
        own = section.split(f'`name = "{name}"`')[1].split("`name = ")[0]
        assert [key.name for key in option_keys(strategy) if f"| `{key.name}` |" not in own] == []


def test_a_page_that_is_missing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(option_tables, "DOCS", tmp_path)
    monkeypatch.setattr(option_tables, "FOLDER", tmp_path / "reference")
    heap = pages()[page_of("heap")]
    assert heap.startswith('# `type = "heap"`: lifted cylinder')
    assert "| `cylinder_radius` |" in heap
