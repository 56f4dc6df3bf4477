"""Manage cluster jobs with Parsl: submit them on demand, watch, replace and end them."""

from __future__ import annotations

import ctypes
import logging
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
from parsl.launchers import SimpleLauncher
from parsl.logconfigs.file import FileLogging

from grainfit.campaign import messages
from grainfit.campaign.cluster.followed import END_SECONDS, Followed, GridEngine, Lsf, Pbs
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.campaign.cluster.slurm import GiveUp, Slurm
from grainfit.campaign.pending import ClusterJob
from grainfit.errors import ExecutorError, GrainfitError
from grainfit.options.python_file import PythonFile
from grainfit.solvers.process.process import OVER_NODES

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")
#: A job that does not report for the second time is lost.
_HEARTBEAT_SECONDS = 5
_LOST_SECONDS = 20
_LOOK_SECONDS = 3
_GRACE_SECONDS = 0.1
_PR_SET_PDEATHSIG = 1
_INTERCHANGE = [sys.executable, "-P", str(Path(__file__).with_name("interchange.py"))]
_WORKER_POOL = (
    f"{shlex.quote(sys.executable)} -P -m parsl.executors.high_throughput.process_worker_pool"
)


@contextmanager
def jobs_of(options: ClusterOptions, folder: Path) -> Iterator[Executor]:
    """See `grainfit.campaign.cluster.executor.cluster_executor`; the folder is that of Parsl."""
    config = _own_config(options.parsl) if options.parsl else _config(options)
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


