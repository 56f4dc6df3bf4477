"""Write the tables of the [strategy] section into docs/calibration_file.md.

python tools/strategy_tables.py            write them
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path

from grainfit.calibration_file.strategy_section import CALIBRATION_KEYS
from grainfit.options.fields import option_keys
from grainfit.options.tables import Key
from grainfit.strategies.registry import DEFAULT_STRATEGY, strategies

PAGE = Path(__file__).parents[1] / "docs" / "calibration_file.md"
BEGIN = "<!-- written by tools/strategy_tables.py: begin -->\n"
END = "<!-- written by tools/strategy_tables.py: end -->\n"


def strategy_tables() -> str:
    """Return the tables as Markdown: options of every calibration, then of each strategy."""
    words = "How runs are chosen, see [the method](method.md)."
    name = f'| `name` | `"{DEFAULT_STRATEGY}"` | {words} |'
    parts = [_table([name, *map(_row, CALIBRATION_KEYS)])]
    for strategy in strategies().values():
        summary = (strategy.__doc__ or "").splitlines()[0]
        parts += [
            f'`name = "{strategy.name}"`. {summary}',
            _table(map(_row, option_keys(strategy))),
        ]
    return "\n\n".join(parts) + "\n"


def _table(rows: Iterable[str]) -> str:
    return "\n".join(["| key | default | meaning |", "|---|---|---|", *rows])


def _row(option: Key) -> str:
    return f"| `{option.name}` | {option.default} | {option.description} |"


def with_tables(page: str) -> str:
    """Return a page with the tables between its marks replaced."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{strategy_tables()}\n{END}{after}"


def main() -> None:
    """Write the tables into the page."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
