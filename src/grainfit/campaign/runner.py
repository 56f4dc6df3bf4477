"""Makes the runs that a strategy proposes, several at a time, and never makes one twice."""

from __future__ import annotations

import math
import queue
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

from grainfit.campaign import workdir
from grainfit.campaign.evaluation import Evaluation, Proposal
from grainfit.campaign.identity import run_identity
from grainfit.campaign.store import RunRecord, RunStore
from grainfit.errors import GrainfitError, RunFailedError, StoreError
from grainfit.solvers.base import Response, Solver, Workspace

_TAIL_CHARACTERS = 2000
#: How often a run is tried when the machine, not the simulation, is at fault.
ATTEMPTS = 2


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
    """Runs of one or more tests, in threads that wait for solver processes.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    store : RunStore
        Where finished runs are found and kept.
    folder : Path or None
        The work folder; None when nothing on disk is to be kept.
    workers : int
        How many runs happen at a time.
    timeouts : mapping of str to float, optional
        Longest wall time of one run, s, by name of the test.
    """

    def __init__(
        self,
        solvers: Mapping[str, Solver],
        store: RunStore,
        folder: Path | None,
        workers: int = 1,
        timeouts: Mapping[str, float] | None = None,
    ) -> None:
        self._solvers = dict(solvers)
        self._store = store
        self._temporary = tempfile.TemporaryDirectory() if folder is None else None
        self._folder = Path(self._temporary.name) if self._temporary else folder or Path()
        self._workers = workers
        self._timeouts = dict(timeouts or {})
        self._executor = ThreadPoolExecutor(workers, thread_name_prefix="run")
        self._cancelled = threading.Event()
        self._ended: queue.SimpleQueue[RunRecord | BaseException] = queue.SimpleQueue()
        self._pending: list[_Pending] = []
        self._under_way: set[str] = set()

    @property
    def tests(self) -> int:
        """Number of DEM runs that a proposal takes."""
        return len(self._solvers)

    def identities(self, proposal: Proposal) -> dict[str, str]:
        """Identity of the run of a proposal by name of the test."""
        return {
            test: run_identity(solver.definition(proposal.parameters, proposal.seed))
            for test, solver in self._solvers.items()
        }

    @property
    def has_free_worker(self) -> bool:
        """Whether another run could start at once."""
        return len(self._under_way) < self._workers

    @property
    def under_way(self) -> int:
        """Number of runs that have been started and have not ended."""
        return len(self._under_way)

    @property
    def has_pending(self) -> bool:
        """Whether there are proposals that `wait` has not returned."""
        return bool(self._pending)

    def start(self, proposal: Proposal) -> dict[str, str]:
        """Start the runs of a proposal that are not known yet; return identities by test."""
        entry = _Pending(proposal)
        identities = {}
        for test, solver in self._solvers.items():
            definition = solver.definition(proposal.parameters, proposal.seed)
            identity = identities[test] = run_identity(definition)
            known = self._store.find(identity)
            if known is not None and _is_final(known, solver):
                entry.records[test] = known
                entry.reused += 1
                entry.reused_seconds += known.seconds
                continue
            entry.waiting.setdefault(identity, []).append(test)
            if identity not in self._under_way:
                self._under_way.add(identity)
                record = RunRecord(identity, test, "running", definition)
                self._executor.submit(self._run, record, solver, proposal)
        self._pending.append(entry)
        return identities

    def wait(self, poll: Callable[[], None] | None = None) -> list[Evaluation]:
        """Return the proposals that are complete, waiting until there is at least one.

        ``poll`` is called a few times a second meanwhile, to redraw progress.
        """
        if not self._pending:
            raise RuntimeError("nothing has been started that could be waited for")
        while not (complete := [entry for entry in self._pending if not entry.waiting]):
            try:
                record = self._ended.get(timeout=0.25)
            except queue.Empty:
                if poll is not None:
                    poll()
                continue
            if isinstance(record, BaseException):
                raise record
            self._settle(record)
        self._pending = [entry for entry in self._pending if entry.waiting]
        return [_evaluation(entry) for entry in complete]

    def _settle(self, record: RunRecord) -> None:
        self._under_way.discard(record.identity)
        for entry in self._pending:
            for test in entry.waiting.pop(record.identity, []):
                entry.records[test] = record

    def forget_failures(self, evaluations: Iterable[Evaluation]) -> None:
        """Let failed runs be made again at the next start: what made them fail may be mended."""
        for evaluation in evaluations:
            for test in evaluation.failures:
                self._store.forget(evaluation.runs[test])

    def cancel(self) -> None:
        """End the runs under way; what has finished stays."""
        self._cancelled.set()
        # In-process functions cannot be ended from outside and must not hold up the user.
        self._executor.shutdown(
            wait=all(solver.uses_folder for solver in self._solvers.values()), cancel_futures=True
        )

    def close(self) -> None:
        """Release threads and temporary folders."""
        self._executor.shutdown(wait=not self._cancelled.is_set())
        if self._temporary is not None:
            self._temporary.cleanup()

    def _run(self, record: RunRecord, solver: Solver, proposal: Proposal) -> None:
        """Make one run in a worker thread; its record is safe before anybody hears of it."""
        try:
            outcome = self._attempt(record, solver, proposal)
            if outcome is not None:
                self._ended.put(outcome)
        except OSError as error:
            reason = f"the work folder {str(self._folder)!r} cannot be written: {error}"
            self._ended.put(StoreError(f"{reason}. Make room there and start again."))
        except BaseException as error:
            self._ended.put(error)

    def _attempt(self, record: RunRecord, solver: Solver, proposal: Proposal) -> RunRecord | None:
        self._store.save(record)
        for attempt in range(ATTEMPTS):
            outcome = self._simulate(record, solver, proposal)
            if outcome.kind == "cancelled":
                self._store.forget(record.identity)
                workdir.discard_run_folder(self._folder, record.identity)
                return None
            if outcome.kind != "machine" or attempt == ATTEMPTS - 1:
                break
        if solver.uses_folder:
            workdir.close_run_folder(self._folder, outcome)
        self._store.save(outcome)
        return outcome

    def _simulate(self, record: RunRecord, solver: Solver, proposal: Proposal) -> RunRecord:
        started = time.monotonic()
        folder = self._folder
        try:
            if self._cancelled.is_set():
                raise RunFailedError("stopped by the user", kind="cancelled")
            if solver.uses_folder:
                folder = workdir.open_run_folder(self._folder, record.identity)
            workspace = Workspace(folder, self._timeouts.get(record.test), self._cancelled)
            responses = solver.run(proposal.parameters, proposal.seed, workspace)
            _refuse_non_finite(responses)
            outcome = replace(record, status="finished", responses=responses)
        except RunFailedError as error:
            outcome = replace(
                record,
                status="failed",
                reason=error.reason,
                kind=error.kind,
                log_tail=error.log_tail,
            )
        except GrainfitError as error:
            outcome = replace(record, status="failed", reason=str(error), kind="simulation")
        except OSError as error:
            outcome = replace(record, status="failed", reason=str(error), kind="machine")
        except Exception as error:
            reason = f"unexpected {type(error).__name__}: {error}"
            tail = "".join(traceback.format_exception(error))[-_TAIL_CHARACTERS:]
            outcome = replace(
                record, status="failed", reason=reason, kind="evaluation", log_tail=tail
            )
        return replace(outcome, seconds=time.monotonic() - started, ended=time.time())


