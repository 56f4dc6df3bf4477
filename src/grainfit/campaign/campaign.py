"""Execute the runs that a strategy proposes, several at a time, and each of them only once."""

from __future__ import annotations

import math
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

from grainfit.campaign import messages
from grainfit.campaign import work_folder as workdir
from grainfit.campaign.absent_responses import with_needed
from grainfit.campaign.keep import Keep
from grainfit.campaign.pending import ClusterJob, PendingRun, executing, jobs_of
from grainfit.campaign.repeats import mean_outcome, seeds_of
from grainfit.campaign.reserve import Reserve
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.shared import SharedRuns
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.worker import RunTask, execute, failed_record
from grainfit.errors import ExecutorError, InputError, StoreError
from grainfit.evaluation import (
    Evaluation,
    Proposal,
    curves,
    name_of_test,
    names_of_tests,
    response_name,
    run_name,
    scalars,
)
from grainfit.relative_names import is_relative
from grainfit.run_definition import RunDefinition
from grainfit.solvers.base import Solver

#: Pauses before a run that failed because of the machine, not the simulation, is tried again, s:
#: memory or a licence that is missing now may be available a little later.
RETRY_PAUSES = (1.0, 10.0)
_POLL_SECONDS = 0.25
#: Interval at which a shared store is asked for runs of other processes, s.
_SHARED_POLL_SECONDS = 1.0


@dataclass(frozen=True)
class CampaignOptions:
    """Options for executing runs.

    Parameters
    ----------
    workers : int
        Number of runs at a time.
    timeouts : mapping of str to float
        Longest wall time of one run, s, by name of the test.
    executor : concurrent.futures.Executor, optional
        Executor of the runs; by default threads that wait for solver processes. Its workers must
        see the work folder at the same path. It is not shut down.
    keep : {"all", "results"}
        Files of a run folder that are kept.
    retry_pauses : sequence of float
        Pause before each further attempt after a failure of the machine, s.
    needed : mapping of str to collection of str
        Responses without which a known run is repeated, by name of the test; by default all of
        its solver. A version that measures more does not repeat runs for what nobody asks for. A
        run that cannot have one, see `Solver.absent`, counts as failed instead.
    repeats : mapping of str to int
        Runs with different seeds whose mean is one evaluation, by name of the test; 1 by default.
    ratios : mapping of str to float
        Factors on the responses of evaluations, see `Problem.ratios`.
    """

    workers: int = 1
    timeouts: Mapping[str, float] = field(default_factory=dict)
    executor: Executor | None = None
    keep: Keep = "all"
    retry_pauses: Sequence[float] = RETRY_PAUSES
    needed: Mapping[str, Collection[str]] = field(default_factory=dict)
    repeats: Mapping[str, int] = field(default_factory=dict)
    ratios: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class _Run:
    """One run of a proposal: its test, its own seed, and what determines its outcome."""

    test: str
    seed: int
    definition: RunDefinition


@dataclass
class _Pending:
    """A proposal with runs that have not ended."""

    proposal: Proposal
    #: Names of all runs, in the order of tests and seeds.
    names: tuple[str, ...]
    #: Names of the runs that wait, by their identity.
    waiting: dict[str, list[str]] = field(default_factory=dict)
    records: dict[str, RunRecord] = field(default_factory=dict)
    reused: int = 0
    reused_seconds: float = 0.0

    def take(self, name: str, record: RunRecord, *, is_own: bool) -> None:
        """Take a run that has ended: of this process, or known or made elsewhere."""
        self.records[name] = record
        if not is_own:
            self.reused += 1
            self.reused_seconds += record.seconds

    def evaluation(self, tests: int, options: CampaignOptions) -> Evaluation:
        """Build the evaluation, which does not depend on the order in which the runs ended."""
        records = {
            name: with_needed(self.records[name], options.needed.get(name_of_test(name), ()))
            for name in self.names
        }
        found = evaluation_of(self.proposal, records, tests, self.reused, self.reused_seconds)
        return found.scaled(options.ratios)


