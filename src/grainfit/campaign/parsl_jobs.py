"""Jobs of a cluster by Parsl: submitted on demand, watched, replaced when lost, and ended."""

from __future__ import annotations

import ctypes
import getpass
import logging
import re
import shlex
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from functools import partial
from itertools import takewhile
from pathlib import Path
from typing import Any, NoReturn, ParamSpec, TypeVar

import psutil
from parsl.concurrent import ParslPoolExecutor
from parsl.config import Config
from parsl.dataflow.dflow import DataFlowKernel
from parsl.executors import HighThroughputExecutor
from parsl.executors.errors import BadStateException
from parsl.executors.high_throughput.executor import (
    DEFAULT_INTERCHANGE_LAUNCH_CMD,
    DEFAULT_LAUNCH_CMD,
)
from parsl.executors.status_handling import BlockProviderExecutor
from parsl.jobs.states import TERMINAL_STATES, JobState, JobStatus
from parsl.logconfigs.file import FileLogging
from parsl.providers import SlurmProvider
from parsl.providers.errors import SubmitException

from grainfit.campaign.cluster import ClusterOptions
from grainfit.errors import ExecutorError, GrainfitError
from grainfit.solvers.python_file import PythonFile

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")

#: A job that does not report for the second time is lost.
_HEARTBEAT_SECONDS = 5
_LOST_SECONDS = 20
_STATUS_SECONDS = 10
_LOOK_SECONDS = 3
#: So many jobs, one after the other and over this time, have to fail before all hope is given up.
_FAILED_STARTS = 3
_FAILED_START_SECONDS = 25.0
_END_SECONDS = 30.0
_GRACE_SECONDS = 0.1
_PR_SET_PDEATHSIG = 1
_INTERCHANGE = [sys.executable, "-P", str(Path(__file__).with_name("interchange.py"))]
_WORKER_POOL = (
    f"{shlex.quote(sys.executable)} -P -m parsl.executors.high_throughput.process_worker_pool"
)
_STATES = {
    "PENDING": JobState.PENDING,
    "CONFIGURING": JobState.PENDING,
    "REQUEUED": JobState.PENDING,
    "SUSPENDED": JobState.HELD,
    "CANCELLED": JobState.CANCELLED,
    "COMPLETED": JobState.COMPLETED,
    # On a node that does not answer it can last long, and such a job takes no run any more.
    "COMPLETING": JobState.COMPLETED,
    "TIMEOUT": JobState.TIMEOUT,
    "DEADLINE": JobState.TIMEOUT,
    "PREEMPTED": JobState.TIMEOUT,
    "BOOT_FAIL": JobState.FAILED,
    "FAILED": JobState.FAILED,
    "NODE_FAIL": JobState.FAILED,
    "OUT_OF_MEMORY": JobState.FAILED,
    "REVOKED": JobState.FAILED,
}
#: What sbatch says of a job that will not be accepted later either.
_REFUSED = re.compile(r"invalid|not permitted|not available|violates", re.IGNORECASE)
#: Reasons for which Slurm accepts a job and never starts it.
_NEVER = {
    *("AssocMaxCpuPerJobLimit", "AssocMaxMemPerJob", "AssocMaxWallDurationPerJobLimit"),
    *("BadConstraints", "InvalidAccount", "InvalidQOS", "PartitionNodeLimit"),
    *("PartitionTimeLimit", "QOSMaxCpuPerJobLimit", "QOSMaxMemoryPerJob"),
    "QOSMaxWallDurationPerJobLimit",
}


@contextmanager
def jobs_of(options: ClusterOptions, folder: Path) -> Iterator[Executor]:
    """See `grainfit.campaign.cluster.cluster_executor`; the folder is that of Parsl."""
    config = _own_config(options.parsl) if options.parsl else _slurm_config(options)
    config.run_dir = str(folder)
    config.usage_tracking = 0
    # The campaign decides which runs are tried again.
    config.retries = 0
    with _signals_wait():
        jobs = _Jobs(DataFlowKernel(config))
    try:
        yield jobs
    finally:
        with _signals_wait():
            jobs.end()


