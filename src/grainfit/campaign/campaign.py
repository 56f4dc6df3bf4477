"""Makes the runs that a strategy proposes, several at a time, and never makes one twice."""

from __future__ import annotations

import queue
import tempfile
import threading
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from pickle import PicklingError

from grainfit.campaign import work_folder as workdir
from grainfit.campaign.reserve import Reserve
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.shared import SharedRuns
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.worker import RunTask, execute, failed_record
from grainfit.errors import ExecutorError, StoreError
from grainfit.evaluation import Evaluation, Proposal, response_name
from grainfit.run_definition import RunDefinition
from grainfit.solvers.base import Solver

#: How long to wait before a run is tried again when the machine, not the simulation, is at fault,
#: s: what is short for a moment, such as memory or a licence, may be there a little later.
RETRY_PAUSES = (1.0, 10.0)
_POLL_SECONDS = 0.25
#: How often a shared store is asked for runs that others make, s.
_SHARED_POLL_SECONDS = 1.0


@dataclass(frozen=True)
class CampaignOptions:
    """How runs are made.

    Parameters
    ----------
    workers : int
        How many runs happen at a time.
    timeouts : mapping of str to float
        Longest wall time of one run, s, by name of the test.
    executor : concurrent.futures.Executor, optional
        What makes the runs; threads that wait for solver processes by default. Its workers must see
        the work folder by the same path. It is not shut down.
    keep : {"all", "results"}
        What stays of a run's folder.
    retry_pauses : sequence of float
        How long to wait before each further try when the machine is at fault, s.
    """

    workers: int = 1
    timeouts: Mapping[str, float] = field(default_factory=dict)
    executor: Executor | None = None
    keep: workdir.Keep = "all"
    retry_pauses: Sequence[float] = RETRY_PAUSES


@dataclass
class _Pending:
    """A proposal of which some runs have not ended."""

    proposal: Proposal
    #: Names of the tests that wait for a run, by the run's identity.
    waiting: dict[str, list[str]] = field(default_factory=dict)
    records: dict[str, RunRecord] = field(default_factory=dict)
    reused: int = 0
    reused_seconds: float = 0.0


