"""Write the tables of bulk tests in docs/calibration_file.md from the declarations of the tests.

python tools/option_tables.py

Responses and options of each built-in test stand between two comments of that page; a new test
gets its section at the end of the others.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.formatting import unit_for_people
from grainfit.options.kinds import Choice, Quantity, Whole
from grainfit.options.tables import Key
from grainfit.solvers.registry import types_of_test
from grainfit.solvers.type_of_test import TypeOfTest

PAGE = Path(__file__).parents[1] / "docs" / "calibration_file.md"
_NONE = "–"
_END = "<!-- end of the bulk tests -->"


def updated(page: str) -> str:
    """Return the page with the tables of all built-in tests as they are declared now."""
    for name in BUILT_IN:
        begin, end = _marks(name)
        if begin not in page:
            page = page.replace(_END, f"{_heading(name)}\n\n{begin}\n{end}\n\n{_END}")
        between = f"{begin}\n\n{_tables(types_of_test()[name])}\n\n{end}"
        pattern = f"{re.escape(begin)}.*{re.escape(end)}"
        page = re.sub(pattern, lambda _, text=between: text, page, flags=re.DOTALL)
    return page


def _marks(name: str) -> tuple[str, str]:
    return f"<!-- {name}: written by tools/option_tables.py -->", f"<!-- end of {name} -->"


def _heading(name: str) -> str:
    return f'### `type = "{name}"`: {BUILT_IN[name].title}'


def _tables(kind: TypeOfTest) -> str:
    assert kind.bulk_test is not None
    lines = ["| response | unit | meaning |", "|---|---|---|"]
    for name, info in kind.bulk_test.responses.items():
        lines.append(f"| `{name}` | {unit_for_people(info.unit) or _NONE} | {info.words}. |")
    lines += ["", "Give a target for one of them, or for several.", ""]
    lines += ["| key | possible | default | meaning |", "|---|---|---|---|"]
    lines += [_row(key) for key in kind.keys]
    return "\n".join(lines)


def _row(key: Key) -> str:
    default = "required" if key.required else key.default or _NONE
    return f"| `{key.name}` | {_possible(key)} | {default} | {key.description} |"


def _possible(key: Key) -> str:
    kind = key.kind
    if isinstance(kind, Choice):
        return ", ".join(f'`"{word}"`' for word in kind.options)
    if isinstance(kind, Quantity | Whole):
        return kind.limits()
    return _NONE


def main() -> None:
    """Write the page."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(updated(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
