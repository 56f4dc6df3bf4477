"""What `grainfit runs` shows."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from rich import box
from rich.cells import cell_len
from rich.console import Console, JustifyMethod
from rich.table import Table
from rich.text import Text

from grainfit.campaign.store.records import RunRecord
from grainfit.formatting import plain, plain_lines
from grainfit.work_folder.prune import Pruned
from grainfit.work_folder.run_import import Imported
from grainfit.work_folder.run_table import Cell, RunRow, RunTable

#: So many digits of an identity tell runs apart, and `grainfit runs show` takes them.
SHORT_IDENTITY = 7
#: Where nobody looks at a terminal, lines are as long as they need to be.
_WIDE = 100_000
_NUMBER_WIDTH = 9
_LEAST_STATUS = 8
_GAP = 2
_PREFIXES = ("", "k", "M", "G", "T")


def runs_console() -> Console:
    """Return a console that cuts nothing when its output goes to a file or another program."""
    console = Console()
    return console if console.is_terminal else Console(width=_WIDE)


def print_runs(
    console: Console, table: RunTable, rows: Sequence[RunRow], limit: int, disk: str = ""
) -> None:
    """Print a line for each of the first rows, and how many more there are.

    What is the same in all rows is left out, and so are the columns that do not fit.
    """
    shown = rows[:limit]
    if shown:
        columns, left_out = _columns_that_fit(table, rows, shown, console.width)
        console.print(_as_rich(columns, shown, console.width))
        if left_out:
            words = f"No room for {', '.join(left_out)}: widen the terminal, or export them."
            console.print(Text(plain(words)), soft_wrap=True)
    more = len(rows) - len(shown)
    failed = sum(row.record.status == "failed" for row in rows)
    parts = [_count(len(rows), "run"), *([f"{failed} failed"] if failed else [])]
    if len(rows) < len(table.rows):
        parts.append(f"of {len(table.rows)} that there are")
    if more > 0:
        parts.append(f"{more} more than shown: --limit {len(rows)} shows all")
    console.print(Text(", ".join(parts) + "."), soft_wrap=True)
    if disk:
        console.print(Text(plain(disk)), soft_wrap=True)


def _columns_that_fit(
    table: RunTable, rows: Sequence[RunRow], shown: Sequence[RunRow], width: int
) -> tuple[list[str], list[str]]:
    """Return the columns to show, and the parameters and responses that there is no room for."""
    first = ["identity", "test", "seed", "seconds"]
    if len(_values(table.rows, "test")) == 1:
        first.remove("test")
    last = [] if _values(table.rows, "status") == {"finished"} else ["status"]
    # What is fixed is the same in all runs, and says nothing here.
    varied = [name for name in table.parameters if len(_values(table.rows, name)) > 1]
    responses = [name for name in table.responses if _values(rows, name) != {None}]
    left_out: list[str] = []
    while (varied or responses) and _width(first + varied + responses, shown, last) > width:
        # The last of the longer list: some of both stay in sight.
        longer = varied if len(varied) > len(responses) else responses
        left_out.insert(0, longer.pop())
    return first + varied + responses + last, left_out


def _width(columns: Sequence[str], rows: Sequence[RunRow], last: Sequence[str]) -> int:
    widths = [_column_width(name, rows) for name in columns]
    return sum(widths) + _GAP * (len(widths) - 1) + (_GAP + _LEAST_STATUS) * len(last)


def _column_width(name: str, rows: Sequence[RunRow]) -> int:
    heading = max(map(len, _heading(name).split("\n")))
    return max(heading, *(cell_len(_shown(name, row.cells.get(name))) for row in rows))


def _values(rows: Sequence[RunRow], name: str) -> set[Cell]:
    return {row.cells.get(name) for row in rows}


def _as_rich(columns: Sequence[str], rows: Sequence[RunRow], width: int) -> Table:
    # With the column of its separator, the gap is of two.
    table = Table(box=box.SIMPLE, show_edge=False, pad_edge=False, padding=(0, _GAP - 1, 0, 0))
    left = width - _width([name for name in columns if name != "status"], rows, ()) - _GAP
    for name in columns:
        justify: JustifyMethod = "left" if name in ("identity", "test", "status") else "right"
        table.add_column(Text(_heading(name)), justify=justify, no_wrap=True)
    for row in rows:
        cells = {name: Text(_shown(name, row.cells.get(name))) for name in columns}
        if "status" in cells:
            cells["status"] = Text(_status(row.record))
            cells["status"].truncate(max(left, _LEAST_STATUS), overflow="ellipsis")
        table.add_row(*cells.values(), style="red" if row.record.status == "failed" else "")
    return table


def _status(record: RunRecord) -> str:
    return plain(f"{record.status}: {record.reason}" if record.reason else record.status)


def _shown(name: str, cell: Cell) -> str:
    if cell is None:
        return ""
    if name == "identity":
        return plain(str(cell))[:SHORT_IDENTITY]
    if name == "seconds" and isinstance(cell, float):
        return f"{cell:.1f}"
    return f"{cell:.5g}" if isinstance(cell, float) else plain(str(cell))


def _heading(name: str) -> str:
    """Break a long name where its words meet: numbers need little room."""
    lines = [""]
    for word in re.findall(r"[^._]*[._]|[^._]+", plain(name)):
        if lines[-1] and len(lines[-1]) + len(word) > _NUMBER_WIDTH:
            lines.append("")
        lines[-1] += word
    return "\n".join(lines)


def print_record(console: Console, record: RunRecord, folder: Path | None) -> None:
    """Print all that is known of a run."""
    [row] = RunTable([record]).rows
    for name, cell in row.cells.items():
        if cell not in (None, ""):
            shown = cell.isoformat(timespec="seconds") if isinstance(cell, datetime) else cell
            _line(console, f"{name} = {shown}")
    if folder is not None:
        _line(console, f"folder = {folder}")
    _line(console, "")
    _line(console, "definition, all that decides the outcome:")
    for line in json.dumps(record.definition.to_json(), indent=2, ensure_ascii=False).splitlines():
        _line(console, f"  {line}")
    if record.log_tail:
        _line(console, "")
        _line(console, "last lines of its log:")
        for line in plain_lines(record.log_tail):
            _line(console, f"  | {line}")


def print_imported(console: Console, imported: Imported, folder: Path) -> None:
    """Print what came of an import."""
    replaced = f", {imported.replaced} corrected" if imported.replaced else ""
    _line(
        console,
        f"Imported {_count(imported.new, 'run')} of the test {imported.test}{replaced}; "
        f"{imported.known} were there already.",
    )
    for notice in imported.notices:
        console.print(Text(plain(notice), style="yellow"), soft_wrap=True)
    _line(
        console,
        f"A calibration that starts in {folder} can learn from "
        f"{_count(imported.usable, 'parameter set')}.",
    )


def print_pruned(console: Console, pruned: Pruned) -> None:
    """Print what pruning freed."""
    _line(console, f"Freed {size(pruned.freed)} in {_count(pruned.folders, 'run folder')}.")
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


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _line(console: Console, text: str) -> None:
    console.print(Text(plain(text)), soft_wrap=True)
