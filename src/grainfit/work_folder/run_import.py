"""Import runs from elsewhere into a work folder, as runs of a calibration file's test."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path

from grainfit.calibration_file.build import CalibrationSetup
from grainfit.calibration_file.content import TestSpecification
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.reuse import models_of, runs_of
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import recover
from grainfit.errors import InputError, SolverNotFoundError
from grainfit.formatting import counted
from grainfit.metamodels.known_runs import LARGEST_DISTANCE, distance_outside
from grainfit.solvers.base import Solver
from grainfit.work_folder import messages
from grainfit.work_folder.import_table import TableRow, read_import_table

#: First seed for runs whose seed is not known: no calibration asks for seeds above
#: 900,000,000.
FIRST_SEED = 1_000_000_001
_NAMED_LINES = 5


@dataclass(frozen=True)
class Imported:
    """Outcome of an import.

    Parameters
    ----------
    test : str
        Name of their test.
    new, known, replaced : int
        Number of runs that were added, that were there already, and that had other responses from
        an earlier import of this table.
    usable : int
        Parameter sets, of all runs in the work folder, that a calibration of the file can
        warm start from.
    notices : tuple of str
        What the user should know.
    table : str
        How the table was understood, in one line.
    """

    test: str
    new: int
    known: int
    replaced: int
    usable: int
    notices: tuple[str, ...] = ()
    table: str = ""


def import_runs(
    setup: CalibrationSetup, table: Path, folder: Path, test: str | None = None
) -> Imported:
    """Take the runs of a CSV table into a work folder.

    Each row without a seed gets its own seed, so that rows with equal parameters count as repeats.
    Importing the same table again changes nothing; importing a corrected table corrects its runs.

    Parameters
    ----------
    setup : CalibrationSetup
        The calibration file.
    table : Path
        CSV file: a column for each free parameter that the test depends on and each of its
        targets, perhaps with a unit in brackets; perhaps ``seed``, ``<response>.standard_error``,
        and ``test`` where it holds runs of other tests, too.
    folder : Path
        The work folder; created when it does not exist.
    test : str, optional
        Name of the test; needed when the file has several.

    Raises
    ------
    InputError
        With every fault of the table.
    SolverNotFoundError
        The test's solver is not installed: its version is part of a run's identity.
    StoreError
        The work folder cannot be used.
    """
    specification = _specification(setup, test)
    read = read_import_table(table, setup, specification)
    solver = setup.solvers[specification.name]
    try:
        solver.version()
    except SolverNotFoundError as error:
        raise SolverNotFoundError(messages.SOLVER_FOR_IMPORT(why=str(error))) from error
    origin = f"imported from {table.absolute()}"
    with hold(folder):
        store = RunStore.in_folder(folder)
        try:
            recover(folder, store)
            importing = _Importing(specification.name, solver, origin, store)
            importing.take(read.rows)
            store.save_many(importing.records)
            known = store.runs_of(models_of(setup.solvers), "finished")
            usable = len(runs_of(setup.problem, setup.solvers, known, setup.repeats))
            notices = [
                *_ignored(read.ignored),
                *_outside(setup, read.rows),
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
        read.understood,
    )


def _specification(setup: CalibrationSetup, test: str | None) -> TestSpecification:
    tests = {specification.name: specification for specification in setup.file.tests}
    if test is None and len(tests) == 1:
        return next(iter(tests.values()))
    if test in tests:
        return tests[test]
    there = ", ".join(tests)
    raise InputError(
        messages.TEST_NOT_GIVEN.fault("--test", tests=there)
        if test is None
        else messages.UNKNOWN_TEST.fault("--test", test=test, tests=there)
    )


@dataclass
class _Importing:
    """Assignment of every row to a run in the store."""

    test: str
    solver: Solver
    origin: str
    store: RunStore
    now: float = field(default_factory=time.time)
    records: list[RunRecord] = field(default_factory=list)
    numbers: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    _taken: set[str] = field(default_factory=set)
    _others: list[tuple[int, str]] = field(default_factory=list)
    _left_over: int = 0

    def take(self, rows: list[TableRow]) -> None:
        """Note the run to save for each row."""
        there = {record.identity: record for record in self.store.runs("finished")}
        unnumbered: dict[tuple[float, ...], list[TableRow]] = defaultdict(list)
        # Seeds that are given come first: no other run may take their place.
        for row in rows:
            if row.seed is None:
                unnumbered[tuple(row.parameters.values())].append(row)
            else:
                self._take_one(row, self._place(row, row.seed), there)
        for repeats in unnumbered.values():
            self._take_repeats(repeats, there)
        self._left_over = sum(
            self._is_mine(record) and record.test == self.test
            for identity, record in there.items()
            if identity not in self._taken
        )

    def _take_one(self, row: TableRow, place: RunRecord, there: Mapping[str, RunRecord]) -> None:
        known = there.get(place.identity)
        if known is None or self._is_mine(known) or _is_alike(known, row):
            self._fill(place, known)
        else:
            self._taken.add(place.identity)
            self._others.append((row.line, known.origin or "made here"))

    def _take_repeats(self, rows: list[TableRow], there: Mapping[str, RunRecord]) -> None:
        """Give runs with the same parameters and no seed a seed each."""
        places = self._places_for(rows, there)
        others = []
        for row in rows:
            same = (
                place
                for place in places
                if place.identity in there and _is_alike(there[place.identity], row)
            )
            if (place := next(same, None)) is None:
                others.append(row)
            else:
                places.remove(place)
                self._fill(self._with_row(place, row), there[place.identity])
        # Runs of an earlier import of this table that match no row get the responses of other rows.
        mine = [p for p in places if p.identity in there and self._is_mine(there[p.identity])]
        empty = [place for place in places if place.identity not in there]
        for row, place in zip(others, mine + empty, strict=False):
            self._fill(self._with_row(place, row), there.get(place.identity))

    def _places_for(self, rows: list[TableRow], there: Mapping[str, RunRecord]) -> list[RunRecord]:
        """Return runs at the parameters of these rows: the existing ones, and enough new ones."""
        places: list[RunRecord] = []
        empty = 0
        seeds = count(FIRST_SEED)
        while empty < len(rows):
            place = self._place(rows[0], next(seeds))
            if place.identity not in self._taken:
                places.append(place)
                empty += place.identity not in there
        return places

    def _is_mine(self, record: RunRecord) -> bool:
        return record.origin == self.origin

    def _place(self, row: TableRow, seed: int) -> RunRecord:
        """Return the run of a row with a seed."""
        definition = self.solver.definition(row.parameters, seed)
        place = RunRecord(
            definition.identity, self.test, "finished", definition, origin=self.origin
        )
        return self._with_row(place, row)

    def _with_row(self, place: RunRecord, row: TableRow) -> RunRecord:
        return replace(
            place, responses=row.responses, seconds=row.seconds, ended=row.ended or self.now
        )

    def _fill(self, record: RunRecord, known: RunRecord | None) -> None:
        self._taken.add(record.identity)
        retimed = known is not None and self._is_mine(known) and known.seconds != record.seconds
        if known is not None and _is_alike(known, record) and not retimed:
            self.numbers["known"] += 1
            return
        self.numbers["new" if known is None else "replaced"] += 1
        self.records.append(record)

    def notices(self) -> Iterator[str]:
        """Report rows that were not imported, and runs that stay from earlier imports."""
        for line, origin in self._others[:_NAMED_LINES]:
            yield messages.RUN_STAYS(line=line, origin=origin)
        if len(self._others) > _NAMED_LINES:
            yield messages.MORE_RUNS_STAY(count=len(self._others) - _NAMED_LINES)
        if self._left_over:
            yield messages.EARLIER_IMPORT_STAYS(runs=counted(self._left_over, "run"))


def _is_alike(record: RunRecord, other: RunRecord | TableRow) -> bool:
    return dict(record.responses) == dict(other.responses)


def _ignored(columns: list[str]) -> Iterator[str]:
    if columns:
        yield messages.UNUSED_COLUMNS(columns=", ".join(columns))


def _outside(setup: CalibrationSetup, rows: list[TableRow]) -> Iterator[str]:
    """Report rows that no calibration of the present file can use."""
    for parameter in setup.problem.parameters:
        name = parameter.name
        lines = [
            str(row.line)
            for row in rows
            if name in row.parameters
            and distance_outside(setup.problem, {name: row.parameters[name]}) > LARGEST_DISTANCE
        ]
        if lines:
            some = ", ".join(lines[:_NAMED_LINES]) + (", ..." if len(lines) > _NAMED_LINES else "")
            ends = f"{parameter.minimum:g} to {parameter.maximum:g} {parameter.unit}".rstrip()
            yield messages.OUTSIDE_OF_INTERVAL(
                name=name, ends=ends, distance=LARGEST_DISTANCE, lines=some
            )


def _not_by_earlier_ones(store: RunStore) -> Iterator[str]:
    if store.latest_calibration() is not None:
        yield messages.NOT_BY_EARLIER_CALIBRATIONS()
