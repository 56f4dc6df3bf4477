"""Output of `grainfit runs`."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from rich import box
from rich.cells import cell_len
from rich.console import Console, JustifyMethod
from rich.table import Table
from rich.text import Text

from grainfit.formatting import assigned, counted, plain, plain_lines, unit_for_people
from grainfit.work_folder.run_columns import RunColumns

if TYPE_CHECKING:
    from grainfit.work_folder.prune import Pruned
    from grainfit.work_folder.run_import import Imported

#: This many digits of an identity distinguish runs, and `grainfit runs show` accepts them.
SHORT_IDENTITY = 7
_NUMBER_WIDTH = 9
_DIGITS_OF_A_RUN = 6
_LEAST_STATUS = 8
_GAP = 2
_PREFIXES = ("", "k", "M", "G", "T")


def print_runs(
    console: Console, runs: RunColumns, selected: RunColumns, limit: int, disk: str = ""
) -> None:
    """Print a line for each of the first selected runs, and how many more there are.

    Parameters that are the same in all runs are left out, and so are the columns that do not fit.
    """
    shown = selected.rows(range(min(limit, len(selected))))
    if len(shown):
        columns, left_out = _columns_that_fit(runs, shown, console.width)
        console.print(_as_rich(columns, shown, console.width))
        if left_out:
            words = f"No room for {', '.join(left_out)}: widen the terminal, or export them."
            console.print(Text(plain(words)), soft_wrap=True)
    more = len(selected) - len(shown)
    failed = selected.values["status"].count("failed")
    parts = [counted(len(selected), "run"), *([f"{failed} failed"] if failed else [])]
    if len(selected) < len(runs):
        parts.append(f"of {len(runs)} in total")
    if more > 0:
        parts.append(f"{more} more than shown: --limit {len(selected)} shows all")
    console.print(Text(", ".join(parts) + "."), soft_wrap=True)
    if disk:
        console.print(Text(plain(disk)), soft_wrap=True)


def _columns_that_fit(
    runs: RunColumns, shown: RunColumns, width: int
) -> tuple[list[str], list[str]]:
    """Return the columns to show, and the parameters and responses that there is no room for."""
    first = ["identity", "test", "seed", "seconds"]
    if len(set(runs.values["test"])) == 1:
        first.remove("test")
    last = ["status"] if set(runs.values["status"]) - {"finished"} else []
    # Fixed parameters are the same in all runs, so they are not shown.
    varied = [name for name in runs.parameters.values() if len(set(runs.values[name])) > 1]
    responses = [
        name for name in runs.responses.values() if any(v is not None for v in shown.values[name])
    ]
    left_out: list[str] = []
    while (varied or responses) and _width(first + varied + responses, shown, last) > width:
        # The last of the longer list, so that some of both remain.
        longer = varied if len(varied) > len(responses) else responses
        left_out.insert(0, longer.pop())
    return first + varied + responses + last, left_out


def _width(columns: Sequence[str], shown: RunColumns, last: Sequence[str] = ()) -> int:
    widths = [_column_width(name, shown) for name in columns]
    return sum(widths) + _GAP * (len(widths) - 1) + (_GAP + _LEAST_STATUS) * len(last)


def _column_width(name: str, shown: RunColumns) -> int:
    heading = max(map(len, _heading(name, shown).split("\n")))
    return max(heading, *map(cell_len, _texts(name, shown)))


def _as_rich(columns: Sequence[str], shown: RunColumns, width: int) -> Table:
    # With the separator's own column, the gap is two.
    table = Table(box=box.SIMPLE, show_edge=False, pad_edge=False, padding=(0, _GAP - 1, 0, 0))
    left = width - _width([name for name in columns if name != "status"], shown) - _GAP
    for name in columns:
        justify: JustifyMethod = "left" if name in ("identity", "test", "status") else "right"
        table.add_column(Text(_heading(name, shown)), justify=justify, no_wrap=True)
    cells = {name: list(map(Text, _texts(name, shown))) for name in columns}
    for status in cells.get("status", ()):
        status.truncate(max(left, _LEAST_STATUS), overflow="ellipsis")
    for status, *row in zip(shown.values["status"], *cells.values(), strict=True):
        table.add_row(*row, style="red" if status == "failed" else "")
    return table


def _texts(name: str, shown: RunColumns) -> list[str]:
    """Return the cells of a column as they are shown."""
    if name == "identity":
        return [plain(identity)[:SHORT_IDENTITY] for identity in shown.values["identity"]]
    if name == "status":
        pairs = zip(shown.values["status"], shown.values["reason"], strict=True)
        return [plain(f"{status}: {reason}" if reason else status) for status, reason in pairs]
    digits = ".1f" if name == "seconds" else ".5g"
    return [
        "" if cell is None else f"{cell:{digits}}" if isinstance(cell, float) else plain(str(cell))
        for cell in shown.values[name]
    ]


def _heading(name: str, shown: RunColumns) -> str:
    """Break a long name between its words, for columns of numbers are narrow; below is its unit."""
    lines = [""]
    for word in re.findall(r"[^._]*[._]|[^._]+", plain(name)):
        if lines[-1] and len(lines[-1]) + len(word) > _NUMBER_WIDTH:
            lines.append("")
        lines[-1] += word
    # The name of the column of seconds is their unit.
    unit = "" if name == "seconds" else unit_for_people(shown.units.get(name, ""))
    return "\n".join([*lines, *([f"in {unit}"] if unit else [])])


def print_record(console: Console, columns: RunColumns, folder: Path | None) -> None:
    """Print all that is known of the only run in a table."""
    [record] = columns.records
    for name, [cell] in columns.values.items():
        if isinstance(cell, float):
            _line(console, *assigned({name: cell}, columns.units, _DIGITS_OF_A_RUN))
        elif cell not in ("", None):
            shown = cell.isoformat(timespec="seconds") if isinstance(cell, datetime) else cell
            _line(console, f"{name} = {shown}")
    if folder is not None:
        _line(console, f"folder = {folder}")
    _line(console, "")
    _line(console, "definition, all that decides the outcome, in SI units:")
    for line in json.dumps(record.definition.to_json(), indent=2, ensure_ascii=False).splitlines():
        _line(console, f"  {line}")
    if record.log_tail:
        _line(console, "")
        _line(console, "last lines of its log:")
        for line in plain_lines(record.log_tail):
            _line(console, f"  | {line}")


def print_imported(console: Console, imported: Imported, folder: Path) -> None:
    """Print the outcome of an import."""
    replaced = f", {imported.replaced} corrected" if imported.replaced else ""
    _line(console, f"Table {imported.table}.")
    _line(
        console,
        f"Imported {counted(imported.new, 'run')} of the test {imported.test}{replaced}; "
        f"{imported.known} were there already.",
    )
    for notice in imported.notices:
        console.print(Text(plain(notice), style="yellow"), soft_wrap=True)
    _line(
        console,
        f"A calibration in {folder} can warm start from "
        f"{counted(imported.usable, 'parameter set')}.",
    )


def print_pruned(console: Console, pruned: Pruned) -> None:
    """Print what pruning freed."""
    _line(console, f"Freed {size(pruned.freed)} in {counted(pruned.folders, 'run folder')}.")
    for fault in pruned.faults:
        console.print(Text(plain(f"not all of {fault}"), style="red"), soft_wrap=True)


def size(number: int) -> str:
    """Return a number of bytes as people read it.

    Examples
    --------
    >>> size(1_234_567)
    '1.2 MB'
    """
    value = float(number)
    for prefix in _PREFIXES:
        if value < 1000 or prefix == _PREFIXES[-1]:
            break
        value /= 1000
    return f"{value:.1f} {prefix}B" if prefix else f"{number} bytes"


def _line(console: Console, text: str) -> None:
    console.print(Text(plain(text)), soft_wrap=True)
