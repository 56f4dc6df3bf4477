"""Tables of runs as CSV files: their columns, and the faults that all of them can have."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from pathlib import Path

from grainfit.errors import Fault, InputError
from grainfit.evaluation import ERROR_SUFFIX

#: Column of the seed, where a table has one.
SEED_COLUMN = "seed"
#: In place of `ERROR_SUFFIX` in version 0.1.0.
OLD_ERROR_SUFFIX = "_std_error"


def read_csv(path: Path) -> list[tuple[int, list[str]]]:
    """Return the lines of a CSV file that are not blank, with their numbers; first its header.

    Raises
    ------
    InputError
        The file cannot be read, is no CSV file in UTF-8, or is empty.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file, strict=True)
            lines = [
                (reader.line_num, [cell.strip() for cell in line])
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
        raise InputError(Fault("", "is empty.", "Give a header and one line per run."), str(path))
    return lines


def note_old_error_column(name: str, responses: Iterable[str], where: str) -> Fault | None:
    """Return a fault if a column has the name that a standard error had in version 0.1.0."""
    response = name.removesuffix(OLD_ERROR_SUFFIX)
    if name == response or response not in responses:
        return None
    return Fault(
        where,
        f"is how version 0.1.0 named the standard error of {response}.",
        f"Name it {response}{ERROR_SUFFIX}.",
    )


def repeated_runs(runs: Iterable[tuple[str, tuple[float, ...]]]) -> Iterator[Fault]:
    """Yield a fault for each run that is there twice; only seeds tell repeats from copies.

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
