"""Runs as a table: one row for each, with what it was made of and what came of it."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from operator import ge, gt, le, lt
from typing import Any, get_args

from grainfit.campaign.store.records import RunRecord, RunStatus
from grainfit.campaign.store.store import RunStore
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.errors import Fault, InputError
from grainfit.units import UnitError, to_unit

Cell = str | int | float | datetime | None

#: Columns that every table of runs has, before those of parameters and responses.
COMMON_COLUMNS = (
    "identity",
    "test",
    "status",
    "kind",
    "reason",
    "origin",
    "solver",
    "version",
    "seed",
    "seconds",
    "ended",
)
_NUMBERS = ("seed", "seconds")
ERROR_SUFFIX = ".standard_error"
_CONDITION = re.compile(r"\s*(?P<name>[^<>=!]+?)\s*(?P<operator><=|>=|==|!=|=|<|>)(?P<value>.+)")
_NAMED_RUNS = 5
_CONDITION_FORM = "Write name, operator and value, such as 'particle.density > 2000'."


@dataclass(frozen=True)
class RunRow:
    """A run and its cells.

    Parameters
    ----------
    record : RunRecord
        The run.
    cells : mapping of str to value
        By column, those of other runs left out. SI units, angles in degrees.
    """

    record: RunRecord
    cells: Mapping[str, Cell]


class RunTable:
    """Runs and the columns that they have together.

    Parameters
    ----------
    records : iterable of RunRecord
        The runs, in order.
    """

    def __init__(self, records: Iterable[RunRecord]) -> None:
        records = list(records)
        inputs = [record.definition.parameters for record in records]
        names = _distinct(name for given in inputs for name in given)
        responses = _distinct(name for record in records for name in record.responses)
        taken = set(COMMON_COLUMNS)
        self._parameters = {n: _free(n, "parameter", taken) for n in names}
        self._responses = {n: _free(n, "response", taken) for n in responses}
        self._errors = {
            n: _free(f"{column}{ERROR_SUFFIX}", "response", taken)
            for n, column in self._responses.items()
        }
        self.rows: Sequence[RunRow] = [
            RunRow(record, self._cells(record, given))
            for record, given in zip(records, inputs, strict=True)
        ]
        self._units = {"seconds": "s"} | self._units_of_columns()

    @property
    def parameters(self) -> tuple[str, ...]:
        """Columns of the parameters."""
        return tuple(self._parameters.values())

    @property
    def responses(self) -> tuple[str, ...]:
        """Columns of the responses, without their standard errors."""
        return tuple(self._responses.values())

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns, in order."""
        found = [*COMMON_COLUMNS, *self._parameters.values()]
        for name, column in self._responses.items():
            found += [column, self._errors[name]]
        return tuple(found)

    def select(
        self,
        status: str | None = None,
        test: str | None = None,
        where: Iterable[str] = (),
    ) -> list[RunRow]:
        """Return the rows that meet all conditions.

        Parameters
        ----------
        status, test : str, optional
            Status and name of the test.
        where : iterable of str
            Conditions on numbers, such as ``particle.density > 2 g/cm^3`` or ``seconds < 60``. A
            run that does not have the number does not meet the condition.

        Raises
        ------
        InputError
            A condition cannot be read, or no run has what it names.
        """
        faults: list[Fault] = []
        conditions = [self._condition(text, faults) for text in where]
        tests = _distinct(row.record.test for row in self.rows)
        for key, wanted, there in (("status", status, get_args(RunStatus)), ("test", test, tests)):
            if wanted is not None and there and wanted not in there:
                faults.append(Fault(f"--{key}", f"is {wanted!r}.", _suggestion(wanted, there)))
        if faults:
            raise InputError(faults)
        return [
            row
            for row in self.rows
            if status in (None, row.record.status)
            and test in (None, row.record.test)
            and all(condition(row) for condition in conditions)
        ]

    def sort(self, rows: Iterable[RunRow], by: str) -> list[RunRow]:
        """Return rows in the order of a column; with ``-`` before its name, the largest first.

        Rows that have nothing in this column come last.

        Raises
        ------
        InputError
            There is no such column.
        """
        name = by.removeprefix("-").strip()
        if name not in self.columns:
            raise InputError(
                Fault("--sort", f"no run has {name!r}.", _suggestion(name, self.columns))
            )
        rows = list(rows)
        with_value = [row for row in rows if row.cells.get(name) is not None]
        without = [row for row in rows if row.cells.get(name) is None]

        def value(row: RunRow) -> Any:
            return row.cells[name]

        return sorted(with_value, key=value, reverse=by.startswith("-")) + without

    def _cells(self, record: RunRecord, given: Mapping[str, float]) -> dict[str, Cell]:
        definition = record.definition
        cells: dict[str, Cell] = {
            "identity": record.identity,
            "test": record.test,
            "status": record.status,
            "kind": record.kind,
            "reason": record.reason,
            "origin": record.origin,
            "solver": _text(definition.model.get("solver")),
            "version": _text(definition.model.get("version")),
            "seed": definition.seed,
            "seconds": record.seconds,
            "ended": _moment(record.ended),
        }
        cells |= {self._parameters[name]: value for name, value in given.items()}
        for name, response in record.responses.items():
            cells[self._responses[name]] = response.value
            cells[self._errors[name]] = response.standard_error
        return cells

    def _units_of_columns(self) -> dict[str, str]:
        """Units that do not depend on whose model it is."""
        units = {
            column: MATERIAL_PARAMETERS[name].unit
            for name, column in self._parameters.items()
            if name in MATERIAL_PARAMETERS
        }
        for row in self.rows:
            test = row.record.definition.model.get("test")
            if isinstance(test, Mapping) and test.get("type") == "heap":
                return units | self._heap_units()
        return units

    def _heap_units(self) -> dict[str, str]:
        from grainfit.bulk_tests.heap import HeapTest

        others = {
            name
            for row in self.rows
            if not isinstance(row.record.definition.model.get("test"), Mapping)
            for name in row.record.responses
        }
        units: dict[str, str] = {}
        for name, unit in HeapTest.response_units.items():
            if name in self._responses and name not in others:
                units |= {self._responses[name]: unit, self._errors[name]: unit}
        return units

    def _condition(self, text: str, faults: list[Fault]) -> Callable[[RunRow], bool]:
        match = _CONDITION.fullmatch(text)
        if match is None:
            faults.append(Fault("--where", f"{text!r} is not a condition.", _CONDITION_FORM))
            return lambda _row: False
        name = match["name"]
        known = [c for c in self.columns if c not in COMMON_COLUMNS or c in _NUMBERS]
        if name not in known:
            message = f"no run has a number called {name!r}."
            faults.append(Fault("--where", message, _suggestion(name, known)))
            return lambda _row: False
        try:
            limit = self._limit(match["value"].strip(), self._units.get(name))
        except UnitError as error:
            faults.append(Fault("--where", f"{name}: {error.message}", error.remedy))
            return lambda _row: False
        holds = _OPERATORS[match["operator"]]
        return lambda row: _holds(row.cells.get(name), holds, limit)

    @staticmethod
    def _limit(text: str, unit: str | None) -> float:
        try:
            value = float(text)
        except ValueError:
            if unit is None:
                raise UnitError(
                    f"{text!r} is not a number.",
                    "What is given and yielded by models of your own is compared as it is.",
                ) from None
            return to_unit(text, unit)
        if math.isnan(value):
            raise UnitError(f"{text!r} is not a number.", "Nothing is above or below it.")
        return value


