"""Read a table of runs from elsewhere: report all its faults at once, with their lines."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grainfit.bulk_tests.registry import bulk_tests
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.calibration_file.content import TestSpecification
from grainfit.errors import Fault, InputError
from grainfit.evaluation import ERROR_SUFFIX, Response
from grainfit.options.csv_file import read_csv
from grainfit.options.kinds import Quantity, suggest
from grainfit.options.places import Findings, Place
from grainfit.solvers.own_model.csv_table import (
    SEED_COLUMN,
    note_old_error_column,
    repeated_runs,
)
from grainfit.units import UnitError, is_unit, to_unit
from grainfit.work_folder.run_columns import COMMON_COLUMNS

_HEADER = re.compile(r"(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?")
_NO_UNIT = ("", "-", "–", "1")
_MOST_FAULTS = 50
#: Columns of tables that grainfit has written.
_IDENTITY_COLUMN, _TEST_COLUMN = "identity", "test"
_LARGEST_SEED = 2**63 - 1

#: Number of a line in the file, and its cells.
_Line = tuple[int, list[str]]


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
    """

    line: int
    parameters: Mapping[str, float]
    responses: Mapping[str, Response]
    seed: int | None = None


@dataclass(frozen=True)
class _Column:
    """Content of a column, the unit it was written in, and the unit to convert it to."""

    name: str
    quantity: Quantity
    written: str = ""


def read_import_table(
    path: Path, setup: CalibrationSetup, test: TestSpecification
) -> tuple[list[TableRow], list[str]]:
    """Read the runs of a test from a CSV file.

    It may hold runs of other tests, too, if a column ``test`` tells them apart.

    Parameters
    ----------
    path : Path
        The file: a header and one line for each run.
    setup : CalibrationSetup
        Names the parameters, their units and physical limits.
    test : TestSpecification
        Names the responses.

    Returns
    -------
    rows : list of TableRow
        The runs.
    ignored : list of str
        Columns that are not used.

    Raises
    ------
    InputError
        With every fault of the table.
    """
    return _Reader(path, setup, test).read()