class Campaign:
    """Runs of one or more tests.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    store : RunStore
        Where finished runs are found and kept; nobody else writes to it.
    folder : Path or None
        The work folder; None when nothing on disk is to be kept.
    options : CampaignOptions
        How runs are made.
    shared : SharedRuns, optional
        Where runs of other processes are found, and those made here are given to them.
    """

    def __init__(
        self,
        solvers: Mapping[str, Solver],
        store: RunStore,
        folder: Path | None,
        options: CampaignOptions | None = None,
        shared: SharedRuns | None = None,
    ) -> None:
        self._solvers = dict(solvers)
        self._store = store
        self._shared = shared
        self._options = options or CampaignOptions()
        self._temporary = tempfile.TemporaryDirectory() if folder is None else None
        self._folder = Path(self._temporary.name) if self._temporary else folder or Path()
        self._reserve = Reserve(None if folder is None else self._folder)
        self._owns_executor = self._options.executor is None
        self._executor = self._options.executor or ThreadPoolExecutor(
            self._options.workers, thread_name_prefix="run"
        )
        self._cancelled = threading.Event()
        self._ended: queue.SimpleQueue[RunRecord | BaseException] = queue.SimpleQueue()
        self._pending: list[_Pending] = []
        self._under_way: dict[str, RunTask] = {}
        self._futures: dict[str, Future[RunRecord]] = {}
        self._tries: dict[str, int] = {}
        self._postponed: list[tuple[float, RunTask]] = []
        self._elsewhere: dict[str, RunTask] = {}
        self._looked_elsewhere = 0.0
        self._fetched: dict[str, RunRecord] = {}

    @property
    def tests(self) -> int:
        """Number of DEM runs that a proposal takes."""
        return len(self._solvers)

    @property
    def solvers(self) -> Mapping[str, Solver]:
        """Solvers by name of the test."""
        return self._solvers

    def identities(self, proposal: Proposal) -> dict[str, str]:
        """Identity of the run of a proposal by name of the test."""
        return {test: run.identity for test, run in self._definitions(proposal).items()}

    def _definitions(self, proposal: Proposal) -> dict[str, RunDefinition]:
        return {
            test: solver.definition(proposal.parameters, proposal.seed)
            for test, solver in self._solvers.items()
        }

    @property
    def has_free_worker(self) -> bool:
        """Whether another run could start at once."""
        return len(self._under_way) < self._options.workers

    @property
    def under_way(self) -> int:
        """Number of runs that have been started and have not ended."""
        return len(self._under_way)

    @property
    def has_pending(self) -> bool:
        """Whether there are proposals that `wait` has not returned."""
        return bool(self._pending)

    @property
    def has_complete(self) -> bool:
        """Whether `wait` would return at once."""
        return any(not entry.waiting for entry in self._pending)

    def fetch(self, identities: Collection[str]) -> None:
        """Read runs that will be asked for, all at once: many at a time are read much faster."""
        self._fetched.update(self._store.find_many(identities))

    def start(
        self, proposal: Proposal, note: Callable[[dict[str, str]], None] | None = None
    ) -> None:
        """Start the runs of a proposal that are not known yet.

        Parameters
        ----------
        proposal : Proposal
            What is asked for.
        note : callable, optional
            Told the identities of its runs by test, before any of them starts: a worker that
            outlives this process may finish one that nobody knew of otherwise.
        """
        entry = _Pending(proposal)
        definitions = self._definitions(proposal)
        identities = {test: definition.identity for test, definition in definitions.items()}
        if note is not None:
            note(identities)
        for test, solver in self._solvers.items():
            identity = identities[test]
            known = self._find(identity, solver)
            if known is not None:
                entry.records[test] = known
                entry.reused += 1
                entry.reused_seconds += known.seconds
                continue
            entry.waiting.setdefault(identity, []).append(test)
            if identity not in self._under_way and identity not in self._elsewhere:
                record = RunRecord(identity, test, "running", definitions[test])
                self._begin(self._task(record, solver, proposal))
        self._pending.append(entry)

    def _task(self, record: RunRecord, solver: Solver, proposal: Proposal) -> RunTask:
        return RunTask(
            record,
            solver,
            dict(proposal.parameters),
            proposal.seed,
            self._folder,
            self._options.timeouts.get(record.test),
            self._options.keep,
        )

    def _find(self, identity: str, solver: Solver) -> RunRecord | None:
        """Find a run that need not be made, here or in the shared store."""
        known = self._fetched.pop(identity, None) or self._store.find(identity)
        if known is not None and _is_final(known, solver):
            return known
        if self._shared is None:
            return None
        known = self._shared.find([identity]).get(identity)
        if known is None:
            return None
        if _is_final(known, solver):
            self._store.save(known)
            return known
        self._shared.forget(identity)
        return None

    def wait(self, poll: Callable[[], None] | None = None) -> list[Evaluation]:
        """Return the proposals that are complete, waiting until there is at least one.

        ``poll`` is called a few times a second meanwhile, to redraw progress.
        """
        if not self._pending:
            raise RuntimeError("nothing has been started that could be waited for")
        while not (complete := [entry for entry in self._pending if not entry.waiting]):
            self._start_postponed()
            self._look_elsewhere()
            try:
                record = self._ended.get(timeout=_POLL_SECONDS)
            except queue.Empty:
                if poll is not None:
                    poll()
                continue
            if isinstance(record, BaseException):
                raise record
            self._receive(record)
        self._pending = [entry for entry in self._pending if entry.waiting]
        return [
            evaluation_of(entry.proposal, entry.records, entry.reused, entry.reused_seconds)
            for entry in complete
        ]

    def forget_failures(self, evaluations: Iterable[Evaluation]) -> None:
        """Let failed runs be made again at the next start: what made them fail may be mended."""
        for evaluation in evaluations:
            for test in evaluation.failures:
                self._store.forget(evaluation.runs[test])
                if self._shared is not None:
                    self._shared.forget(evaluation.runs[test])

    def cancel(self) -> None:
        """End the runs under way; what has finished stays."""
        self._cancelled.set()
        for future in list(self._futures.values()):
            future.cancel()
        if self._owns_executor:
            # In-process functions cannot be ended from outside and must not hold up the user.
            waits = all(solver.uses_folder for solver in self._solvers.values())
            self._executor.shutdown(wait=waits, cancel_futures=True)
        workdir.discard_partial_folders(self._folder, self._under_way)
        # What cannot be noted now, on a full disk for example, the next start puts in order.
        with suppress(StoreError):
            for identity, known in self._store.find_many(self._under_way).items():
                if known.status == "running":
                    self._store.forget(identity)

    def close(self) -> None:
        """Release threads and temporary folders."""
        if self._owns_executor:
            self._executor.shutdown(wait=not self._cancelled.is_set())
        self._reserve.close()
        if self._temporary is not None:
            self._temporary.cleanup()

    # A run's way through the executor ----------------------------------------------------------

    def _begin(self, task: RunTask) -> None:
        if self._shared is not None and not self._shared.claim(task.record):
            self._elsewhere[task.record.identity] = task
            return
        self._make(task)

    def _make(self, task: RunTask) -> None:
        self._store.save(task.record)
        self._under_way[task.record.identity] = task
        self._submit(task)

    def _submit(self, task: RunTask) -> None:
        identity = task.record.identity
        self._tries[identity] = self._tries.get(identity, 0) + 1
        executor = self._executor
        # Other processes cannot be sent an event; they look for the folder of their run.
        cancelled = [self._cancelled] if isinstance(executor, ThreadPoolExecutor) else []
        try:
            future = executor.submit(execute, task, *cancelled)
        except (BrokenExecutor, RuntimeError) as error:
            raise ExecutorError(
                f"the executor takes no more runs: {error or type(error).__name__}. Finished runs "
                "are kept; start again to go on."
            ) from error
        self._futures[identity] = future
        future.add_done_callback(lambda done: self._note_end(task, done))

    def _note_end(self, task: RunTask, future: Future[RunRecord]) -> None:
        """Make the outcome safe before anybody hears of it; called in any thread."""
        try:
            outcome = self._outcome(task, future)
            if outcome is None:
                return
            if not self._is_to_be_tried_again(outcome):
                self._keep(outcome)
            self._ended.put(outcome)
        except BaseException as error:
            self._ended.put(error)

    def _outcome(self, task: RunTask, future: Future[RunRecord]) -> RunRecord | None:
        try:
            outcome = future.result()
        except CancelledError:
            return None
        except ExecutorError:
            # There is nobody left who could make a run.
            raise
        except (PicklingError, AttributeError, TypeError) as error:
            # A run raises none of these: it is the task that could not be sent.
            raise ExecutorError(
                f"a run cannot be sent to another process: {error}. Give a function that is "
                "defined at the top of a module, or use threads."
            ) from error
        except Exception as error:
            # A worker that dies, or whose job is ended, takes only the run along that it made.
            reason = f"the worker was lost: {type(error).__name__}: {error}"
            outcome = replace(failed_record(task.record, reason, "machine"), ended=time.time())
        if outcome.status == "failed" and (self._cancelled.is_set() or outcome.kind == "cancelled"):
            return None
        return outcome

    def _keep(self, outcome: RunRecord) -> None:
        try:
            self._store.save(outcome)
        except StoreError:
            # Mostly the disk is full: room was set aside for what is finished by now.
            self._reserve.release()
            self._store.save(outcome)
            raise
        if self._shared is not None:
            self._shared.save(outcome)

    def _is_to_be_tried_again(self, outcome: RunRecord) -> bool:
        tries = self._tries[outcome.identity]
        return outcome.kind == "machine" and tries <= len(self._options.retry_pauses)

    def _receive(self, record: RunRecord) -> None:
        """Take a run that has ended: hand it on, or try it again later."""
        self._futures.pop(record.identity, None)
        if self._is_to_be_tried_again(record):
            # A worker that was lost may have left a solver behind.
            workdir.discard_partial_folders(self._folder, [record.identity])
            pause = self._options.retry_pauses[self._tries[record.identity] - 1]
            self._postponed.append((time.monotonic() + pause, self._under_way[record.identity]))
            return
        self._under_way.pop(record.identity, None)
        self._settle(record)

    def _settle(self, record: RunRecord) -> None:
        for entry in self._pending:
            for test in entry.waiting.pop(record.identity, []):
                entry.records[test] = record

    def _start_postponed(self) -> None:
        now = time.monotonic()
        due = [task for moment, task in self._postponed if moment <= now]
        self._postponed = [(moment, task) for moment, task in self._postponed if moment > now]
        for task in due:
            self._submit(task)

    def _look_elsewhere(self) -> None:
        """See what has become of runs that other processes make."""
        now = time.monotonic()
        if self._shared is None or now - self._looked_elsewhere < _SHARED_POLL_SECONDS:
            return
        self._looked_elsewhere = now
        found = self._shared.find(self._elsewhere)
        for identity, task in list(self._elsewhere.items()):
            record = found.get(identity)
            if record is not None and _is_final(record, task.solver):
                del self._elsewhere[identity]
                self._store.save(record)
                self._settle(record)
            elif self._shared.take_over(task.record):
                del self._elsewhere[identity]
                self._make(task)