def _slurm_config(options: ClusterOptions) -> Config:
    assert options.walltime is not None, "options without it are refused"
    minutes = int(options.walltime // 60)
    cores_per_run = options.cores_per_run or 1
    provider = _Slurm(
        partition=options.partition,
        account=options.account,
        walltime=f"{minutes // 60:02d}:{minutes % 60:02d}:00",
        cores_per_node=options.runs_per_job * cores_per_run,
        init_blocks=0,
        max_blocks=options.jobs,
        exclusive=False,
        worker_init="\n".join(options.setup),
        # A job that lost its node is replaced here; it must not come back besides.
        scheduler_options=_directives(["--no-requeue", *options.options]),
        cmd_timeout=30,
    )
    executor = HighThroughputExecutor(
        label="grainfit",
        provider=provider,
        # All interfaces. Without an address Parsl would ask the internet for one.
        address="0.0.0.0",
        max_workers_per_node=options.runs_per_job,
        cores_per_worker=float(cores_per_run),
        heartbeat_period=_HEARTBEAT_SECONDS,
        heartbeat_threshold=_LOST_SECONDS,
        launch_cmd=DEFAULT_LAUNCH_CMD.replace("process_worker_pool.py", _WORKER_POOL),
        interchange_launch_cmd=_INTERCHANGE,
        block_error_handler=_GiveUp(provider),
    )
    executor.all_addresses = _addresses()
    return Config(
        executors=[executor],
        strategy_period=_LOOK_SECONDS,
        initialize_logging=FileLogging(level=logging.INFO),
    )


def _directives(options: Iterable[str]) -> str:
    return "\n".join(f"#SBATCH {option}" for option in options)


def _addresses() -> set[str]:
    """Addresses of this machine at which jobs may reach it."""
    return {
        address.address
        for addresses in psutil.net_if_addrs().values()
        for address in addresses
        if address.family == socket.AF_INET
    }


def _own_config(reference: str) -> Config:
    try:
        file = PythonFile(reference)
        file.check()
        config = file.load()
    except GrainfitError:
        raise
    except Exception as error:
        raise GrainfitError(f"{reference}: {type(error).__name__}: {error}") from error
    if not isinstance(config, Config):
        raise GrainfitError(f"{reference} is a {type(config).__name__}, not a parsl.Config.")
    for executor in config.executors:
        if (
            isinstance(executor, HighThroughputExecutor)
            and list(executor.interchange_launch_cmd) == DEFAULT_INTERCHANGE_LAUNCH_CMD
        ):
            executor.interchange_launch_cmd = _INTERCHANGE
    return config


class _Jobs(Executor):
    """Runs in the jobs of a Parsl kernel."""

    def __init__(self, kernel: DataFlowKernel) -> None:
        self._kernel = kernel
        self._pool = ParslPoolExecutor(dfk=kernel)
        self._open: set[Future[Any]] = set()
        self._ending = threading.Event()
        threading.Thread(target=self._watch, name="interchange-watch", daemon=True).start()

    def submit(
        self,
        fn: Callable[_Arguments, _Result],
        /,
        *args: _Arguments.args,
        **kwargs: _Arguments.kwargs,
    ) -> Future[_Result]:
        """Have a call made in a job; it must be possible to pickle all of it."""
        future: Future[_Result] = Future()
        self._open.add(future)
        # Packed, because some arguments have a meaning to Parsl.
        task = self._pool.submit(_in_job, fn, args, kwargs)
        task.add_done_callback(partial(self._pass_on, future))
        return future

    def _pass_on(self, future: Future[Any], task: Future[Any]) -> None:
        error = task.exception()
        if isinstance(error, BadStateException):
            error = ExecutorError(error.reason)
        self._settle(future, None if error else task.result(), error)

    def _settle(self, future: Future[Any], result: Any, error: BaseException | None) -> None:
        self._open.discard(future)
        if future.done() or not future.set_running_or_notify_cancel():
            return
        if error is None:
            future.set_result(result)
        else:
            future.set_exception(error)

    def _watch(self) -> None:
        """Fail all runs once an interchange is gone; Parsl would wait for them for ever."""
        while not self._ending.wait(_HEARTBEAT_SECONDS):
            if any(process.poll() is not None for process in self._interchanges()):
                error = ExecutorError(
                    "Parsl's interchange, which speaks with the jobs of the cluster, was ended. "
                    f"Its log is in {self._kernel.run_dir}. Start again to go on."
                )
                for future in list(self._open):
                    self._settle(future, None, error)

    def _interchanges(self) -> list[subprocess.Popen[bytes]]:
        executors = self._kernel.executors.values()
        found = [getattr(executor, "interchange_proc", None) for executor in executors]
        return [process for process in found if process is not None]

    def end(self) -> None:
        """End all jobs, whatever state they are in, and every process on this machine."""
        self._ending.set()
        # Parsl waits for ever for an interchange that does not answer.
        dead = any(process.poll() is not None for process in self._interchanges())
        cleanup = threading.Thread(target=self._kernel.cleanup, name="parsl-cleanup", daemon=True)
        cleanup.start()
        cleanup.join(1.0 if dead else _END_SECONDS)
        for process in self._interchanges():
            process.kill()
        for executor in self._kernel.executors.values():
            # Parsl leaves the jobs of an executor on which it has given up.
            if isinstance(executor, BlockProviderExecutor) and executor.provider is not None:
                if executor.bad_state_is_set or cleanup.is_alive():
                    executor.provider.cancel(list(executor.blocks_to_job_id.values()))
                if isinstance(executor.provider, _Slurm):
                    executor.provider.wait_until_gone()


class _JobEnded(BaseException):
    """The job is being ended; no exception of a run, which the run itself would handle."""


def _in_job(
    function: Callable[..., _Result], arguments: Sequence[Any], named: Mapping[str, Any]
) -> _Result:
    """Make a call in a worker of a job; when the job is ended, so is what the call has started."""
    signal.signal(signal.SIGTERM, _end_job)
    # Not every Slurm finds the processes of a job whose parent was the first to be ended.
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    result = function(*arguments, **named)
    # The processes of a job are ended one by one. That a solver was ended before its worker says
    # nothing of the run, and must not be taken for its result.
    time.sleep(_GRACE_SECONDS)
    return result


def _end_job(_signal: int, _frame: object) -> NoReturn:
    raise _JobEnded


class _Slurm(SlurmProvider):
    """Slurm, asked for more than Parsl asks: how a job ended, and whether it will ever start."""

    #: Why no job like these can ever start, as far as Slurm has said so.
    refusal = ""

    @property
    def status_polling_interval(self) -> int:
        """Seconds between two looks at the queue."""
        return _STATUS_SECONDS

    def submit(self, command: str, tasks_per_node: int, job_name: str = "grainfit") -> str:
        """Submit a job; an error has Slurm's own words."""
        try:
            job: str = super().submit(command, tasks_per_node, job_name)
        except SubmitException as error:
            words = " ".join((error.stderr or error.message).split())
            if _REFUSED.search(words):
                self.refusal = words
            raise ExecutorError(words) from error
        return job

    def cancel(self, job_ids: Sequence[object]) -> list[bool]:
        """End jobs."""
        return list(super().cancel(job_ids)) if job_ids else []  # type: ignore[no-untyped-call]

    def _status(self) -> None:
        queue = self._queue()
        if queue is None:
            return
        for job, entry in self.resources.items():
            if entry["status"].terminal:
                continue
            word, reason = queue.get(str(job), ("COMPLETED", ""))
            state = _STATES.get(word, JobState.RUNNING)
            message = f"Slurm says of its job {job}: {word}, {reason}"
            if state == JobState.PENDING and reason in _NEVER:
                self.cancel([job])
                state, self.refusal = JobState.FAILED, message
            entry["status"] = JobStatus(
                state, message, None, entry["job_stdout_path"], entry["job_stderr_path"]
            )

    def _queue(self) -> dict[str, tuple[str, str]] | None:
        """State and reason of the user's jobs by number; None when Slurm does not answer."""
        user = getpass.getuser()
        command = ["squeue", "--noheader", "--states=all", f"--user={user}", "--format=%i|%T|%r"]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=self.cmd_timeout, check=True
            )
        except (OSError, subprocess.SubprocessError):
            return None
        rows = [line.split("|") for line in done.stdout.splitlines()]
        return {row[0].strip(): (row[1], row[2]) for row in rows if len(row) == 3}

    def wait_until_gone(self) -> None:
        """Wait until no process of a cancelled job can be left, or Slurm has had time enough."""
        deadline = time.monotonic() + _END_SECONDS
        while time.monotonic() < deadline:
            queue = self._queue() or {}
            here = {queue[job][0] for job in map(str, self.resources) if job in queue}
            if not here & {"PENDING", "CONFIGURING", "RUNNING", "COMPLETING", "SUSPENDED"}:
                return
            time.sleep(0.2)


