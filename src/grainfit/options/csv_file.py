"""Read the lines of CSV files."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from grainfit.errors import Fault, InputError
from grainfit.files import LARGEST_TABLE, line_of, read_within
from grainfit.formatting import from_spreadsheet_text


def read_csv(
    path: Path,
    *,
    largest: int = LARGEST_TABLE,
    content: str = "a header and one line per run",
) -> list[tuple[int, list[str]]]:
    """Return the header and the nonblank lines of a CSV file, with their numbers.

    Cells that were written as `spreadsheet_text` have their original text.

    Parameters
    ----------
    path : Path
        The file.
    largest : int
        Bytes above which a file is refused, without reading all of it.
    content : str
        What an empty file should hold.

    Raises
    ------
    InputError
        The file cannot be read, is too large, is not a CSV file in UTF-8, or is empty.
    """
    try:
        text = _decoded(read_within(path, largest), path)
        reader = csv.reader(io.StringIO(text, newline=""), strict=True)
        lines = [
            (reader.line_num, [from_spreadsheet_text(cell.strip()) for cell in line])
            for line in reader
            if any(map(str.strip, line))
        ]
    except OSError as error:
        raise InputError(
            Fault("", f"cannot be read: {error.strerror}.", "Give the path of a CSV file."),
            str(path),
        ) from error
    except csv.Error as error:
        raise InputError(
            Fault("", f"is not a CSV file: {error}.", "Save the table as CSV in UTF-8."), str(path)
        ) from error
    if not lines:
        raise InputError(Fault("", "is empty.", f"Give {content}."), str(path))
    return lines


def _decoded(data: bytes, path: Path) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        words = f"is not UTF-8 text in line {line_of(error)}."
        fault = Fault("", words, "Save the table as CSV in UTF-8.")
        raise InputError(fault, str(path)) from error
