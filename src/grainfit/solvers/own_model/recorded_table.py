"""Look up runs in a recorded table instead of simulating them."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from grainfit.bulk_tests.registry import response_info
from grainfit.contact_models.registry import material_units
from grainfit.errors import Fault, InputError, RunFailedError
from grainfit.evaluation import ERROR_SUFFIX, Response
from grainfit.evaluation.exchange import finite_parameters
from grainfit.options.kinds import Quantity
from grainfit.solvers.base import Solver, SourceRecord, Workspace
from grainfit.solvers.own_model import table_messages as messages
from grainfit.solvers.own_model.csv_table import (
    OLD_ERROR_SUFFIX,
    SEED_COLUMN,
    note_old_error_column,
    repeated_runs,
)
from grainfit.solvers.process import messages as process_messages
from grainfit.table_files import messages as table_messages
from grainfit.table_files.headings import Heading
from grainfit.table_files.reading import Reading, TableFaults, Wanted, column_of, find_column
from grainfit.table_files.table import read_table
from grainfit.units import is_unit


class RecordedTable(Solver):
    """Solver that finds recorded runs in a CSV file or in rows by their parameters.

    A run is found when every parameter agrees with a recorded one within `tolerance`, relative to
    the range of the table's column. Of several recorded runs at the same parameters (replicates),
    the one with the requested seed is used if the table has it in a column ``seed``; otherwise the
    seed determines which one is used.

    Parameters
    ----------
    source : path or sequence of mapping
        A table with a header; or its rows as mappings of column to number. Columns that are
        neither parameters, responses nor ``seed`` are ignored.
    parameters : sequence of str
        Columns of the parameters.
    responses : sequence of str
        Columns of the responses. A column ``NAME.standard_error`` holds the standard errors
        of ``NAME``, if there is one.
    nearest : bool
        Use the nearest recorded run (in the unit cube of the table's ranges) if there is none at
        the requested parameters. Nothing is interpolated, and such a row confirms no answer.
    tolerance : float
        Largest accepted deviation from a recorded parameter, relative to its range in the table.
    name : str
        Display name.
    units : mapping of str to str, optional
        Units of parameters and responses, to convert columns whose headings state others; by
        default those of material parameters and of responses of bulk tests.

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
        units: Mapping[str, str] | None = None,
    ) -> None:
        for key, columns in (("parameters", parameters), ("responses", responses)):
            if isinstance(columns, str) or not columns:
                raise InputError(messages.COLUMNS_NOT_LISTED.fault(key, columns=columns))
        self.name = name
        self._parameters = tuple(parameters)
        self._responses = tuple(responses)
        self._nearest = nearest
        self._tolerance = tolerance
        known = _known_units(self._parameters, self._responses) | dict(units or {})
        recorded = _read(source, self._parameters, self._responses, known)
        rows, self._understood = recorded.rows, recorded.understood
        self._places = recorded.places
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

    @override
    def readiness(self) -> str:
        return f"{self._understood}." if self._understood else super().readiness()

    def run_parameters(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the parameters of the run that is read; check that they are those of the table.

        Raises
        ------
        InputError
            A parameter is not in the table, is missing, or has no finite value.
        """
        values = self._values(parameters)
        if self._nearest and not self._at(values).any():
            return self._nearest_to(values)
        return values

    @override
    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> dict[str, Response]:
        values = self._values(parameters)
        if workspace.cancelled.is_set():
            raise RunFailedError(process_messages.STOPPED(), kind="cancelled")
        row = self._rows[self._pick(self._replicates(values), int(seed))]
        return {
            name: Response(row[name], row.get(f"{name}{ERROR_SUFFIX}", 0.0))
            for name in self._responses
        }

    @override
    def record_of(self, parameters: Mapping[str, float], seed: int) -> SourceRecord | None:
        values = self._values(parameters)
        try:
            index = self._pick(self._replicates(values), int(seed))
        except RunFailedError:
            return None
        recorded = dict(zip(self._parameters, self._points[index].tolist(), strict=True))
        return SourceRecord(self._places[index], recorded, bool(self._at(values)[index]))

    def _values(self, parameters: Mapping[str, float]) -> dict[str, float]:
        values = finite_parameters(parameters)
        there = ", ".join(self._parameters)
        faults = [
            messages.NO_PARAMETER.fault(name, there=there)
            for name in values
            if name not in self._parameters
        ]
        faults += [messages.NO_VALUE.fault(name) for name in self._parameters if name not in values]
        InputError.raise_for(faults)
        return values

    def _offsets(self, values: Mapping[str, float]) -> NDArray[np.float64]:
        """Return how far the recorded runs are from these parameters, in ranges of the table."""
        wanted = np.array([values[name] for name in self._parameters])
        offsets: NDArray[np.float64] = (self._points - wanted) / self._scale
        return offsets

    def _at(self, values: Mapping[str, float]) -> NDArray[np.bool_]:
        """Return which recorded runs are at these parameters."""
        apart = np.abs(self._offsets(values)).max(axis=1, initial=0.0)
        return np.asarray(apart <= self._tolerance)

    def _nearest_to(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the parameters of the nearest recorded run."""
        index = int(np.linalg.norm(self._offsets(values), axis=1).argmin())
        return dict(zip(self._parameters, self._points[index].tolist(), strict=True))

    def _replicates(self, values: Mapping[str, float]) -> list[int]:
        """Return all recorded runs at these parameters, or at the nearest ones if allowed."""
        same = self._at(values)
        if not same.any():
            nearest = self._nearest_to(values)
            if not self._nearest:
                there = ", ".join(f"{name} = {value:.10g}" for name, value in nearest.items())
                raise RunFailedError(messages.NO_RUN_THERE(there=there))
            same = self._at(nearest)
        return np.flatnonzero(same).tolist()

    def _pick(self, replicates: list[int], seed: int) -> int:
        recorded = [index for index in replicates if self._rows[index].get(SEED_COLUMN) == seed]
        return recorded[0] if recorded else replicates[seed % len(replicates)]


def _known_units(parameters: Sequence[str], responses: Sequence[str]) -> dict[str, str]:
    known = {name: response_info(name) for name in responses}
    found = {name: info.unit for name, info in known.items() if info is not None and info.unit}
    return material_units(parameters) | found


def _hash(rows: Sequence[Mapping[str, float]]) -> str:
    named = [
        # Version 0.1.0 used this name in the hash; it keeps the identity of the runs.
        {name.replace(ERROR_SUFFIX, OLD_ERROR_SUFFIX): value for name, value in row.items()}
        for row in rows
    ]
    return hashlib.sha256(json.dumps(named, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class _Recorded:
    """Rows of numbers with their places, and how the table was understood."""

    rows: list[dict[str, float]]
    places: list[str]
    header: str = ""
    understood: str = ""


def _read(
    source: str | Path | Sequence[Mapping[str, Any]],
    parameters: tuple[str, ...],
    responses: tuple[str, ...],
    units: Mapping[str, str],
) -> _Recorded:
    """Read the required and the optional columns, or raise `InputError` with all faults."""
    needed = (*parameters, *responses)
    optional = (SEED_COLUMN, *(f"{response}{ERROR_SUFFIX}" for response in responses))
    faults = TableFaults()
    if isinstance(source, (str, Path)):
        file = str(source)
        recorded = _of_file(Path(source), needed, optional, units, faults)
    else:
        file = "" if source else "table"
        recorded = _of_rows(source, needed, optional, faults)
    _note_negative_errors(recorded, faults)
    if not recorded.rows and not faults.found:
        faults.note(messages.NO_RUNS.fault(recorded.header))
    elif not faults.found:
        for fault in _recorded_twice(recorded, parameters):
            faults.note(fault)
    faults.require_none(file)
    return recorded


def _of_file(
    path: Path,
    needed: tuple[str, ...],
    optional: tuple[str, ...],
    units: Mapping[str, str],
    faults: TableFaults,
) -> _Recorded:
    table = read_table(path)
    found = {name: find_column(table, name, faults) for name in needed}
    found |= {name: column_of(table, name) for name in optional}
    names = {at: name for name, at in found.items() if at is not None}
    wanted = {at: _wanted(table.headings[at], name, units) for at, name in names.items()}
    reading = Reading(table, wanted, faults)
    for heading in reading.ignored:
        where = reading.of_heading(heading.label)
        responses = [name.removesuffix(ERROR_SUFFIX) for name in optional]
        if fault := note_old_error_column(heading.name, responses, where):
            faults.note(fault)
    reading.note_slips(optional)
    faults.require_none(str(path))
    rows = reading.rows()
    read = [{name: reading.number(row, at) for at, name in names.items()} for row in rows]
    return _Recorded(
        [{name: value for name, value in row.items() if value is not None} for row in read],
        [f"line {row.line}" for row in rows],
        f"line {table.line}",
        reading.describe(),
    )


def _wanted(heading: Heading, name: str, units: Mapping[str, str]) -> Wanted:
    unit = units.get(name.removesuffix(ERROR_SUFFIX), "")
    # To know units takes a while, and only a heading with one needs it.
    converts = unit and heading.unit is not None and is_unit(unit)
    quantity = Quantity(unit if converts else None)
    # In a heading that is the name as a whole, brackets are no unit.
    given = "" if heading.text == name else None
    return Wanted(quantity, name, given=given, own_unit=unit, is_checked=False)


def _of_rows(
    rows: Sequence[Mapping[str, Any]],
    needed: tuple[str, ...],
    optional: tuple[str, ...],
    faults: TableFaults,
) -> _Recorded:
    names = [*needed, *(name for name in optional if rows and name in rows[0])]
    places = [f"row {number}" for number in range(1, len(rows) + 1)]
    read = [
        {name: _number(row, name, place, faults) for name in names}
        for place, row in zip(places, rows, strict=True)
    ]
    return _Recorded(read, places)


def _number(row: Mapping[str, Any], name: str, place: str, faults: TableFaults) -> float:
    where = f"{place}, column {name}"
    if name not in row:
        faults.note(table_messages.MISSING.fault(where, remedy="Give it in each row."))
        return math.nan
    try:
        value = float(row[name])
    except (TypeError, ValueError):
        shown, remedy = repr(row[name]), table_messages.USE_A_POINT()
        faults.note(table_messages.NOT_A_NUMBER.fault(where, shown=shown, remedy=remedy))
        return math.nan
    if not math.isfinite(value):
        faults.note(table_messages.NOT_FINITE.fault(where, number=value))
    return value


def _note_negative_errors(recorded: _Recorded, faults: TableFaults) -> None:
    for place, row in zip(recorded.places, recorded.rows, strict=True):
        for name, value in row.items():
            if name.endswith(ERROR_SUFFIX) and value < 0:
                where = f"{place}, column {name}"
                faults.note(messages.NEGATIVE_ERROR.fault(where, value=value))


def _recorded_twice(recorded: _Recorded, parameters: tuple[str, ...]) -> Iterator[Fault]:
    if SEED_COLUMN not in recorded.rows[0]:
        return iter(())
    columns = (*parameters, SEED_COLUMN)
    keys = (tuple(row[name] for name in columns) for row in recorded.rows)
    return repeated_runs(zip(recorded.places, keys, strict=True))
