"""Jobs that say why they do not start: what the providers of all schedulers share."""

from __future__ import annotations

import re
import shutil
import subprocess
import time
from collections.abc import Mapping, Sequence
from typing import Any

from parsl.jobs.states import JobState, JobStatus
from parsl.providers import GridEngineProvider, LSFProvider, PBSProProvider
from parsl.providers.cluster_provider import ClusterProvider
from parsl.providers.errors import SubmitException

from grainfit.campaign import messages
from grainfit.errors import ExecutorError

_STATUS_SECONDS = 10
END_SECONDS = 30.0
#: Messages of schedulers for a job that will not be accepted later either.
_REFUSED = re.compile(
    r"invalid|illegal|unknown|not permitted|not available|not exist|not defined|violates|rejected|"
    r"unauthorized|no such|exceed",
    re.IGNORECASE,
)
#: States of Grid Engine in which a job waits, or is about to run; others with these letters run.
_WAITING, _IN_ERROR, _IN_DELETION = ("qw", "hqw", "t"), "E", "d"


class Followed(ClusterProvider):
    """Provider of a scheduler's jobs whose faults have the words of the scheduler.

    It comes first among the bases of a provider, and `Heard` last.
    """

    #: Name of the scheduler for messages, and command that lists the jobs that have not ended.
    scheduler = ""
    listing = ""
    #: Reason, given by the scheduler, for which no such job can ever start.
    refusal = ""
    #: What the scheduler said last of a command that failed.
    heard = ""
    #: The script that was written last.
    script = ""
    #: What the scheduler says in place of a list of its jobs, and since when, s; "" if it lists
    #: them.
    silence = ""
    silent_since = 0.0

    @property
    def status_polling_interval(self) -> int:
        """Interval at which the queue is checked, s."""
        return _STATUS_SECONDS

    def submit(self, command: str, tasks_per_node: int, job_name: str = "grainfit") -> str:
        """Submit a job; an error has the message of the scheduler."""
        self.heard = ""
        message = ""
        job: str | None = None
        provider: Any = super()
        try:
            job = provider.submit(command, tasks_per_node, job_name)
        except SubmitException as error:
            message = error.stderr or error.message
        if job is not None:
            self.resources[job].setdefault("job_stdout_path", f"{self.script}.stdout")
            self.resources[job].setdefault("job_stderr_path", f"{self.script}.stderr")
            return job
        message = " ".join((message or self.heard).split())
        if _REFUSED.search(message):
            self.refusal = message
        raise ExecutorError(message)

    def cancel(self, job_ids: Sequence[object]) -> list[bool]:
        """End jobs."""
        provider: Any = super()
        return list(provider.cancel(job_ids)) if job_ids else []

    def wait_until_gone(self) -> None:
        """Wait until all jobs have ended, at most `END_SECONDS`."""
        deadline = time.monotonic() + END_SECONDS
        own = {_number(job) for job in self.resources}
        while own & self._listed() and time.monotonic() < deadline:
            time.sleep(0.5)

    def note_answer(self, fault: str) -> None:
        """Note whether the scheduler has listed its jobs: its words if it has not, or ""."""
        if fault and not self.silence:
            self.silent_since = time.monotonic()
        self.silence = " ".join(fault.split())
        command = self.listing.split()[0]
        if fault and shutil.which(command) is None:
            self.refusal = messages.NO_COMMAND(command=command)

    def _status(self) -> None:
        provider: Any = super()
        self.heard = ""
        provider._status()
        self.note_answer(self.heard)
        for job, entry in self.resources.items():
            state = entry["status"].state
            message = f"{self.scheduler} says of its job {job}: {state.name}"
            paths = entry["job_stdout_path"], entry["job_stderr_path"]
            entry["status"] = JobStatus(state, message, None, *paths)

    def _listed(self) -> set[str]:
        text: str = self.execute_wait(self.listing)[1]  # type: ignore[no-untyped-call]
        return {_number(line.split()[0]) for line in text.splitlines() if line.strip()}


def _number(job: object) -> str:
    return str(job).partition(".")[0]


class Heard(ClusterProvider):
    """Keep what a scheduler said, and the name of the script that it was given."""

    def execute_wait(self, cmd: str, timeout: float | None = None) -> tuple[int, str, str]:
        """Execute a command of the scheduler."""
        provider: Any = super()
        done: tuple[int, str, str]
        try:
            done = provider.execute_wait(cmd, timeout)
        except subprocess.TimeoutExpired as error:
            done = (1, "", str(error))
        if done[0]:
            self.heard = done[2] or done[1] or f"exit code {done[0]}"
        return done

    def _write_submit_script(
        self, template: str, script_filename: str, job_name: str, configs: Mapping[str, Any]
    ) -> None:
        provider: Any = super()
        provider._write_submit_script(template, script_filename, job_name, configs)
        self.script = script_filename


class GridEngine(Followed, GridEngineProvider, Heard):
    """Jobs of Grid Engine."""

    scheduler, listing = "Grid Engine", "qstat"

    def _status(self) -> None:
        """Read states of jobs; those in an error state never start, and are ended."""
        code, text, _ = self.execute_wait(self.listing)
        self.note_answer(self.heard if code else "")
        if code:
            return
        rows = [line.split() for line in text.splitlines()]
        states = {row[0]: row[4] for row in rows if len(row) > 4 and row[0].isdigit()}
        for job, entry in list(self.resources.items()):
            if entry["status"].terminal:
                continue
            letters = states.get(str(job), "")
            message = f"Grid Engine says of its job {job}: {letters or 'it has ended'}"
            if _IN_ERROR in letters:
                self.heard = self._why_in_error(str(job))
                message = f"{message}, {self.heard}"
                self.cancel([job])
            state = _state(letters)
            paths = entry["job_stdout_path"], entry["job_stderr_path"]
            entry["status"] = JobStatus(state, message, None, *paths)

    def _why_in_error(self, job: str) -> str:
        _, text, _ = self.execute_wait(f"qstat -j {job}")
        reasons = [line for line in text.splitlines() if line.startswith("error reason")]
        return " ".join((reasons[0] if reasons else "in an error state").split())


def _state(letters: str) -> JobState:
    """Return what the letters of Grid Engine mean; none where a job is no longer in its list."""
    if not letters or _IN_DELETION in letters:
        return JobState.COMPLETED
    if _IN_ERROR in letters:
        return JobState.FAILED
    return JobState.PENDING if letters.endswith(_WAITING) else JobState.RUNNING


class Pbs(Followed, PBSProProvider, Heard):
    """Jobs of PBS Professional and OpenPBS."""

    scheduler, listing = "PBS", "qstat"


class Lsf(Followed, LSFProvider, Heard):
    """Jobs of LSF."""

    scheduler, listing = "LSF", "bjobs -noheader -o jobid"
