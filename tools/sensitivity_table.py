"""Write the table of sensitivities in docs/choosing_tests.md from those that the tests declare.

python tools/sensitivity_table.py
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.bulk_tests.sensitivities import (
    DENSITY,
    LARGER,
    MODULUS,
    RESTITUTION,
    ROLLING,
    SLIDING,
    WALL_SLIDING,
    Sensitivities,
)

PAGE = Path(__file__).parents[1] / "docs" / "choosing_tests.md"
COLUMNS = {
    DENSITY: "particle density",
    MODULUS: "Young's modulus",
    SLIDING: "sliding friction",
    ROLLING: "rolling friction",
    WALL_SLIDING: "wall friction",
    RESTITUTION: "restitution",
}
_BEGIN = "<!-- sensitivities: written by tools/sensitivity_table.py -->"
_END = "<!-- end of sensitivities -->"


def updated(page: str) -> str:
    """Return the page with the table of the sensitivities as they are declared now."""
    pattern = f"{re.escape(_BEGIN)}.*{re.escape(_END)}"
    written = f"{_BEGIN}\n\n{table()}\n\n{_END}"
    page, count = re.subn(pattern, lambda _: written, page, flags=re.DOTALL)
    if count != 1:
        raise ValueError(f"{PAGE.name} has not one pair of the marks {_BEGIN} and {_END}")
    return page


def table() -> str:
    """Return the table in Markdown: a row for each response, a column for each parameter."""
    sizes = (f"{times} times the particles" for times in LARGER)
    head = ("test", "response", *COLUMNS.values(), *sizes, "from run to run")
    lines = [_line(head), "|---" * len(head) + "|"]
    return "\n".join([*lines, *map(_line, _rows())])


def _rows() -> Iterator[tuple[str, ...]]:
    for name, test in BUILT_IN.items():
        first = f"`{name}`"
        for response, info in test.responses.items():
            found = info.sensitivities
            if found is not None:
                slopes = (_slope(found, parameter) for parameter in COLUMNS)
                sizes = (f"{_number(round(100 * x, 1))} %" if x else "" for x in found.larger)
                yield (first, f"`{response}`", *slopes, *sizes, f"{100 * found.scatter:.2g} %")
                first = ""


def _slope(found: Sensitivities, parameter: str) -> str:
    low, high = (s.get(parameter) for s in (found.slopes, found.slopes_at_high_rolling))
    if low is None:
        return ""
    return _number(low) if high is None or high == low else f"{_number(low)} ({_number(high)})"


def _number(slope: float) -> str:
    return f"{slope:+}".replace("-", "−")


def _line(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Write the page."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(updated(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
