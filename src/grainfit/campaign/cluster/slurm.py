"""Submit Slurm jobs for Parsl, follow their state, and give up when none starts."""

from __future__ import annotations

import getpass
import re
import subprocess
import time
from collections.abc import Sequence
from itertools import takewhile

from parsl.executors import HighThroughputExecutor
from parsl.executors.status_handling import BlockProviderExecutor
from parsl.jobs.states import TERMINAL_STATES, JobState, JobStatus
from parsl.providers import SlurmProvider

from grainfit.campaign import messages
from grainfit.campaign.cluster.followed import END_SECONDS, Followed, Heard
from grainfit.errors import ExecutorError

#: Number of jobs in a row, and the time over which they fail, before the cluster is given up.
_FAILED_STARTS = 3
_FAILED_START_SECONDS = 25.0
#: Longest time without an answer of Slurm, once a job has started, before it is given up.
_OUTAGE_SECONDS = 600.0
_ALIVE = {"PENDING", "CONFIGURING", "REQUEUED", "RUNNING", "COMPLETING", "SUSPENDED"}
_STATES = {
    "PENDING": JobState.PENDING,
    "CONFIGURING": JobState.PENDING,
    "REQUEUED": JobState.PENDING,
    "SUSPENDED": JobState.HELD,
    "CANCELLED": JobState.CANCELLED,
    "COMPLETED": JobState.COMPLETED,
    # It can last long on a node that does not answer, and such a job accepts no more runs.
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
#: Reasons for which Slurm accepts a job and never starts it.
_NEVER = {
    *("AssocMaxCpuPerJobLimit", "AssocMaxMemPerJob", "AssocMaxWallDurationPerJobLimit"),
    *("BadConstraints", "InvalidAccount", "InvalidQOS", "PartitionNodeLimit"),
    *("PartitionTimeLimit", "QOSMaxCpuPerJobLimit", "QOSMaxMemoryPerJob"),
    "QOSMaxWallDurationPerJobLimit",
}


class Slurm(Followed, SlurmProvider, Heard):
    """Slurm provider that also reports how a job ended and whether it can ever start."""

    scheduler, listing = "Slurm", "squeue"

    def _status(self) -> None:
        queue = self._queue()
        if queue is None:
            return
        for job, entry in self.resources.items():
            code, reason = queue.get(str(job), ("COMPLETED", ""))
            state = _STATES.get(code, JobState.RUNNING)
            if entry["status"].terminal:
                if state in (JobState.PENDING, JobState.RUNNING):
                    # Slurm has requeued it after all, but there is another job in its place.
                    self.cancel([job])
                continue
            message = f"Slurm says of its job {job}: {code}, {reason}"
            if state == JobState.PENDING and reason in _NEVER:
                self.cancel([job])
                state, self.refusal = JobState.FAILED, message
            entry["status"] = JobStatus(
                state, message, None, entry["job_stdout_path"], entry["job_stderr_path"]
            )

    def _queue(self) -> dict[str, tuple[str, str]] | None:
        """State and reason of the user's jobs by number; None when Slurm does not answer."""
        user = getpass.getuser()
        form = ("--noheader", "--states=all", "--format=%i|%T|%r")
        command = [self.listing, *form, f"--user={user}"]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=self.cmd_timeout, check=False
            )
        except (OSError, subprocess.SubprocessError) as error:
            self.note_answer(str(error))
            return None
        if done.returncode:
            self.note_answer(done.stderr.strip() or f"exit code {done.returncode}")
            return None
        self.note_answer("")
        rows = [line.split("|") for line in done.stdout.splitlines()]
        return {row[0].strip(): (row[1], row[2]) for row in rows if len(row) == 3}

    def wait_until_gone(self) -> None:
        """Wait until all cancelled jobs have ended, at most `END_SECONDS`; cancel requeued ones."""
        deadline = time.monotonic() + END_SECONDS
        while time.monotonic() < deadline:
            queue = self._queue() or {}
            codes = {str(job): queue.get(str(job), ("COMPLETED", ""))[0] for job in self.resources}
            if not _ALIVE & set(codes.values()):
                return
            self.cancel([job for job, code in codes.items() if code in _ALIVE - {"COMPLETING"}])
            time.sleep(0.2)


class GiveUp:
    """Give up when several jobs in a row end before their workers have reported.

    A job that is lost later does not count. A job that the scheduler did not accept because it does
    not answer counts for as long as its restart may take.
    """

    def __init__(self, provider: Followed) -> None:
        self._provider = provider
        self._ended: dict[str, float] = {}

    def __call__(self, executor: BlockProviderExecutor, status: dict[str, JobStatus]) -> None:
        """Check all jobs so far, by number."""
        assert isinstance(executor, HighThroughputExecutor)
        connected = set(executor.connected_blocks())
        ended = [job for job in sorted(status, key=int) if status[job].state in TERMINAL_STATES]
        for job in ended:
            self._ended.setdefault(job, time.monotonic())
        # The latest ones, back to the last one that started.
        latest = list(takewhile(lambda job: job not in connected, reversed(ended)))
        failed = [job for job in latest if job in executor.blocks_to_job_id]
        unanswered = list(takewhile(lambda job: job not in executor.blocks_to_job_id, latest))
        refusal = self._provider.refusal
        patience = _OUTAGE_SECONDS if connected else _FAILED_START_SECONDS
        at_work = [job for job in status if job in connected and job not in ended]
        if executor.bad_state_is_set:
            return
        if at_work:
            if refusal or len(failed) >= _FAILED_STARTS:
                # The jobs that started do the work; others would fail again every few seconds.
                self._provider.max_blocks = len(at_work)
        elif refusal:
            self._give_up(executor, refusal)
        elif self._lasts(failed, _FAILED_START_SECONDS):
            self._give_up(executor, _why(status[failed[0]]))
        elif self._lasts(unanswered, patience):
            self._give_up(executor, _why(status[unanswered[0]]))
        elif self._is_silent_for(patience):
            provider = self._provider
            why = messages.NO_LIST(scheduler=provider.scheduler, reason=provider.silence)
            self._give_up(executor, why)

    def _lasts(self, failed: Sequence[str], seconds: float) -> bool:
        """Return True if there are several jobs, and the first of them ended so long ago."""
        if len(failed) < _FAILED_STARTS:
            return False
        return time.monotonic() - self._ended[failed[-1]] > seconds

    def _is_silent_for(self, seconds: float) -> bool:
        provider = self._provider
        return bool(provider.silence) and time.monotonic() - provider.silent_since > seconds

    def _give_up(self, executor: BlockProviderExecutor, why: str) -> None:
        folder = self._provider.script_dir
        reason = messages.NO_JOB_STARTS(reason=why, folder=folder)
        executor.set_bad_state_and_fail_all(ExecutorError(reason))


def _why(last: JobStatus) -> str:
    output = (last.stderr_summary or "").strip().splitlines()
    message = re.sub(r"^Failed to start block \d+: ", "", last.message or "")
    return output[-1] if output else message