def find_run(store: RunStore, identity: str) -> RunRecord:
    """Return the run whose identity is, or begins like, this.

    Raises
    ------
    InputError
        There is none, or there are several.
    """
    wanted = identity.strip().lower()
    found = sorted(known for known in store.identities() if known.startswith(wanted) and wanted)
    if wanted in found:
        found = [wanted]
    record = store.find(found[0]) if len(found) == 1 else None
    if record is not None:
        return record
    if not found:
        raise InputError(
            Fault(
                "",
                f"there is no run {identity!r} in {store.place}.",
                "'grainfit runs list' names the runs.",
            )
        )
    some = ", ".join(found[:_NAMED_RUNS]) + (", ..." if len(found) > _NAMED_RUNS else "")
    raise InputError(
        Fault(
            "", f"{identity!r} is the beginning of {len(found)} runs: {some}.", "Give more of it."
        )
    )


def _close(value: float, limit: float) -> bool:
    # What was converted from one unit to another may differ in the last digit.
    return math.isclose(value, limit, rel_tol=1e-12)


_OPERATORS: Mapping[str, Callable[[float, float], bool]] = {
    "<": lt,
    "<=": le,
    ">": gt,
    ">=": ge,
    "=": _close,
    "==": _close,
    "!=": lambda value, limit: not _close(value, limit),
}


def _holds(cell: Cell, holds: Callable[[float, float], bool], limit: float) -> bool:
    return isinstance(cell, (int, float)) and holds(cell, limit)


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""


def _moment(seconds: float) -> datetime | None:
    try:
        return datetime.fromtimestamp(seconds, UTC) if seconds else None
    except (ValueError, OverflowError, OSError):
        return None


def _distinct(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(names))


def _free(name: str, kind: str, taken: set[str]) -> str:
    """Take a column name that no other column has."""
    column = next(c for c in _candidates(name, kind) if c not in taken)
    taken.add(column)
    return column


def _candidates(name: str, kind: str) -> Iterator[str]:
    while True:
        yield name
        name = f"{kind}.{name}"


def _suggestion(wrong: str, known: Sequence[str]) -> str:
    close = difflib.get_close_matches(wrong[:64], known, n=1)
    if close:
        return f"Did you mean {close[0]!r}?"
    return f"There are: {', '.join(known)}."
