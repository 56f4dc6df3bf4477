"""Writes runs to a file that spreadsheets and data frames read."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from grainfit.errors import Fault, InputError
from grainfit.files import in_place_of
from grainfit.work_folder.run_table import COMMON_COLUMNS, Cell, RunRow

Write = Callable[[Path, Sequence[str], Sequence[RunRow]], None]


def writer_for(path: Path) -> Write:
    """Return what writes runs to a file of this name, before any are read.

    Raises
    ------
    InputError
        The name tells no format, or the package that writes it is missing.
    """
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return _write_csv
    if suffix != ".parquet":
        raise InputError(
            Fault(
                "", f"{str(path)!r} is of no format that is known.", "End it in .csv or .parquet."
            )
        )
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        raise InputError(
            Fault(
                "",
                "Parquet needs the Python package pyarrow, which is not installed.",
                "Install it: pip install 'grainfit[parquet]'. Or export to a .csv file.",
            )
        ) from None
    return _write_parquet


def export_runs(path: Path, columns: Sequence[str], rows: Sequence[RunRow]) -> None:
    """Write one line for each run, with SI units and angles in degrees; all of it or nothing.

    Parameters
    ----------
    path : Path
        Ends in ``.csv`` or ``.parquet``; is replaced when it is there.
    columns : sequence of str
        Which, in order.
    rows : sequence of RunRow
        The runs.

    Raises
    ------
    InputError
        The format is not known, or the file cannot be written.
    """
    write = writer_for(path)
    try:
        with in_place_of(path) as place:
            write(place, columns, rows)
    except OSError as error:
        raise InputError(
            Fault("", f"{str(path)!r} cannot be written: {error.strerror or error}.")
        ) from error


def _write_csv(path: Path, columns: Sequence[str], rows: Sequence[RunRow]) -> None:
    # A name that is not valid Unicode must not cost the whole table.
    with path.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows([_as_text(row.cells.get(name)) for name in columns] for row in rows)


def _as_text(cell: Cell) -> str:
    if cell is None:
        return ""
    if isinstance(cell, datetime):
        return cell.isoformat(timespec="seconds")
    return repr(cell) if isinstance(cell, float) else str(cell)


def _write_parquet(path: Path, columns: Sequence[str], rows: Sequence[RunRow]) -> None:
    import pyarrow
    import pyarrow.parquet

    kinds: dict[str, Any] = dict.fromkeys(COMMON_COLUMNS, pyarrow.string())
    kinds["seed"] = pyarrow.int64()
    kinds["seconds"] = pyarrow.float64()
    kinds["ended"] = pyarrow.timestamp("ms", tz="UTC")
    arrays = [
        pyarrow.array(
            [_valid(row.cells.get(name)) for row in rows],
            kinds.get(name, pyarrow.float64()),
            safe=False,
        )
        for name in columns
    ]
    table = pyarrow.Table.from_arrays(arrays, [str(_valid(name)) for name in columns])
    pyarrow.parquet.write_table(table, path)


def _valid(cell: Cell) -> Cell:
    if not isinstance(cell, str):
        return cell
    return cell.encode("utf-8", "backslashreplace").decode()
