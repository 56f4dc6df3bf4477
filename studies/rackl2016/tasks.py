"""Steps of the study as tasks with saved records, so that an interrupted study continues."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from grainfit.files import write_atomically
from grainfit.run_definition import identity_of
from grainfit.solvers.base import Solver
from studies.rackl2016.clock import Clock, Cost

#: Result of a task as plain data.
Record = dict[str, Any]
#: Told what is going on within a task: done, of about how many, in words.
Report = Callable[[int, int, str], None]
#: Processor time of a run where none has been measured yet, s.
USUAL_RUN_SECONDS = 7.0


@dataclass(frozen=True)
class Context:
    """What a task works with.

    Parameters
    ----------
    folder : Path
        Its own folder; what is in there is what it had done when it was killed.
    workers : int
        Runs at a time.
    solver : Solver
        The heap test.
    records : mapping of str to dict
        Records of the tasks that it needs.
    clock : Clock
        Records where the search ends.
    report : callable
        For progress.
    """

    folder: Path
    workers: int
    solver: Solver
    records: Mapping[str, Record]
    clock: Clock
    report: Report


@dataclass(frozen=True)
class Task:
    """A part of the study.

    Parameters
    ----------
    name : str
        Also of its file and folder.
    step : str
        The step that it belongs to.
    definition : mapping
        Everything that decides its result, except the heap test and the records that it needs.
    make : callable
        Makes the record. Killed and called again, it must continue.
    runs : int
        DEM runs that it usually takes, several at a time.
    serial_runs : int
        DEM runs that it usually takes one after the other.
    needs : tuple of str
        Names of tasks whose records it works with.
    """

    name: str
    step: str
    definition: Mapping[str, Any]
    make: Callable[[Context], Record]
    runs: int = 0
    serial_runs: int = 0
    needs: tuple[str, ...] = ()

    def seconds(self, run_seconds: float, workers: int) -> float:
        """About how long it takes, s."""
        return run_seconds * (self.runs / workers + self.serial_runs)


@dataclass(frozen=True)
class Results:
    """Records of finished tasks, in files.

    Parameters
    ----------
    folder : Path
        The work folder of the study.
    heap : str
        Identity of the heap test: with another deck or solver version, records are of no use.
    """

    folder: Path
    heap: str
    _known: dict[str, dict[str, Any]] = field(default_factory=dict)

    def find(self, task: Task) -> Record | None:
        """Record of a task; None when it has not been done with what it is defined by."""
        kept = self._read(task.name)
        if kept is None or kept["made_from"] != self._made_from(task):
            return None
        record: Record = kept["record"]
        return record

    def cost(self, task: Task) -> Cost:
        """What a finished task took."""
        kept = self._read(task.name)
        return Cost() if kept is None else Cost(**kept["cost"])

    def save(self, task: Task, record: Record, cost: Cost) -> None:
        """Save the result of a task."""
        kept = {"made_from": self._made_from(task), "cost": asdict(cost), "record": record}
        path = self._path(task.name)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, json.dumps(kept, indent=1, ensure_ascii=False) + "\n")
        self._known[task.name] = json.loads(json.dumps(kept))

    def needed(self, task: Task) -> dict[str, Record]:
        """Records that a task works with; KeyError when one is missing."""
        found = {name: self._read(name) for name in task.needs}
        if missing := [name for name, kept in found.items() if kept is None]:
            raise KeyError(missing[0])
        return {name: kept["record"] for name, kept in found.items() if kept is not None}

    def work_folder(self, task: Task) -> Path:
        """Folder of a task with its current definition; runs of another one are not reused."""
        return self.folder / task.step / task.name / identity_of(self._made_from(task))[:8]

    def _made_from(self, task: Task) -> dict[str, Any]:
        needed = {name: self._read(name) for name in task.needs}
        return {
            "heap": self.heap,
            "definition": identity_of(dict(task.definition)),
            "records": {n: kept and identity_of(kept["record"]) for n, kept in needed.items()},
        }

    def _read(self, name: str) -> dict[str, Any] | None:
        if name not in self._known:
            path = self._path(name)
            if not path.exists():
                return None
            self._known[name] = json.loads(path.read_text(encoding="utf-8"))
        return self._known[name]

    def _path(self, name: str) -> Path:
        return self.folder / "results" / f"{name}.json"


class Study:
    """Tasks in the order in which they are done.

    Parameters
    ----------
    tasks : sequence of Task
        A task comes after those that it needs.
    results : Results
        Where records are kept.
    solver : Solver
        The heap test.
    workers : int
        Runs at a time.
    """

    def __init__(
        self, tasks: Sequence[Task], results: Results, solver: Solver, workers: int
    ) -> None:
        self.tasks = tasks
        self.results = results
        self._solver = solver
        self._workers = workers

    def of_steps(self, steps: Iterable[str], beginning: str = "") -> list[Task]:
        """Tasks of some steps, those whose name begins so, with all that these need."""
        wanted = {
            task.name
            for task in self.tasks
            if task.step in set(steps) and task.name.startswith(beginning)
        }
        for task in reversed(self.tasks):
            if task.name in wanted:
                wanted.update(task.needs)
        return [task for task in self.tasks if task.name in wanted]

    def open_tasks(self, tasks: Iterable[Task]) -> list[Task]:
        """Those that have to be done, also because what they need has to be done again."""
        again: set[str] = set()
        for task in tasks:
            if again.intersection(task.needs) or self.results.find(task) is None:
                again.add(task.name)
        return [task for task in tasks if task.name in again]

    def seconds_left(self, tasks: Iterable[Task]) -> float:
        """About how long the open ones among some tasks take on an otherwise idle machine, s."""
        run_seconds = self.run_seconds
        return sum(task.seconds(run_seconds, self._workers) for task in self.open_tasks(tasks))

    @property
    def run_seconds(self) -> float:
        """Processor time of a DEM run, s: what was measured where runs were counted."""
        measured = list(self._measured_runs())
        if not measured:
            return USUAL_RUN_SECONDS
        return sum(seconds for _, seconds in measured) / sum(count for count, _ in measured)

    def do(self, task: Task, report: Report) -> Record:
        """Do a task, or find its record."""
        known = self.results.find(task)
        if known is not None:
            return known
        folder = self.results.work_folder(task)
        folder.mkdir(parents=True, exist_ok=True)
        needed = self.results.needed(task)
        with Clock(folder / "clock.json") as clock:
            context = Context(folder, self._workers, self._solver, needed, clock, report)
            record = task.make(context)
            cost = clock.cost
        self.results.save(task, record, cost)
        return record

    def _measured_runs(self) -> Iterator[tuple[int, float]]:
        for task in self.tasks:
            record = self.results.find(task)
            if record is not None and record.get("runs_made"):
                yield record["runs_made"], self.results.cost(task).processor_seconds
