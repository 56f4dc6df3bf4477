"""Read a table of runs from elsewhere: report all its faults at once, with their places."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from grainfit.bulk_tests.registry import bulk_tests
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.calibration_file.content import TestSpecification
from grainfit.errors import Fault
from grainfit.evaluation import ERROR_SUFFIX, Response
from grainfit.options.kinds import Quantity
from grainfit.solvers.own_model import table_messages
from grainfit.solvers.own_model.csv_table import SEED_COLUMN, note_old_error_column, repeated_runs
from grainfit.table_files.dialects import Row
from grainfit.table_files.reading import Reading, TableFaults, Wanted, column_of, find_column
from grainfit.table_files.table import Table, read_table
from grainfit.units import is_unit
from grainfit.work_folder import messages

_MOST_FAULTS = 50
#: Columns of tables that grainfit has written.
_IDENTITY_COLUMN, _TEST_COLUMN = "identity", "test"
_SECONDS_COLUMN, _ENDED_COLUMN = "seconds", "ended"
_LARGEST_SEED = 2**63 - 1


@dataclass(frozen=True)
class TableRow:
    """One run of a table, in SI units and degrees.

    Parameters
    ----------
    line : int
        Line in the file, counted from 1.
    parameters : mapping of str to float
        Values of the free parameters that the test depends on.
    responses : mapping of str to Response
        Responses of the run.
    seed : int, optional
        Its insertion seed, when the table gives one.
    seconds, ended : float
        Its wall time, s, and its end, seconds since the epoch, of a table that grainfit has
        written; else 0.
    """

    line: int
    parameters: Mapping[str, float]
    responses: Mapping[str, Response]
    seed: int | None = None
    seconds: float = 0.0
    ended: float = 0.0


@dataclass(frozen=True)
class ImportTable:
    """The runs of a test, from a table.

    Parameters
    ----------
    rows : list of TableRow
        The runs.
    ignored : list of str
        Columns that are not used.
    understood : str
        How the table was understood, in one line.
    """

    rows: list[TableRow]
    ignored: list[str]
    understood: str


def read_import_table(path: Path, setup: CalibrationSetup, test: TestSpecification) -> ImportTable:
    """Read the runs of a test from a table.

    It may hold runs of other tests, too, if a column ``test`` tells them apart.

    Parameters
    ----------
    path : Path
        The file: a header and one line for each run.
    setup : CalibrationSetup
        Names the parameters, their units and physical limits.
    test : TestSpecification
        Names the responses.

    Raises
    ------
    InputError
        With every fault of the table.
    """
    return _Reader(path, setup, test).read()


class _Reader:
    def __init__(self, path: Path, setup: CalibrationSetup, test: TestSpecification) -> None:
        self._path = path
        self._setup = setup
        self._test = test
        self._faults = TableFaults(_MOST_FAULTS)
        names = [parameter.name for parameter in setup.problem.parameters]
        scopes = {scope.name: scope.parameters for scope in setup.problem.tests}
        self._free = list(scopes.get(test.name, names))
        self._fixed = setup.file.fixed
        self._ended: int | None = None
        self._responses = _response_quantities(test)
        self._needed = list(dict.fromkeys([*self._free, *(t.name for t in test.targets)]))
        self._of_file = {*names, *self._fixed}.union(*map(_response_quantities, setup.file.tests))

    def read(self) -> ImportTable:
        self._require_numbers()
        table = read_table(self._path)
        whole, table = table, self._of_test(table)
        found = self._columns(table)
        names = {at: name for name, at in found.items()}
        wanted = {at: self._wanted(name) for at, name in names.items()}
        ended = self._ended = self._own_column(table, _ENDED_COLUMN)
        texts = [*(column_of(table, name) for name in (SEED_COLUMN, _TEST_COLUMN)), ended]
        reading = Reading(table, wanted, self._faults, [at for at in texts if at is not None])
        self._note_slips(reading, found)
        if not table.rows and not self._faults.found:
            self._faults.note(table_messages.NO_RUNS.fault(f"line {whole.line}"))
        rows = [self._row(reading, row, names) for row in reading.rows()]
        for fault in self._repeated(rows):
            self._faults.note(fault)
        self._faults.require_none(str(self._path))
        return ImportTable(rows, [one.label for one in reading.ignored], reading.describe())

    def _require_numbers(self) -> None:
        for curve in self._test.curves:
            message = messages.CURVE_BESIDE_NUMBERS if self._test.targets else messages.CURVE
            self._faults.note(message.fault(curve.name, test=self._test.name))
        self._faults.require_none(str(self._path))

    def _of_test(self, table: Table) -> Table:
        """Return the table with the rows of the test, where a column tells of which they are."""
        column = column_of(table, _TEST_COLUMN)
        if column is None:
            return table
        tests = [row.cells[column] if column < len(row.cells) else "" for row in table.rows]
        name = self._test.name
        if column_of(table, _IDENTITY_COLUMN) is not None and name in tests:
            self._take_further_responses(table)
        # In a table without this test, the tests may have had other names when they were run.
        others = set(tests) if name in tests else {test.name for test in self._setup.file.tests}
        kept = zip(table.rows, tests, strict=True)
        return table.of_rows(tuple(row for row, test in kept if test not in others - {name, ""}))

    def _take_further_responses(self, table: Table) -> None:
        """Add responses that are no targets, in a table that grainfit has written."""
        texts = {one.text for one in table.headings}
        for name in texts - self._of_file:
            if f"{name}{ERROR_SUFFIX}" in texts:
                self._responses.setdefault(name, Quantity(None))

    # --- columns -----------------------------------------------------------------------------

    def _columns(self, table: Table) -> dict[str, int]:
        """Return the positions of all columns with numbers that belong to the test."""
        needed = {name: find_column(table, name, self._faults) for name in self._needed}
        errors = [f"{name}{ERROR_SUFFIX}" for name in self._responses]
        others = [*self._fixed, *self._responses, *errors]
        found = needed | {name: column_of(table, name) for name in others if name not in needed}
        if _SECONDS_COLUMN not in found:
            found[_SECONDS_COLUMN] = self._own_column(table, _SECONDS_COLUMN)
        return {name: at for name, at in found.items() if at is not None}

    def _own_column(self, table: Table, name: str) -> int | None:
        """Return the position of a column about the runs, in a table that grainfit has written."""
        is_own = column_of(table, _IDENTITY_COLUMN) is not None and name not in self._of_file
        return column_of(table, name) if is_own else None

    def _wanted(self, name: str) -> Wanted:
        response = name.removesuffix(ERROR_SUFFIX)
        if name == _SECONDS_COLUMN and name not in self._of_file:
            return Wanted(Quantity("s", lowest=0.0), name, may_be_empty=True)
        if name in self._responses:
            quantity = self._responses[name]
        elif response != name and response in self._responses:
            quantity = Quantity(self._responses[response].unit, lowest=0.0)
        else:
            quantity = self._setup.quantity(name)
        units = {one.name: one.unit for one in self._setup.problem.parameters}
        units |= {target.name: target.unit for target in self._test.targets}
        empty = name not in self._needed
        return Wanted(quantity, name, own_unit=units.get(response, ""), may_be_empty=empty)

    def _note_slips(self, reading: Reading, found: Mapping[str, int]) -> None:
        for heading in reading.ignored:
            where = reading.of_heading(heading.label)
            if fault := note_old_error_column(heading.name, self._responses, where):
                self._faults.note(fault)
        errors = [f"{name}{ERROR_SUFFIX}" for name in self._responses]
        reading.note_slips(name for name in (SEED_COLUMN, *errors) if name not in found)

    # --- rows --------------------------------------------------------------------------------

    def _row(self, reading: Reading, row: Row, names: Mapping[int, str]) -> TableRow:
        read = {name: reading.number(row, at) for at, name in names.items()}
        values = {name: value for name, value in read.items() if value is not None}
        for name, value in values.items():
            self._note_other_material(row.line, name, value)
        seed = column_of(reading.table, SEED_COLUMN)
        return TableRow(
            row.line,
            {name: values[name] for name in self._free if name in values},
            {
                name: Response(values[name], values.get(f"{name}{ERROR_SUFFIX}", 0.0))
                for name in self._responses
                if name in values
            },
            None if seed is None else self._seed(row.line, row.cells[seed]),
            0.0 if _SECONDS_COLUMN in self._of_file else values.get(_SECONDS_COLUMN, 0.0),
            0.0 if self._ended is None else _moment(row.cells[self._ended]),
        )

    def _note_other_material(self, line: int, name: str, value: float) -> None:
        if name not in self._fixed or math.isclose(value, self._fixed[name], rel_tol=1e-9):
            return
        where, fixed = f"line {line}, column {name}", self._fixed[name]
        self._faults.note(messages.OTHER_MATERIAL.fault(where, value=value, fixed=fixed))

    def _seed(self, line: int, text: str) -> int | None:
        if not text:
            return None
        # Where a seed is missing in a column, spreadsheets and data frames write 7.0 for 7.
        digits = re.fullmatch(r"([0-9]{1,19})(?:[.,]0*)?", text)
        seed = int(digits[1]) if digits else -1
        if 0 <= seed <= _LARGEST_SEED:
            return seed
        where = f"line {line}, column {SEED_COLUMN}"
        self._faults.note(messages.NO_SEED.fault(where, text=text))
        return None

    def _repeated(self, rows: list[TableRow]) -> Iterator[Fault]:
        return repeated_runs(
            (f"line {row.line}", (*row.parameters.values(), row.seed))
            for row in rows
            if row.seed is not None and len(row.parameters) == len(self._free)
        )


def _moment(text: str) -> float:
    """Return a time of an export in seconds since the epoch; 0 where a spreadsheet changed it."""
    try:
        return datetime.fromisoformat(text).timestamp()
    except (ValueError, OverflowError, OSError):
        return 0.0


def _response_quantities(test: TestSpecification) -> dict[str, Quantity]:
    """Quantities that a test yields, by name."""
    simulated = bulk_tests().get(test.type)
    if simulated is not None:
        return {name: Quantity(info.unit) for name, info in simulated.responses.items()}
    return {
        target.name: Quantity(target.unit if target.unit and is_unit(target.unit) else None)
        for target in test.targets
    }
