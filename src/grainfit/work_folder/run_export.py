"""Write runs to a file for spreadsheets and data frames."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
from pandas.api.types import is_datetime64_any_dtype, is_numeric_dtype

from grainfit.errors import Fault, InputError
from grainfit.files import in_place_of
from grainfit.formatting import spreadsheet_text

Write = Callable[[pd.DataFrame, Path], None]


def writer_for(path: Path) -> Write:
    """Return a function that writes runs to a file of this name, before any are read.

    Raises
    ------
    InputError
        The name has no known ending, or the package that writes the format is missing.
    """
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return _write_csv
    if suffix != ".parquet":
        raise InputError(
            Fault("", f"{str(path)!r} has no known format.", "End it in .csv or .parquet.")
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


def export_runs(path: Path, runs: pd.DataFrame) -> None:
    """Write one line for each run, in SI units, angles in degrees; the file is complete or absent.

    Parameters
    ----------
    path : Path
        Ends in ``.csv`` or ``.parquet``; an existing file is replaced.
    runs : pandas.DataFrame
        As `runs_table` returns it.

    Raises
    ------
    InputError
        The format is not known, or the file cannot be written.
    """
    write = writer_for(path)
    try:
        with in_place_of(path) as place:
            write(runs.reset_index(), place)
    except OSError as error:
        raise InputError(
            Fault("", f"{str(path)!r} cannot be written: {error.strerror or error}.")
        ) from error


def _write_csv(runs: pd.DataFrame, path: Path) -> None:
    # The line ends of the CSV standard; with them, a reason of several lines is always quoted.
    _for_spreadsheets(runs).to_csv(
        path,
        index=False,
        compression=None,
        lineterminator="\r\n",
        date_format="%Y-%m-%dT%H:%M:%S+00:00",
    )


def _for_spreadsheets(runs: pd.DataFrame) -> pd.DataFrame:
    """Return the table with all names and texts as `spreadsheet_text`."""
    texts = {
        name: [spreadsheet_text(cell) if isinstance(cell, str) else cell for cell in column]
        for name, column in runs.items()
        if not is_numeric_dtype(column) and not is_datetime64_any_dtype(column)
    }
    return runs.assign(**texts).rename(columns=spreadsheet_text)


def _write_parquet(runs: pd.DataFrame, path: Path) -> None:
    runs.to_parquet(path, engine="pyarrow", index=False)
