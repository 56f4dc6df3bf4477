"""A table of recorded runs as a solver: looks runs up instead of making them."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from grainfit.errors import Fault, InputError, RunFailedError
from grainfit.evaluation import Response
from grainfit.solvers.base import Solver, Workspace
from grainfit.solvers.own_model.exchange import finite_parameters

#: Column of the seed, where the table has one.
SEED_COLUMN = "seed"
#: What columns of standard errors end in; the second is that of version 0.1.0.
_ERROR_SUFFIXES = (".standard_error", "_std_error")
_MOST_FAULTS = 20


class RecordedTable(Solver):
    """Runs recorded in a CSV file or in rows, found by their parameters.

    A run is found when every parameter agrees with a recorded one within `tolerance`, relative to
    the range of the table's column. Of several recorded runs at the same parameters (replicates),
    the one with the wanted seed is taken when the table has a column ``seed`` and that seed is
    there; otherwise the seed picks one of them, always the same.

    Parameters
    ----------
    source : path or sequence of mapping
        A CSV file with a header, comma-separated, decimal points, UTF-8; or its rows as mappings of
        column to number. Columns that are neither parameters, responses nor ``seed`` are ignored.
    parameters : sequence of str
        Columns of the parameters.
    responses : sequence of str
        Columns of the responses. A column ``NAME.standard_error``, as ``grainfit runs export``
        writes it, holds the standard errors of ``NAME``, if there is one. ``NAME_std_error``, its
        name in version 0.1.0, is read too.
    nearest : bool
        Take the nearest recorded run (in the unit cube that the table's ranges span) when there is
        none at the wanted parameters. Nothing is interpolated.
    tolerance : float
        How far a parameter may be from the recorded one, relative to its range in the table.
    name : str
        Shown to the user.

    Raises
    ------
    InputError
        The file cannot be read, is empty, lacks a column, holds something else than finite
        numbers, or holds one run twice: with line and column, all faults at once.
    """

    uses_folder = False

    def __init__(
        self,
        source: str | Path | Sequence[Mapping[str, Any]],
        parameters: Sequence[str],
        responses: Sequence[str],
        *,
        nearest: bool = False,
        tolerance: float = 1e-6,
        name: str = "table",
    ) -> None:
        for key, columns in (("parameters", parameters), ("responses", responses)):
            if isinstance(columns, str) or not columns:
                raise InputError(Fault(key, f"are {columns!r}.", "List the names of the columns."))
        self.name = name
        self._parameters = tuple(parameters)
        self._responses = tuple(responses)
        self._nearest = nearest
        self._tolerance = tolerance
        rows = _read(source, self._parameters, self._responses)
        self._points = np.array([[row[name] for name in self._parameters] for row in rows])
        self._rows = rows
        span = np.ptp(self._points, axis=0)
        # A column with one value only: deviations relative to that value.
        self._scale = np.where(span > 0, span, np.maximum(np.abs(self._points[0]), 1e-300))
        self._hash = hashlib.sha256(json.dumps(rows, sort_keys=True).encode()).hexdigest()

    @property
    def response_names(self) -> tuple[str, ...]:
        """Names of the responses in the table."""
        return self._responses

    def definition(self, parameters: Mapping[str, float], seed: int) -> dict[str, Any]:
        """Return the contents of the table (as a hash), how it is read, parameters and seed.

        Raises
        ------
        InputError
            A parameter is not in the table, is missing, or has no finite value.
        """
        return {
            "solver": self.name,
            "table": self._hash,
            "nearest": self._nearest,
            "tolerance": self._tolerance,
            "parameters": self._values(parameters),
            "seed": int(seed),
        }

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> dict[str, Response]:
        """Look a run up.

        Raises
        ------
        RunFailedError
            No run was recorded there; says which is nearest.
        """
        values = self._values(parameters)
        if workspace.cancelled.is_set():
            raise RunFailedError("stopped by the user", kind="cancelled")
        row = self._pick(self._replicates(values), int(seed))
        return {name: Response(row[name], _standard_error(row, name)) for name in self._responses}

    def _values(self, parameters: Mapping[str, float]) -> dict[str, float]:
        values = finite_parameters(parameters)
        faults = [
            Fault(name, "is not a parameter of the table.", f"It has: {_listed(self._parameters)}.")
            for name in values
            if name not in self._parameters
        ]
        faults += [
            Fault(name, "has no value, and the table has a column of that name.", "Give a value.")
            for name in self._parameters
            if name not in values
        ]
        if faults:
            raise InputError(faults)
        return values

    def _replicates(self, values: Mapping[str, float]) -> list[dict[str, float]]:
        """All recorded runs at these parameters, or at the nearest ones if that is allowed."""
        wanted = np.array([values[name] for name in self._parameters])
        offsets = (self._points - wanted) / self._scale
        same = np.abs(offsets).max(axis=1, initial=0.0) <= self._tolerance
        if not same.any():
            nearest = int(np.linalg.norm(offsets, axis=1).argmin())
            if not self._nearest:
                there = ", ".join(
                    f"{name} = {value:.10g}"
                    for name, value in zip(self._parameters, self._points[nearest], strict=True)
                )
                raise RunFailedError(f"no run is recorded there; the nearest is at {there}")
            apart = (self._points - self._points[nearest]) / self._scale
            same = np.abs(apart).max(axis=1, initial=0.0) <= self._tolerance
        return [self._rows[i] for i in np.flatnonzero(same)]

    @staticmethod
    def _pick(replicates: list[dict[str, float]], seed: int) -> dict[str, float]:
        recorded = [row for row in replicates if row.get(SEED_COLUMN) == seed]
        return recorded[0] if recorded else replicates[seed % len(replicates)]


def _error_columns(response: str) -> list[str]:
    return [f"{response}{suffix}" for suffix in _ERROR_SUFFIXES]


def _standard_error(row: Mapping[str, float], response: str) -> float:
    return next((row[name] for name in _error_columns(response) if name in row), 0.0)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names)


def _read(
    source: str | Path | Sequence[Mapping[str, Any]],
    parameters: tuple[str, ...],
    responses: tuple[str, ...],
) -> list[dict[str, float]]:
    """Read the columns that matter, as numbers."""
    if isinstance(source, (str, Path)):
        file = str(source)
        numbered = _csv_rows(Path(source))
    else:
        file = ""
        numbered = [(f"row {i}", row) for i, row in enumerate(source, start=1)]
    if not numbered:
        raise InputError(Fault("", "holds no runs.", "Give at least one row."), file or "table")
    optional = [SEED_COLUMN, *(name for response in responses for name in _error_columns(response))]
    columns = [*parameters, *responses, *(name for name in optional if name in numbered[0][1])]
    _require_columns(numbered[0][1], (*parameters, *responses), file)
    faults: list[Fault] = []
    rows = [
        {name: _number(row, name, place, faults) for name in columns} for place, row in numbered
    ]
    if not faults:
        faults.extend(_repeated([place for place, _ in numbered], rows, parameters))
    if faults:
        more = len(faults) - _MOST_FAULTS
        rest = [Fault("", f"and {more} more faults.")] if more > 0 else []
        raise InputError(faults[:_MOST_FAULTS] + rest, file)
    return rows


def _csv_rows(path: Path) -> list[tuple[str, Mapping[str, Any]]]:
    lines = read_csv(path)
    header = lines[0][1]
    repeated = [name for name, count in Counter(header).items() if count > 1 and name]
    faults = [Fault(f"column {name}", "is there more than once.") for name in repeated]
    faults += [
        Fault(f"line {number}", f"has {len(line)} cells, and the header {len(header)}.")
        for number, line in lines[1:]
        if len(line) != len(header)
    ]
    if faults:
        raise InputError(faults[:_MOST_FAULTS], str(path))
    return [(f"line {number}", dict(zip(header, line, strict=True))) for number, line in lines[1:]]


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


def _require_columns(row: Mapping[str, Any], wanted: tuple[str, ...], file: str) -> None:
    there = list(row)
    remedy = f"There are: {_listed(there)}."
    if len(there) == 1 and any(mark in there[0] for mark in ";\t"):
        remedy = "Separate columns by commas."
    faults = [Fault(f"column {name}", "is missing.", remedy) for name in wanted if name not in row]
    if faults:
        raise InputError(faults, file)


def _number(row: Mapping[str, Any], name: str, place: str, faults: list[Fault]) -> float:
    where = f"{place}, column {name}"
    if name not in row:
        faults.append(Fault(where, "is missing."))
        return math.nan
    try:
        value = float(row[name])
    except (TypeError, ValueError):
        faults.append(Fault(where, f"is {row[name]!r}, not a number.", "Use a decimal point."))
        return math.nan
    if not math.isfinite(value):
        faults.append(Fault(where, f"is {value}.", "Leave failed runs out."))
    elif name.endswith(_ERROR_SUFFIXES) and value < 0:
        faults.append(Fault(where, f"is {value}; a standard error is not negative."))
    return value


def _repeated(
    places: list[str], rows: list[dict[str, float]], parameters: tuple[str, ...]
) -> Iterator[Fault]:
    """Yield runs recorded twice; only seeds tell replicates from copies."""
    if SEED_COLUMN not in rows[0]:
        return
    first: dict[tuple[float, ...], str] = {}
    for place, row in zip(places, rows, strict=True):
        key = (*(row[name] for name in parameters), row[SEED_COLUMN])
        if first.setdefault(key, place) != place:
            yield Fault(
                place,
                f"has the same parameters and seed as {first[key]}.",
                "Keep one of them, or give them the seeds they were run with.",
            )
