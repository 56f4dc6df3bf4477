"""Write the table of recorded trials in docs/choosing_tests.md from those that the tests declare.

python tools/recorded_trials_table.py
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

from grainfit.bulk_tests.recorded_trials import LARGER
from grainfit.bulk_tests.registry import BUILT_IN

PAGE = Path(__file__).parents[1] / "docs" / "choosing_tests.md"
_BEGIN = "<!-- recorded trials: written by tools/recorded_trials_table.py -->"
_END = "<!-- end of recorded trials -->"


def updated(page: str) -> str:
    """Return the page with the table of the trials as they are declared now."""
    pattern = f"{re.escape(_BEGIN)}.*{re.escape(_END)}"
    written = f"{_BEGIN}\n\n{table()}\n\n{_END}"
    page, count = re.subn(pattern, lambda _: written, page, flags=re.DOTALL)
    if count != 1:
        raise ValueError(f"{PAGE.name} has not one pair of the marks {_BEGIN} and {_END}")
    return page


def table() -> str:
    """Return the table in Markdown: a row for each response."""
    sizes = (f"{times} times the particles" for times in LARGER)
    head = ("test", "response", "from run to run", *sizes)
    return "\n".join([_line(head), "|---" * len(head) + "|", *map(_line, _rows())])


def _rows() -> Iterator[tuple[str, ...]]:
    for name, test in BUILT_IN.items():
        first = f"`{name}`"
        for response, info in test.responses.items():
            if (found := info.trials) is not None:
                sizes = (_percent(change) for change in found.larger)
                yield (first, f"`{response}`", f"{100 * found.scatter:.2g} %", *sizes)
                first = ""


def _percent(change: float) -> str:
    return f"{round(100 * change, 1):+} %".replace("-", "−") if change else ""


def _line(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Write the page."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(updated(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