def _provider(options: ClusterOptions) -> Followed:
    """Return what submits the jobs; a lost one is replaced here, and must not be requeued."""
    assert options.walltime is not None, "options without it are refused"
    minutes = int(options.walltime // 60)
    cores = options.cores
    given: dict[str, Any] = {
        "walltime": f"{minutes // 60:02d}:{minutes % 60:02d}:00",
        "init_blocks": 0,
        "max_blocks": options.jobs,
        "worker_init": "\n".join(options.setup),
        "cmd_timeout": 30,
    }
    queue, account = options.partition, options.account
    match options.scheduler:
        case "pbs":
            chunks = [one for one in options.options if one.startswith(":")]
            others = [one for one in options.options if not one.startswith(":")]
            return Pbs(  # type: ignore[no-untyped-call]
                queue=queue,
                account=account,
                cpus_per_node=cores,
                select_options="".join(chunks),
                scheduler_options=_directives("#PBS", ["-r n", *others]),
                **given,
            )
        case "sge":
            wanted = ["-r n", *([f"-P {account}"] if account else [])]
            wanted += [f"-pe {options.parallel_environment or 'smp'} {cores}"] if cores > 1 else []
            directives = _directives("#$", [*wanted, *options.options])
            return GridEngine(queue=queue, scheduler_options=directives, **given)
        case "lsf":
            return Lsf(  # type: ignore[no-untyped-call]
                queue=queue,
                project=account,
                request_by_nodes=False,
                cores_per_block=cores,
                cores_per_node=cores,
                bsub_redirection=True,
                scheduler_options=_directives("#BSUB", ["-rn", *options.options]),
                **given,
            )
    wanted = ["--no-requeue"]
    if options.nodes_per_run == 1:
        given["cores_per_node"] = cores
    else:
        # The launcher of MPI starts as many ranks on a node as the job has tasks there; the worker
        # is on the first one.
        wanted += [f"--ntasks-per-node={options.tasks_per_node}", "--cpus-per-task=1"]
        lines = (f"export PARSL_CORES={cores}", f"export {OVER_NODES}=1", *options.setup)
        given |= {"worker_init": "\n".join(lines), "launcher": SimpleLauncher()}
    return Slurm(
        partition=queue,
        account=account,
        nodes_per_block=options.nodes_per_run,
        exclusive=False,
        scheduler_options=_directives("#SBATCH", [*wanted, *options.options]),
        **given,
    )


def _config(options: ClusterOptions) -> Config:
    provider = _provider(options)
    executor = HighThroughputExecutor(
        label="grainfit",
        provider=provider,
        # All interfaces. Without an address Parsl would ask the internet for one.
        address="0.0.0.0",
        max_workers_per_node=options.runs_per_job,
        cores_per_worker=float(options.cores_per_run or 1),
        heartbeat_period=_HEARTBEAT_SECONDS,
        heartbeat_threshold=_LOST_SECONDS,
        launch_cmd=DEFAULT_LAUNCH_CMD.replace("process_worker_pool.py", _WORKER_POOL),
        interchange_launch_cmd=_INTERCHANGE,
        block_error_handler=GiveUp(provider),
    )
    executor.all_addresses = _addresses()
    return Config(
        executors=[executor],
        strategy_period=_LOOK_SECONDS,
        initialize_logging=FileLogging(level=logging.INFO),
    )


def _directives(sign: str, options: Iterable[str]) -> str:
    return "\n".join(f"{sign} {option}" for option in options)


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
        kind = type(config).__name__
        raise GrainfitError(messages.NO_CONFIG(reference=reference, kind=kind))
    for executor in config.executors:
        if isinstance(executor, HighThroughputExecutor):
            # Of a calibration that is killed, workers go on for as long as they wait to hear of it.
            executor.heartbeat_period = min(executor.heartbeat_period, _HEARTBEAT_SECONDS)
            executor.heartbeat_threshold = min(executor.heartbeat_threshold, _LOST_SECONDS)
            if list(executor.interchange_launch_cmd) == DEFAULT_INTERCHANGE_LAUNCH_CMD:
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
        """Execute a call in a job; all of it must be picklable."""
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
        """Fail all runs once an interchange has ended; Parsl would wait for them forever."""
        while not self._ending.wait(_HEARTBEAT_SECONDS):
            if any(process.poll() is not None for process in self._interchanges()):
                folder = self._kernel.run_dir
                error = ExecutorError(messages.INTERCHANGE_ENDED(folder=folder))
                for future in list(self._open):
                    self._settle(future, None, error)

    def _interchanges(self) -> list[subprocess.Popen[bytes]]:
        executors = self._kernel.executors.values()
        found = [getattr(executor, "interchange_proc", None) for executor in executors]
        return [process for process in found if process is not None]

    def cluster_jobs(self) -> list[ClusterJob]:
        """Return the jobs so far, as the scheduler described them last; it is not asked again."""
        return [
            ClusterJob(
                str(executor.blocks_to_job_id.get(block, "")),
                status.state.name.lower(),
                " ".join((status.message or "").split()),
            )
            for executor in list(self._kernel.executors.values())
            if isinstance(executor, BlockProviderExecutor)
            for block, status in list(executor.status_facade.items())
        ]

    def end(self) -> None:
        """End all jobs in any state, and every process on this machine."""
        self._ending.set()
        # Parsl waits forever for an interchange that does not answer.
        dead = any(process.poll() is not None for process in self._interchanges())
        cleanup = threading.Thread(target=self._kernel.cleanup, name="parsl-cleanup", daemon=True)
        cleanup.start()
        cleanup.join(1.0 if dead else END_SECONDS)
        for process in self._interchanges():
            process.kill()
        for executor in self._kernel.executors.values():
            # Parsl does not end the jobs of an executor in a bad state.
            if isinstance(executor, BlockProviderExecutor) and executor.provider is not None:
                if executor.bad_state_is_set or cleanup.is_alive():
                    executor.provider.cancel(list(executor.blocks_to_job_id.values()))
                if isinstance(executor.provider, Followed):
                    executor.provider.wait_until_gone()


class _JobEnded(BaseException):
    """The job is being ended. A BaseException, because a run would handle an Exception."""


def _in_job(
    function: Callable[..., _Result], arguments: Sequence[Any], named: Mapping[str, Any]
) -> _Result:
    """Execute a call in a worker of a job; its processes end with the job."""
    signal.signal(signal.SIGTERM, _end_job)
    # Not every scheduler finds the processes of a job whose parent was ended first.
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    result = function(*arguments, **named)
    # The processes of a job are ended one by one. A solver that was ended before its worker must
    # not count as a failed run.
    time.sleep(_GRACE_SECONDS)
    return result


def _end_job(_signal: int, _frame: object) -> NoReturn:
    raise _JobEnded


@contextmanager
def _signals_wait() -> Iterator[None]:
    """Delay Ctrl-C and termination until Parsl is in a state in which it can be ended."""
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
