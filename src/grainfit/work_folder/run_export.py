"""Write runs to a file for spreadsheets and data frames."""

from __future__ import annotations

import csv
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from grainfit.errors import InputError
from grainfit.extras import import_extra
from grainfit.files import in_place_of, writing
from grainfit.formatting import spreadsheet_text
from grainfit.work_folder import messages
from grainfit.work_folder.run_columns import RunColumns
from grainfit.work_folder.run_table import as_table

Write = Callable[[RunColumns, Path], None]


def writer_for(path: Path) -> Write:
    """Return a function that writes runs to a file of this name, before any are read.

    Raises
    ------
    InputError
        The name has no known ending, or a package that writes the format is missing.
    """
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return _write_csv
    if suffix != ".parquet":
        raise InputError(messages.UNKNOWN_FORMAT.fault("", path=str(path)))
    for module in ("pandas", "pyarrow.parquet"):
        import_extra(module, "parquet", "a Parquet file", "Or export to a .csv file.")
    return _write_parquet


def export_runs(path: Path, runs: RunColumns) -> None:
    """Write one line for each run, in SI units, angles in degrees; the file is complete or absent.

    Parameters
    ----------
    path : Path
        Ends in ``.csv`` or ``.parquet``; an existing file is replaced.
    runs : RunColumns
        The runs.

    Raises
    ------
    InputError
        The format is not known, a package is missing, or the file cannot be written.
    """
    write = writer_for(path)
    with writing(path), in_place_of(path) as place:
        write(runs, place)


def _write_csv(runs: RunColumns, path: Path) -> None:
    columns = runs.values.values()
    with path.open("w", encoding="utf-8", newline="") as file:
        # The line ends of the CSV standard; with them, a reason of several lines is always quoted.
        lines = csv.writer(file, lineterminator="\r\n")
        lines.writerow(spreadsheet_text(_heading(name, runs)) for name in runs.values)
        lines.writerows(map(_cell, row) for row in zip(*columns, strict=True))


def _heading(name: str, runs: RunColumns) -> str:
    """Return a name with its unit, as tables that are read may have it."""
    unit = runs.units.get(name, "")
    return f"{name} [{unit}]" if unit and name != "seconds" else name


def _cell(value: str | float | datetime | None) -> str | float | None:
    if isinstance(value, str):
        return spreadsheet_text(value)
    if isinstance(value, datetime):
        return value.strftime("%Y-%m-%dT%H:%M:%S+00:00")
    return value


def _write_parquet(runs: RunColumns, path: Path) -> None:
    as_table(runs).reset_index().to_parquet(path, engine="pyarrow", index=False)
