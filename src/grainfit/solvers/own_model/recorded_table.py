"""Look up runs in a recorded table instead of simulating them."""

from __future__ import annotations

import hashlib
import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import override

from grainfit.errors import Fault, InputError, RunFailedError
from grainfit.evaluation import ERROR_SUFFIX, Response
from grainfit.exchange import finite_parameters
from grainfit.options.csv_file import read_csv
from grainfit.solvers.base import Solver, Workspace
from grainfit.solvers.own_model.csv_table import (
    OLD_ERROR_SUFFIX,
    SEED_COLUMN,
    note_old_error_column,
    repeated_runs,
)

_MOST_FAULTS = 20


class RecordedTable(Solver):
    """Solver that finds recorded runs in a CSV file or in rows by their parameters.

    A run is found when every parameter agrees with a recorded one within `tolerance`, relative to
    the range of the table's column. Of several recorded runs at the same parameters (replicates),
    the one with the requested seed is used if the table has it in a column ``seed``; otherwise the
    seed determines which one is used.

    Parameters
    ----------
    source : path or sequence of mapping
        A CSV file with a header, comma-separated, decimal points, UTF-8; or its rows as mappings of
        column to number. Columns that are neither parameters, responses nor ``seed`` are ignored.
    parameters : sequence of str
        Columns of the parameters.
    responses : sequence of str
        Columns of the responses. A column ``NAME.standard_error`` holds the standard errors
        of ``NAME``, if there is one.
    nearest : bool
        Use the nearest recorded run (in the unit cube of the table's ranges) if there is none at
        the requested parameters. Nothing is interpolated.
    tolerance : float
        Largest accepted deviation from a recorded parameter, relative to its range in the table.
    name : str
        Display name.

    Raises
    ------
    InputError
        The file cannot be read, is empty, lacks a column, has values that are not finite numbers,
        or has a run twice; lists all faults with line and column.
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
        # In a column with only one value, deviations are relative to that value.
        self._scale = np.where(span > 0, span, np.maximum(np.abs(self._points[0]), 1e-300))
        self._hash = _hash(rows)

    @property
    @override
    def response_names(self) -> tuple[str, ...]:
        return self._responses

    def model(self) -> Mapping[str, Any]:
        """Return the hash of the table and the options of the lookup."""
        return {
            "solver": self.name,
            "table": self._hash,
            "nearest": self._nearest,
            "tolerance": self._tolerance,
        }

    def run_parameters(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the parameters; check that they are those of the table.

        Raises
        ------
        InputError
            A parameter is not in the table, is missing, or has no finite value.
        """
        return self._values(parameters)

    @override
    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> dict[str, Response]:
        """Look up a run.

        Raises
        ------
        RunFailedError
            No run is recorded there; the message gives the nearest one.
        """
        values = self._values(parameters)
        if workspace.cancelled.is_set():
            raise RunFailedError("stopped by the user", kind="cancelled")
        row = self._pick(self._replicates(values), int(seed))
        return {
            name: Response(row[name], row.get(f"{name}{ERROR_SUFFIX}", 0.0))
            for name in self._responses
        }

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
        """Return all recorded runs at these parameters, or at the nearest ones if allowed."""
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


def _hash(rows: Sequence[Mapping[str, float]]) -> str:
    named = [
        # Version 0.1.0 used this name in the hash; it keeps the identity of the runs.
        {name.replace(ERROR_SUFFIX, OLD_ERROR_SUFFIX): value for name, value in row.items()}
        for row in rows
    ]
    return hashlib.sha256(json.dumps(named, sort_keys=True).encode()).hexdigest()


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names)


def _read(
    source: str | Path | Sequence[Mapping[str, Any]],
    parameters: tuple[str, ...],
    responses: tuple[str, ...],
) -> list[dict[str, float]]:
    """Read the required and optional columns as numbers."""
    if isinstance(source, (str, Path)):
        file = str(source)
        numbered = _csv_rows(Path(source))
    else:
        file = ""
        numbered = [(f"row {i}", row) for i, row in enumerate(source, start=1)]
    if not numbered:
        raise InputError(Fault("", "holds no runs.", "Give at least one row."), file or "table")
    optional = [SEED_COLUMN, *(f"{response}{ERROR_SUFFIX}" for response in responses)]
    columns = [*parameters, *responses, *(name for name in optional if name in numbered[0][1])]
    _require_columns(numbered[0][1], (*parameters, *responses), file)
    old = [note_old_error_column(name, responses, f"column {name}") for name in numbered[0][1]]
    faults = [fault for fault in old if fault]
    rows = [
        {name: _number(row, name, place, faults) for name in columns} for place, row in numbered
    ]
    if not faults:
        faults.extend(_recorded_twice([place for place, _ in numbered], rows, parameters))
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
    elif name.endswith(ERROR_SUFFIX) and value < 0:
        faults.append(Fault(where, f"is {value}; a standard error is not negative."))
    return value


def _recorded_twice(
    places: list[str], rows: list[dict[str, float]], parameters: tuple[str, ...]
) -> Iterator[Fault]:
    if SEED_COLUMN not in rows[0]:
        return iter(())
    columns = (*parameters, SEED_COLUMN)
    keys = (tuple(row[name] for name in columns) for row in rows)
    return repeated_runs(zip(places, keys, strict=True))