class _GiveUp:
    """Gives up when job after job ends before its workers have reported.

    A job that is lost later says nothing against the next one.
    """

    def __init__(self, provider: _Slurm) -> None:
        self._provider = provider
        self._ended: dict[str, float] = {}

    def __call__(self, executor: BlockProviderExecutor, status: dict[str, JobStatus]) -> None:
        """Look at all jobs there have been, by their number."""
        assert isinstance(executor, HighThroughputExecutor)
        connected = set(executor.connected_blocks())
        ended = [job for job in sorted(status, key=int) if status[job].state in TERMINAL_STATES]
        for job in ended:
            self._ended.setdefault(job, time.monotonic())
        # The last ones, back to the last one that did start.
        failed = list(takewhile(lambda job: job not in connected, reversed(ended)))
        refusal = self._provider.refusal
        if executor.bad_state_is_set or not (refusal or len(failed) >= _FAILED_STARTS):
            return
        at_work = [job for job in status if job in connected and job not in ended]
        if at_work:
            # The jobs that did start do the work; others would fail again every few seconds.
            self._provider.max_blocks = len(at_work)
        elif refusal:
            self._give_up(executor, refusal)
        elif time.monotonic() - self._ended[failed[-1]] > _FAILED_START_SECONDS:
            last = status[failed[0]]
            output = (last.stderr_summary or "").strip().splitlines()
            message = re.sub(r"^Failed to start block \d+: ", "", last.message or "")
            self._give_up(executor, output[-1] if output else message)

    def _give_up(self, executor: BlockProviderExecutor, why: str) -> None:
        reason = f"no job of the cluster starts: {why.rstrip('.')}. Scripts and output of the jobs"
        reason += f" are in {self._provider.script_dir}."
        executor.set_bad_state_and_fail_all(ExecutorError(reason))


@contextmanager
def _signals_wait() -> Iterator[None]:
    """Let Ctrl-C and a termination wait until Parsl is in a state in which it can be ended."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    caught: list[int] = []
    numbers = (signal.SIGINT, signal.SIGTERM)
    handlers = [signal.signal(number, lambda *given: caught.append(given[0])) for number in numbers]
    try:
        yield
    finally:
        for number, handler in zip(numbers, handlers, strict=True):
            signal.signal(number, handler)
        if caught:
            signal.raise_signal(caught[0])