def _is_final(record: RunRecord, solver: Solver) -> bool:
    """Whether it would be a waste to make the run again."""
    if record.status == "finished":
        # An own model may yield a response now that it did not yield then.
        return set(solver.response_names or ()) <= record.responses.keys()
    return record.status == "failed" and not record.may_succeed_next_time


def evaluation_of(
    proposal: Proposal,
    records: Mapping[str, RunRecord],
    reused: int = 0,
    reused_seconds: float = 0.0,
) -> Evaluation:
    """Put together what came of a proposal.

    Parameters
    ----------
    proposal : Proposal
        What was asked for.
    records : mapping of str to RunRecord
        Its runs by name of the test.
    reused : int
        How many of them were known already.
    reused_seconds : float
        Sum of the wall times of those, s.
    """
    responses = {
        response_name(test, name, len(records)): response
        for test, record in records.items()
        for name, response in record.responses.items()
    }
    failed = {test: record for test, record in records.items() if record.status == "failed"}
    seconds = sum(record.seconds for record in records.values())
    return Evaluation(
        proposal,
        responses,
        {test: record.reason for test, record in failed.items()},
        reused,
        {test: record.identity for test, record in records.items()},
        seconds,
        seconds - reused_seconds,
        bool(failed) and all(record.kind == "machine" for record in failed.values()),
    )
