"""Takes runs that were made elsewhere into a work folder, as runs of a calibration file's test."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

from grainfit.assemble import Assembly
from grainfit.calibration_file.model import TestSpecification
from grainfit.campaign.identity import run_identity
from grainfit.campaign.known import runs_of
from grainfit.campaign.records import RunRecord
from grainfit.campaign.store import RunStore
from grainfit.campaign.workdir import hold, recover
from grainfit.errors import Fault, InputError, SolverNotFoundError
from grainfit.import_table import TableRow, read_import_table
from grainfit.solvers.base import Solver

#: Runs whose seed is not known get the ones from here on: no calibration asks for seeds above
#: 900,000,000.
FIRST_SEED = 1_000_000_001
_NAMED_LINES = 5


@dataclass(frozen=True)
class Imported:
    """What came of an import.

    Parameters
    ----------
    test : str
        Test that they are runs of.
    new, known, replaced : int
        Runs that are there now and were not, that were there already, and that an earlier import of
        this table had given other responses.
    usable : int
        Parameter sets, of all runs in the work folder, that a calibration of the file can learn
        from.
    notices : tuple of str
        What the user should know.
    """

    test: str
    new: int
    known: int
    replaced: int
    usable: int
    notices: tuple[str, ...] = ()


def import_runs(assembly: Assembly, table: Path, folder: Path, test: str | None = None) -> Imported:
    """Take the runs of a CSV table into a work folder.

    Rows without a seed are runs of seeds of their own, so that those with equal parameters count as
    repeats. The same table imported again changes nothing; where it was corrected, its runs are.

    Parameters
    ----------
    assembly : Assembly
        The calibration file.
    table : Path
        CSV file: a column for each free parameter and each target of the test, perhaps with a unit
        in brackets; perhaps ``seed`` and ``<response>.standard_error``.
    folder : Path
        The work folder; is made when it is not there.
    test : str, optional
        Name of the test; needed when the file has several.

    Raises
    ------
    InputError
        With every fault of the table.
    SolverNotFoundError
        The test's solver is not installed: its version is part of what a run is.
    StoreError
        The work folder cannot be used.
    """
    specification = _specification(assembly, test)
    rows, ignored = read_import_table(table, assembly, specification)
    solver = assembly.solvers[specification.name]
    try:
        solver.version()
    except SolverNotFoundError as error:
        raise SolverNotFoundError(
            f"{error} It is needed to import runs too: the version of the solver is part of what a "
            "run is, and only runs of the version in use are used."
        ) from error
    origin = f"imported from {table.absolute()}"
    with hold(folder):
        store = RunStore.in_folder(folder)
        try:
            recover(folder, store)
            importing = _Importing(specification.name, solver, origin, store)
            importing.take(rows)
            store.save_many(importing.records)
            usable = len(runs_of(assembly.problem, assembly.solvers, store.runs("finished")))
            notices = [
                *_ignored(ignored),
                *_outside(assembly, rows),
                *importing.notices(),
                *_not_by_earlier_ones(store),
            ]
        finally:
            store.close()
    numbers = importing.numbers
    return Imported(
        specification.name,
        numbers["new"],
        numbers["known"],
        numbers["replaced"],
        usable,
        tuple(notices),
    )


def _specification(assembly: Assembly, test: str | None) -> TestSpecification:
    tests = {specification.name: specification for specification in assembly.file.tests}
    if test is None and len(tests) == 1:
        return next(iter(tests.values()))
    if test in tests:
        return tests[test]
    message = "must be given: the file has several tests." if test is None else f"is {test!r}."
    raise InputError(Fault("--test", message, f"There are: {', '.join(tests)}."))


@dataclass
class _Importing:
    """Finds the place of every row among the runs that are there."""

    test: str
    solver: Solver
    origin: str
    store: RunStore
    records: list[RunRecord] = field(default_factory=list)
    numbers: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    _taken: set[str] = field(default_factory=set)
    _others: list[tuple[int, str]] = field(default_factory=list)
    _left_over: int = 0

    def take(self, rows: list[TableRow]) -> None:
        """Note what is to be saved of each row."""
        there = {record.identity: record for record in self.store.runs("finished")}
        now = time.time()
        # Repeats go on counting where the one before them ended.
        counters: dict[tuple[float, ...], Iterator[int]] = defaultdict(lambda: count(FIRST_SEED))
        # Seeds that are given come first: no other run may take their place.
        for row in sorted(rows, key=lambda row: row.seed is None):
            seeds = iter((row.seed,)) if row.seed is not None else counters[_point(row)]
            for seed in seeds:
                definition = self.solver.definition(row.parameters, seed)
                identity = run_identity(definition)
                if identity in self._taken:
                    continue
                known = there.get(identity)
                if known is None or self.origin == known.origin or _is_alike(known, row):
                    self._place(row, identity, definition, known, now)
                    break
                if row.seed is not None:
                    self._others.append((row.line, known.origin or "made here"))
        self._left_over = sum(
            record.origin == self.origin and record.test == self.test
            for identity, record in there.items()
            if identity not in self._taken
        )

    def _place(
        self,
        row: TableRow,
        identity: str,
        definition: Mapping[str, Any],
        known: RunRecord | None,
        now: float,
    ) -> None:
        self._taken.add(identity)
        if known is not None and _is_alike(known, row):
            self.numbers["known"] += 1
            return
        self.numbers["new" if known is None else "replaced"] += 1
        self.records.append(
            RunRecord(
                identity,
                self.test,
                "finished",
                definition,
                row.responses,
                ended=now,
                origin=self.origin,
            )
        )

    def notices(self) -> Iterator[str]:
        """Say what was not taken, and what stays of earlier imports."""
        for line, origin in self._others[:_NAMED_LINES]:
            yield (
                f"line {line}: this run is there already with other responses ({origin}); "
                "it stays as it is."
            )
        if len(self._others) > _NAMED_LINES:
            yield f"The same of {len(self._others) - _NAMED_LINES} more lines."
        if self._left_over:
            yield (
                f"{_runs(self._left_over)} of an earlier import of this table are not in it any "
                "more; they stay."
            )


def _is_alike(record: RunRecord, row: TableRow) -> bool:
    return dict(record.responses) == dict(row.responses)


def _point(row: TableRow) -> tuple[float, ...]:
    return tuple(row.parameters.values())


def _ignored(columns: list[str]) -> Iterator[str]:
    if columns:
        yield f"Columns that are not used: {', '.join(columns)}."


def _outside(assembly: Assembly, rows: list[TableRow]) -> Iterator[str]:
    """Say which rows no calibration of the file as it is now can use."""
    for parameter in assembly.problem.parameters:
        lines = [
            str(row.line)
            for row in rows
            if not parameter.minimum <= row.parameters[parameter.name] <= parameter.maximum
        ]
        if lines:
            some = ", ".join(lines[:_NAMED_LINES]) + (", ..." if len(lines) > _NAMED_LINES else "")
            ends = f"{parameter.minimum:g} to {parameter.maximum:g} {parameter.unit}".rstrip()
            yield (
                f"Outside of the interval of {parameter.name} ({ends}), and not used while it is "
                f"so: line {some}."
            )


def _not_by_earlier_ones(store: RunStore) -> Iterator[str]:
    if store.latest_calibration() is not None:
        yield (
            "A calibration that was started in this folder before goes on without these runs. "
            "Another one, such as one with another --seed, learns from them."
        )


def _runs(number: int) -> str:
    return "1 run" if number == 1 else f"{number} runs"