class Campaign:
    """Runs of one or more tests.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    store : RunStore
        Store of finished runs; no other process writes to it.
    folder : Path or None
        The work folder; None keeps nothing on disk.
    options : CampaignOptions
        Options for executing runs.
    shared : SharedRuns, optional
        Store through which runs are exchanged with other processes.
    relatives : mapping of str to Solver
        Solvers of cheaper relatives of the tests, by `relative_name`. They run for proposals that
        name them.
    notices : sequence of str
        Notices from before the first run.
    """

    def __init__(
        self,
        solvers: Mapping[str, Solver],
        store: RunStore,
        folder: Path | None,
        options: CampaignOptions | None = None,
        shared: SharedRuns | None = None,
        relatives: Mapping[str, Solver] | None = None,
        notices: Sequence[str] = (),
    ) -> None:
        self._tests = dict(solvers)
        self._early_notices = tuple(notices)
        self.relatives = dict(relatives or {})
        self._solvers = {**self._tests, **self.relatives}
        _require_names_of_tests(solvers)
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
        #: Time of the last submission, seconds since the epoch; for display only.
        self._submitted: dict[str, float] = {}
        self._postponed: list[tuple[float, RunTask]] = []
        self._elsewhere: dict[str, RunTask] = {}
        #: Runs that may be those of this process: the shared store could not be asked.
        self._undecided: set[str] = set()
        self._looked_elsewhere = 0.0
        self._fetched: dict[str, RunRecord] = {}

    @property
    def tests(self) -> int:
        """Number of tests."""
        return len(self._tests)

    @property
    def folder(self) -> Path:
        """The work folder; a temporary one where nothing is kept."""
        return self._folder

    @property
    def solvers(self) -> Mapping[str, Solver]:
        """Solvers by name of the test."""
        return self._tests

    @property
    def repeats(self) -> dict[str, int]:
        """Runs per evaluation, by name of the test."""
        return {test: self._options.repeats.get(test, 1) for test in self._solvers}

    @property
    def runs_per_set(self) -> int:
        """Runs of one evaluation of every test."""
        return sum(self.repeats[test] for test in self._tests)

    def identities(self, proposal: Proposal) -> dict[str, str]:
        """Identities of the runs of a proposal, by name of the run."""
        return {name: run.definition.identity for name, run in self._runs_of(proposal).items()}

    def _runs_of(self, proposal: Proposal) -> dict[str, _Run]:
        """Return the runs of a proposal by their names."""
        return {
            run_name(test, number): _Run(test, seed, solver.definition(proposal.parameters, seed))
            for test, solver in self._solvers.items()
            if proposal.asks_for(test) and (proposal.tests or not is_relative(test))
            for number, seed in enumerate(seeds_of(proposal.seed, self.repeats[test]), 1)
        }

    @property
    def has_free_worker(self) -> bool:
        """Whether another run can start now."""
        return len(self._under_way) + len(self._undecided) < self._options.workers

    @property
    def running(self) -> int:
        """Number of runs that execute; others may wait for a worker, or for a job of a cluster."""
        return executing(len(self._under_way), self._options.workers, self.jobs)

    @property
    def pending_runs(self) -> list[PendingRun]:
        """Runs that have not ended, in the order in which they were submitted."""
        postponed = {task.record.identity for _, task in self._postponed}
        begun = {identity for identity, future in self._futures.items() if future.running()}
        here = [
            PendingRun(
                identity,
                task.record.test,
                "postponed" if identity in postponed else "submitted",
                self._submitted.get(identity, 0.0),
                self._tries.get(identity, 1),
                task.solver.uses_folder,
                identity in begun and isinstance(self._executor, ThreadPoolExecutor),
            )
            for identity, task in self._under_way.items()
        ]
        elsewhere = self._elsewhere.items()
        return here + [PendingRun(name, task.record.test, "elsewhere") for name, task in elsewhere]

    @property
    def jobs(self) -> Sequence[ClusterJob]:
        """Jobs of the cluster in which the runs execute; none on one machine."""
        return jobs_of(self._executor)

    @property
    def has_pending(self) -> bool:
        """Whether there are proposals that `wait` has not returned yet."""
        return bool(self._pending)

    @property
    def has_complete(self) -> bool:
        """Whether `wait` returns immediately."""
        return any(not entry.waiting for entry in self._pending)

    @property
    def notices(self) -> tuple[str, ...]:
        """Notices from before the first run, and about the shared store, as they came."""
        later = () if self._shared is None else self._shared.notices
        return (*self._early_notices, *later)

    def fetch(self, identities: Collection[str]) -> None:
        """Read runs that will be needed in one query, which is much faster than one by one."""
        self._fetched.update(self._store.find_many(identities))

    def start(
        self, proposal: Proposal, note: Callable[[dict[str, str]], None] | None = None
    ) -> None:
        """Start the runs of a proposal that are not known yet.

        Parameters
        ----------
        proposal : Proposal
            The parameter values and the seed.
        note : callable, optional
            Called with the identities of its runs by name before any of them starts: a worker may
            outlive this process and finish a run that would otherwise be unknown.
        """
        runs = self._runs_of(proposal)
        entry = _Pending(proposal, tuple(runs))
        if note is not None:
            note({name: run.definition.identity for name, run in runs.items()})
        for name, run in runs.items():
            identity = run.definition.identity
            known = self._find(identity, run.test)
            if known is not None:
                entry.take(name, known, is_own=False)
                continue
            entry.waiting.setdefault(identity, []).append(name)
            if identity not in self._under_way and identity not in self._elsewhere:
                self._begin(self._task(run, proposal))
        self._pending.append(entry)

    def _task(self, run: _Run, proposal: Proposal) -> RunTask:
        record = RunRecord(run.definition.identity, run.test, "running", run.definition)
        return RunTask(
            record,
            self._solvers[run.test],
            dict(proposal.parameters),
            run.seed,
            self._folder,
            self._options.timeouts.get(record.test),
            self._options.keep,
        )

    def is_known(self, identity: str, test: str) -> bool:
        """Return whether a run has a final outcome, so that `start` does not make it."""
        return self._find(identity, test) is not None

    def _find(self, identity: str, test: str) -> RunRecord | None:
        """Find a run with a final outcome, here or in the shared store."""
        known = self._fetched.pop(identity, None) or self._store.find(identity)
        if known is not None and self._is_final(known, test):
            return known
        if self._shared is None:
            return None
        known = self._shared.find([identity]).get(identity)
        if known is None:
            return None
        if self._is_final(known, test):
            self._store.save(known)
            return known
        self._shared.forget(identity)
        return None

    def _is_final(self, record: RunRecord, test: str) -> bool:
        """Return True if there is no reason to repeat the run."""
        if record.status == "finished":
            # A model may return a response now that it did not return then.
            solver = self._solvers[test]
            names = self._options.needed.get(test, solver.response_names)
            # A run of an older version may lack them as well, without a reason.
            absent = solver.absent if record.reason else ()
            return set(names or ()) <= {*record.responses, *absent}
        return record.status == "failed" and not record.may_succeed_next_time

    def wait(self, poll: Callable[[], None] | None = None) -> list[Evaluation]:
        """Wait until a proposal is complete or a worker is free; return the complete ones.

        A worker that has ended one of several tests is free for another proposal. Meanwhile
        ``poll`` is called a few times per second, to redraw the progress.
        """
        if not self._pending:
            raise RuntimeError("nothing has been started that could be waited for")
        has_ended = False
        while not self.has_complete and not (has_ended and self.has_free_worker):
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
            has_ended = True
        complete = [entry for entry in self._pending if not entry.waiting]
        self._pending = [entry for entry in self._pending if entry.waiting]
        return [entry.evaluation(self.tests, self._options) for entry in complete]

    def forget_failures(self, evaluations: Iterable[Evaluation]) -> None:
        """Let failed runs be repeated at the next start: the cause may be fixed by then.

        Until then, they are shown in this work folder; other processes may repeat them at once.
        Finished ones that count as failed for want of a response stay: they would be the same
        again, and another calibration may not need that response.
        """
        failed = [e.runs[run] for e in evaluations for run in e.failed_runs]
        self._store.repeat_failed(failed)
        if self._shared is not None:
            self._shared.forget_failed(failed)

    def cancel(self) -> None:
        """End the pending runs; finished runs are kept."""
        self._cancelled.set()
        if self._shared is not None:
            self._shared.cancel()
        for future in list(self._futures.values()):
            future.cancel()
        if self._owns_executor:
            # Functions in this process cannot be ended from outside; do not make the user wait.
            waits = all(solver.uses_folder for solver in self._solvers.values())
            self._executor.shutdown(wait=waits, cancel_futures=True)
        workdir.discard_partial_folders(self._folder, self._under_way)
        # If this fails, for example on a full disk, the next start cleans up.
        with suppress(StoreError):
            for identity, known in self._store.find_many(self._under_way).items():
                if known.status == "running":
                    self._store.forget(identity)

    def close(self) -> None:
        """Release the threads and the temporary folder."""
        if self._owns_executor:
            self._executor.shutdown(wait=not self._cancelled.is_set())
        self._reserve.close()
        if self._temporary is not None:
            self._temporary.cleanup()

    # A run's way through the executor ----------------------------------------------------------

    def _begin(self, task: RunTask) -> None:
        claimed = True if self._shared is None else self._shared.claim(task.record)
        if claimed:
            self._make(task)
            return
        self._elsewhere[task.record.identity] = task
        if claimed is None:
            self._undecided.add(task.record.identity)

    def _make(self, task: RunTask) -> None:
        self._store.save(task.record)
        self._under_way[task.record.identity] = task
        self._submit(task)

    def _submit(self, task: RunTask) -> None:
        identity = task.record.identity
        self._tries[identity] = self._tries.get(identity, 0) + 1
        self._submitted[identity] = time.time()
        executor = self._executor
        # An event cannot be sent to other processes; they check the folder of their run.
        cancelled = [self._cancelled] if isinstance(executor, ThreadPoolExecutor) else []
        try:
            future = executor.submit(execute, task, *cancelled)
        except (BrokenExecutor, RuntimeError) as error:
            reason = error or type(error).__name__
            raise ExecutorError(messages.NO_MORE_RUNS(reason=reason)) from error
        self._futures[identity] = future
        future.add_done_callback(lambda done: self._note_end(task, done))

    def _note_end(self, task: RunTask, future: Future[RunRecord]) -> None:
        """Store the outcome before it is reported; called from any thread."""
        try:
            outcome = self._outcome(task, future)
            if outcome is None:
                return
            if not self._is_to_be_tried_again(outcome) and not self._keep(outcome):
                # It is running still, or has finished, elsewhere.
                outcome = task.record
            self._ended.put(outcome)
        except BaseException as error:
            self._ended.put(error)

    def _outcome(self, task: RunTask, future: Future[RunRecord]) -> RunRecord | None:
        try:
            outcome = future.result()
        except CancelledError:
            return None
        except ExecutorError:
            # No worker is left.
            raise
        except (PicklingError, AttributeError, TypeError) as error:
            # `execute` raises none of these: the task could not be sent.
            raise ExecutorError(messages.CANNOT_BE_SENT(reason=error)) from error
        except Exception as error:
            # When a worker dies or its job is ended, only its current run is lost.
            reason = messages.WORKER_LOST(kind=type(error).__name__, reason=error)
            outcome = replace(failed_record(task.record, reason, "machine"), ended=time.time())
        if outcome.status == "failed" and (self._cancelled.is_set() or outcome.kind == "cancelled"):
            return None
        return outcome

    def _keep(self, outcome: RunRecord) -> bool:
        """Store an outcome; return False for a failure of a run that was taken over by another.

        That happens to a process that was suspended, or cut off. Its own finished runs count.
        """
        try:
            self._store.save(outcome)
        except StoreError:
            # Usually the disk is full: the reserve is for the runs that have finished by now.
            self._reserve.release()
            self._store.save(outcome)
            raise
        counts = self._shared is None or self._shared.save(outcome)
        return counts or outcome.status == "finished"

    def _is_to_be_tried_again(self, outcome: RunRecord) -> bool:
        tries = self._tries[outcome.identity]
        return outcome.kind == "machine" and tries <= len(self._options.retry_pauses)

    def _receive(self, record: RunRecord) -> None:
        """Receive a run that has ended: pass it on, or schedule another attempt."""
        self._futures.pop(record.identity, None)
        if self._is_to_be_tried_again(record):
            # A lost worker may have left a running solver.
            workdir.discard_partial_folders(self._folder, [record.identity])
            pause = self._options.retry_pauses[self._tries[record.identity] - 1]
            self._postponed.append((time.monotonic() + pause, self._under_way[record.identity]))
            return
        task = self._under_way.pop(record.identity)
        self._submitted.pop(record.identity, None)
        if record.status == "running":
            self._store.save(record)
            self._elsewhere[record.identity] = task
            return
        self._settle(record, is_own=True)

    def _settle(self, record: RunRecord, *, is_own: bool) -> None:
        for entry in self._pending:
            for name in entry.waiting.pop(record.identity, []):
                entry.take(name, record, is_own=is_own)

    def _start_postponed(self) -> None:
        now = time.monotonic()
        due = [task for moment, task in self._postponed if moment <= now]
        self._postponed = [(moment, task) for moment, task in self._postponed if moment > now]
        for task in due:
            # Another process may have taken the run over meanwhile.
            self._begin(self._under_way.pop(task.record.identity))

    def _look_elsewhere(self) -> None:
        """Check the runs that other processes execute."""
        now = time.monotonic()
        if self._shared is None or now - self._looked_elsewhere < _SHARED_POLL_SECONDS:
            return
        self._looked_elsewhere = now
        found = self._shared.find(self._elsewhere)
        for identity, task in list(self._elsewhere.items()):
            record = found.get(identity)
            if record is not None and self._is_final(record, task.record.test):
                del self._elsewhere[identity]
                self._undecided.discard(identity)
                self._store.save(record)
                self._settle(record, is_own=False)
                continue
            if record is not None:
                self._shared.forget(identity)
            claimed = self._shared.take_over(task.record)
            if claimed is not None:
                self._undecided.discard(identity)
            if claimed:
                del self._elsewhere[identity]
                self._make(task)