class _Reader:
    def __init__(self, path: Path, setup: CalibrationSetup, test: TestSpecification) -> None:
        self._path = path
        self._assembly = setup
        self._test = test
        self._faults: list[Fault] = []
        names = [parameter.name for parameter in setup.problem.parameters]
        scopes = {scope.name: scope.parameters for scope in setup.problem.tests}
        self._free = list(scopes.get(test.name, names))
        self._fixed = setup.file.fixed
        self._responses = _response_quantities(test)
        self._needed = {*self._free, *(target.name for target in test.targets)}
        self._of_others = {*names}.union(*map(_response_quantities, setup.file.tests))
        self._columns: dict[int, _Column] = {}
        self._is_export = False

    def read(self) -> tuple[list[TableRow], list[str]]:
        self._require_numbers()
        (number, header), *lines = read_csv(self._path)
        lines = self._of_test(header, lines)
        if self._is_export:
            self._take_further_responses(header)
        ignored = self._read_header(number, header, [cells for _, cells in lines])
        if not lines:
            self._note(number, "", "holds no runs.", "Give one line for each run.")
        rows = []
        for line, cells in lines:
            if len(cells) != len(header):
                message = f"has {len(cells)} cells, and the header {len(header)}."
                self._note(line, "", message, "Decimals have a point, not a comma.")
            else:
                rows.append(self._row(line, cells))
        self._faults += repeated_runs(
            (f"line {row.line}", (*row.parameters.values(), row.seed))
            for row in rows
            if row.seed is not None and len(row.parameters) == len(self._free)
        )
        self._raise()
        return rows, ignored

    def _require_numbers(self) -> None:
        for curve in self._test.curves:
            self._faults.append(
                Fault(
                    curve.name,
                    "is a curve, and a table of runs holds single numbers only.",
                    "A work folder holds curves: give the one that the runs are in (--runs DIR, "
                    "--runs-from DIR)"
                    + (
                        f", or leave the curve out of the targets of test {self._test.name!r}."
                        if self._test.targets
                        else "."
                    ),
                )
            )
        self._raise()

    def _of_test(self, header: list[str], lines: list[_Line]) -> list[_Line]:
        """Return the lines of the test, where a column tells of which test they are."""
        if _TEST_COLUMN not in header:
            return lines
        column = header.index(_TEST_COLUMN)
        tests = [cells[column] if column < len(cells) else "" for _, cells in lines]
        name = self._test.name
        self._is_export = _IDENTITY_COLUMN in header and name in tests
        # In a table without this test, the tests may have had other names when they were run.
        others = set(tests) if name in tests else {test.name for test in self._assembly.file.tests}
        return [
            line for line, test in zip(lines, tests, strict=True) if test not in others - {name, ""}
        ]

    def _take_further_responses(self, header: list[str]) -> None:
        """Note responses that are no targets, in a table that grainfit has written."""
        for name in header:
            if f"{name}{ERROR_SUFFIX}" in header and name not in self._of_others:
                self._responses.setdefault(name, Quantity(None))

    # --- the header --------------------------------------------------------------------------

    def _read_header(self, line: int, header: list[str], cells: list[list[str]]) -> list[str]:
        ignored = []
        for index, text in enumerate(header):
            match = _HEADER.fullmatch(text)
            name, unit = (match["name"], match["unit"]) if match else (text, None)
            is_empty = not any(index < len(row) and row[index] for row in cells)
            if not name and is_empty:
                continue
            if self._is_unused(name, is_empty):
                ignored += [] if is_empty or name == _TEST_COLUMN else [name]
                continue
            quantity = self._quantity(name)
            if quantity is None:
                self._note_unknown(line, index, name, header)
                continue
            self._note_wrong_unit(line, name, unit, quantity)
            self._columns[index] = _Column(name, quantity, self._conversion(unit, quantity))
        there = [column.name for column in self._columns.values()]
        for name, count in Counter(there).items():
            if count > 1:
                self._note(line, f"column {name}", "is there more than once.", "Keep one of them.")
        for name in [*self._free, *(target.name for target in self._test.targets)]:
            if name not in there:
                self._note(line, f"column {name}", "is missing.", self._how_to_separate(header))
        return ignored

    def _quantity(self, name: str) -> Quantity | None:
        if name == SEED_COLUMN:
            return Quantity("")
        if name in self._responses:
            return self._responses[name]
        response = name.removesuffix(ERROR_SUFFIX)
        if name.endswith(ERROR_SUFFIX) and response in self._responses:
            return Quantity(self._responses[response].unit, lowest=0.0)
        if name in self._free or name in self._fixed:
            return self._assembly.quantity(name)
        return None

    def _is_unused(self, name: str, is_empty: bool) -> bool:
        """Return True for a column about the runs, or of other tests."""
        if name in COMMON_COLUMNS:
            return name != SEED_COLUMN
        if self._quantity(name) is not None:
            return False
        return name.removesuffix(ERROR_SUFFIX) in self._of_others or (is_empty and self._is_export)

    def _note_unknown(self, line: int, index: int, name: str, header: list[str]) -> None:
        if not name:
            self._note(line, f"column {index + 1}", "has no name.", "Name it, or remove it.")
            return
        if fault := note_old_error_column(name, self._responses, f"line {line}, column {name}"):
            self._faults.append(fault)
            return
        known = [*self._free, *self._responses, SEED_COLUMN]
        known += [f"{response}{ERROR_SUFFIX}" for response in self._responses]
        self._note(
            line,
            f"column {name}",
            f"is neither a parameter of the file nor a response of the test {self._test.name!r}.",
            self._how_to_separate(header) or suggest(name, known, "It can have"),
        )

    @staticmethod
    def _how_to_separate(header: list[str]) -> str:
        alone = len(header) == 1 and any(mark in header[0] for mark in ";\t")
        return "Separate columns by commas." if alone else ""

    def _note_wrong_unit(self, line: int, name: str, unit: str | None, quantity: Quantity) -> None:
        if unit is None or unit.strip() in _NO_UNIT or unit.strip() == self._own_unit(name):
            if unit is not None and unit.strip() in _NO_UNIT and quantity.unit:
                message = f"is said to have no unit, and is in {quantity.unit}."
                self._note(line, f"column {name}", message, "Name the unit that it is in.")
            return
        if quantity.unit is None:
            message = f"is in {unit!r}, and nothing says which unit your model takes."
            remedy = 'Name the unit in the calibration file, such as unit = "J/m^3".'
            self._note(line, f"column {name}", message, remedy)
            return
        try:
            to_unit(f"1 {unit}", quantity.unit)
        except UnitError as error:
            self._note(line, f"column {name}", error.message, error.remedy)

    def _own_unit(self, name: str) -> str:
        """Unit of an own parameter or response, which may be any text."""
        units = {parameter.name: parameter.unit for parameter in self._assembly.problem.parameters}
        units |= {target.name: target.unit for target in self._test.targets}
        return units.get(name.removesuffix(ERROR_SUFFIX), "")

    @staticmethod
    def _conversion(unit: str | None, quantity: Quantity) -> str:
        """Unit to convert from; empty when there is nothing to convert."""
        written = (unit or "").strip()
        return "" if written in (*_NO_UNIT, quantity.unit) or not quantity.unit else written

    # --- a line ------------------------------------------------------------------------------

    def _row(self, line: int, cells: list[str]) -> TableRow:
        values: dict[str, float] = {}
        seed = None
        for index, column in self._columns.items():
            if column.name == SEED_COLUMN:
                seed = self._seed(line, cells[index])
            elif (value := self._value(line, cells[index], column)) is not None:
                values[column.name] = value
        for name, value in values.items():
            self._note_other_material(line, name, value)
        return TableRow(
            line,
            {name: values[name] for name in self._free if name in values},
            {
                name: Response(values[name], values.get(f"{name}{ERROR_SUFFIX}", 0.0))
                for name in self._responses
                if name in values
            },
            seed,
        )

    def _value(self, line: int, text: str, column: _Column) -> float | None:
        if not text:
            if column.name not in self._needed:
                return None
            self._note(line, column.name, "has no value.", "Leave failed runs out.")
            return None
        number = _number(text)
        if number is None:
            self._note(line, column.name, f"is {text!r}, not a number.", "Use a decimal point.")
            return None
        path = tuple(column.name.split("."))
        findings = Findings(self._path.parent, {path[:1]: line})
        if column.written and math.isfinite(number):
            try:
                number = to_unit(f"{number!r} {column.written}", column.quantity.unit or "")
            except UnitError as error:
                self._note(line, column.name, error.message, error.remedy)
                return None
        value = column.quantity.read_converted(number, Place(findings, path))
        self._faults += findings.faults
        return value

    def _note_other_material(self, line: int, name: str, value: float) -> None:
        if name not in self._fixed or math.isclose(value, self._fixed[name], rel_tol=1e-9):
            return
        self._note(
            line,
            name,
            f"is {value:g}, and {self._fixed[name]:g} in the calibration file: this is a run of "
            "another material.",
            "Leave it out, or calibrate with that value.",
        )

    def _seed(self, line: int, text: str) -> int | None:
        if not text:
            return None
        # Where a seed is missing in a column, spreadsheets and data frames write 7.0 for 7.
        digits = re.fullmatch(r"([0-9]{1,19})(?:\.0*)?", text)
        seed = int(digits[1]) if digits else -1
        if 0 <= seed <= _LARGEST_SEED:
            return seed
        self._note(line, SEED_COLUMN, f"is {text!r}.", "A seed is a whole number, 0 or above.")
        return None

    # --- faults ------------------------------------------------------------------------------

    def _note(self, line: int, what: str, message: str, remedy: str = "") -> None:
        self._faults.append(Fault(f"line {line}{', ' if what else ''}{what}", message, remedy))

    def _raise(self) -> None:
        more = len(self._faults) - _MOST_FAULTS
        rest = [Fault("", f"and {more} more faults.")] if more > 0 else []
        if self._faults:
            raise InputError(self._faults[:_MOST_FAULTS] + rest, str(self._path))


def _number(text: str) -> float | None:
    # Python reads 1_000 as a thousand; in a table it means something else.
    try:
        return None if "_" in text else float(text)
    except ValueError:
        return None


def _response_quantities(test: TestSpecification) -> dict[str, Quantity]:
    """Quantities that a test yields, by name."""
    simulated = bulk_tests().get(test.type)
    if simulated is not None:
        return {name: Quantity(info.unit) for name, info in simulated.responses.items()}
    return {
        target.name: Quantity(target.unit if target.unit and is_unit(target.unit) else None)
        for target in test.targets
    }