def response_name(test: str, name: str, tests: int) -> str:
    """Name of a test's response in a calibration with this number of tests."""
    return name if tests == 1 else f"{test}.{name}"


def _is_final(record: RunRecord, solver: Solver) -> bool:
    """Whether it would be a waste to make the run again."""
    if record.status == "finished":
        # An own model may yield a response now that it did not yield then.
        return set(solver.response_names or ()) <= record.responses.keys()
    return record.status == "failed" and record.kind not in ("machine", "timeout")


def _refuse_non_finite(responses: Mapping[str, Response]) -> None:
    for name, response in responses.items():
        if not (math.isfinite(response.value) and math.isfinite(response.standard_error)):
            raise RunFailedError(f"response {name} is {response.value}", kind="evaluation")


def _evaluation(entry: _Pending) -> Evaluation:
    responses = {
        response_name(test, name, len(entry.records)): response
        for test, record in entry.records.items()
        for name, response in record.responses.items()
    }
    records = entry.records
    failed = {test: record for test, record in records.items() if record.status == "failed"}
    return Evaluation(
        entry.proposal,
        responses,
        {test: record.reason for test, record in failed.items()},
        entry.reused,
        {test: record.identity for test, record in records.items()},
        sum(record.seconds for record in records.values()),
        sum(record.seconds for record in records.values()) - entry.reused_seconds,
        bool(failed) and all(record.kind == "machine" for record in failed.values()),
    )
