"""The tables of bulk tests in the reference are those of the declarations."""

from __future__ import annotations

from grainfit.bulk_tests.registry import BUILT_IN
from tools.option_tables import PAGE, updated


def test_the_tables_of_the_reference_are_up_to_date() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert updated(page) == page, "run: python tools/option_tables.py"


def test_every_option_and_response_is_in_its_table() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for name, test in BUILT_IN.items():
        section = page.split(f"<!-- {name}: ")[1].split(f"<!-- end of {name} -->")[0]
        for key in (*test.option_keys(), *test.responses):
            assert f"| `{getattr(key, 'name', key)}` |" in section


def test_a_section_that_is_missing_is_added() -> None:
    page = "before\n<!-- end of the bulk tests -->\nafter\n"
    once = updated(page)
    assert '### `type = "heap"`: lifted cylinder' in once
    assert once.startswith("before\n")
    assert once.endswith("<!-- end of the bulk tests -->\nafter\n")
    assert updated(once) == once