def _require_names_of_tests(names: Iterable[str]) -> None:
    InputError.raise_for(
        messages.NAME_OF_FURTHER_RUNS.fault(name)
        for name in names
        if names_of_tests([name]) != (name,)
    )


def evaluation_of(
    proposal: Proposal,
    records: Mapping[str, RunRecord],
    tests: int,
    reused: int = 0,
    reused_seconds: float = 0.0,
) -> Evaluation:
    """Build the evaluation of a proposal from its runs.

    Parameters
    ----------
    proposal : Proposal
        The proposal.
    records : mapping of str to RunRecord
        Its runs by name; those of one test with several seeds count as their mean.
    tests : int
        Number of tests of the calibration.
    reused : int
        Number of runs that were already known, or that another process made.
    reused_seconds : float
        Sum of their wall times, s.
    """
    of_tests = {
        test: mean_outcome([record for run, record in records.items() if name_of_test(run) == test])
        for test in names_of_tests(records)
    }
    found = {
        response_name(test, name, 2 if is_relative(test) else tests): response
        for test, outcome in of_tests.items()
        for name, response in outcome.responses.items()
    }
    failed = {test: outcome for test, outcome in of_tests.items() if outcome.reason}
    seconds = sum(record.seconds for record in records.values())
    return Evaluation(
        proposal,
        scalars(found),
        {test: outcome.reason for test, outcome in failed.items()},
        reused,
        {run: record.identity for run, record in records.items()},
        seconds,
        seconds - reused_seconds,
        bool(failed) and all(outcome.failed_by_machine for outcome in failed.values()),
        {test: outcome.seconds for test, outcome in of_tests.items()},
        curves(found),
        {run: record.reason for run, record in records.items() if record.status == "failed"},
        {
            name_of_test(run): place
            for run, record in records.items()
            if (place := _made_elsewhere(proposal, record.definition.parameters))
        },
    )


def _made_elsewhere(proposal: Proposal, made: Mapping[str, float]) -> dict[str, float]:
    """Return the parameters of a run that differ from those asked for, rounding errors apart."""
    return {
        name: made[name]
        for name, value in proposal.parameters.items()
        if name in made and not math.isclose(made[name], value, rel_tol=1e-9)
    }
