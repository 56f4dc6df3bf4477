"""Read tables of runs from CSV files, and check their columns."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator
from pathlib import Path

from grainfit.errors import Fault, InputError
from grainfit.evaluation import ERROR_SUFFIX
from grainfit.files import LARGEST_TABLE, read_within
from grainfit.formatting import from_spreadsheet_text

#: Column of the seed, if a table has one.
SEED_COLUMN = "seed"
#: Suffix that version 0.1.0 used instead of `ERROR_SUFFIX`.
OLD_ERROR_SUFFIX = "_std_error"


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
        text = read_within(path, largest).decode("utf-8-sig")
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
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(
            Fault("", f"is not a CSV file: {error}.", "Save the table as CSV in UTF-8."), str(path)
        ) from error
    if not lines:
        raise InputError(Fault("", "is empty.", f"Give {content}."), str(path))
    return lines


def note_old_error_column(name: str, responses: Iterable[str], where: str) -> Fault | None:
    """Return a fault if a column has the name that a standard error had in version 0.1.0."""
    response = name.removesuffix(OLD_ERROR_SUFFIX)
    if name == response or response not in responses:
        return None
    return Fault(
        where,
        f"is the name of the standard error of {response} in version 0.1.0.",
        f"Name it {response}{ERROR_SUFFIX}.",
    )


def repeated_runs(runs: Iterable[tuple[str, tuple[float, ...]]]) -> Iterator[Fault]:
    """Yield a fault for each run that occurs twice with the same seed.

    Parameters
    ----------
    runs : iterable of (str, tuple of float)
        Place in the table; parameters and seed.
    """
    first: dict[tuple[float, ...], str] = {}
    for place, run in runs:
        if first.setdefault(run, place) != place:
            yield Fault(
                place,
                f"has the same parameters and seed as {first[run]}.",
                "Keep one of them, or give them the seeds they were run with.",
            )
