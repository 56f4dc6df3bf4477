"""The tables of options in the reference are those of the declarations."""

from __future__ import annotations

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.options.fields import option_keys
from grainfit.strategies.registry import strategies
from tools.option_tables import INSTRUMENTS_PAGE, PAGE, updated, with_instruments


def test_the_tables_of_the_reference_are_up_to_date() -> None:
    for path, written in ((PAGE, updated), (INSTRUMENTS_PAGE, with_instruments)):
        page = path.read_text(encoding="utf-8")
        assert written(page) == page, "run: python tools/option_tables.py"


def tables(page: str, name: str) -> str:
    return page.split(f"<!-- {name}: ")[1].split(f"<!-- end of {name} -->")[0]


def test_every_option_and_response_is_in_its_table() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for name, test in BUILT_IN.items():
        section = tables(page, name)
        for key in (*test.option_keys(), *test.responses):
            assert f"| `{getattr(key, 'name', key)}` |" in section


def test_every_option_of_a_strategy_is_in_its_table() -> None:
    section = tables(PAGE.read_text(encoding="utf-8"), "[strategy]")
    for name, strategy in strategies().items():
        own = section.split(f'`name = "{name}"`')[1].split("`name = ")[0]
        assert [key.name for key in option_keys(strategy) if f"| `{key.name}` |" not in own] == []


def test_a_section_that_is_missing_is_added() -> None:
    page = "before\n<!-- end of the bulk tests -->\nafter\n"
    once = updated(page)
    assert '### `type = "heap"`: lifted cylinder' in once
    assert once.startswith("before\n")
    assert once.endswith("<!-- end of the bulk tests -->\nafter\n")
    assert updated(once) == once
