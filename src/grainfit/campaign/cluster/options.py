"""Options of the cluster jobs that execute DEM runs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from grainfit.campaign import messages
from grainfit.errors import Fault, InputError

#: Command that submits a job, by scheduler.
SCHEDULERS = {"slurm": "sbatch"}
#: Limits of the time that a job lasts, s.
SHORTEST_WALLTIME = 60.0
LONGEST_WALLTIME = 365 * 86400.0
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.,:@+-]{0,199}")
_OPTION = re.compile(r"--(?P<name>[a-z][a-z0-9-]*)(=.+)?")
#: Directives that have their own key.
_KEYS = {"partition": "partition", "account": "account", "time": "walltime"}
#: Directives that grainfit sets itself, to keep contact with its jobs.
_DECIDED = (
    *("array", "chdir", "clusters", "cpus-per-task", "error", "help", "input", "job-name"),
    *("nodes", "ntasks", "ntasks-per-node", "output", "parsable", "quiet", "requeue"),
    *("test-only", "usage", "version", "wait", "wrap"),
)


@dataclass(frozen=True)
class ClusterOptions:
    """Options of the cluster jobs that execute DEM runs.

    Parameters
    ----------
    scheduler : {"slurm"}
        Scheduler of the cluster.
    partition, account : str, optional
        Partition and account of the jobs; the scheduler's defaults otherwise.
    walltime : float, optional
        Longest duration of a job, s, rounded down to whole minutes. Required without ``parsl``.
    jobs : int
        Largest number of jobs at a time.
    runs_per_job : int
        Runs at a time in one job.
    cores_per_run : int, optional
        Cores per run, 1 by default; a job requests the cores of all its runs.
    setup : tuple of str
        Shell lines that a job executes first, such as ``module load liggghts``.
    options : tuple of str
        Further directives for the scheduler, such as ``--mem=4G``.
    parsl : str, optional
        ``"file.py:name"``: a custom Parsl configuration. It replaces all other options except
        ``jobs`` and ``runs_per_job``, which then give the number of runs at a time.

    Raises
    ------
    InputError
        Options that cannot be used; lists all faults.
    """

    scheduler: str = "slurm"
    partition: str | None = None
    account: str | None = None
    walltime: float | None = None
    jobs: int = 1
    runs_per_job: int = 1
    cores_per_run: int | None = None
    setup: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    parsl: str | None = None

    def __post_init__(self) -> None:
        faults = list(self._faults())
        if faults:
            raise InputError(faults)

    @property
    def workers(self) -> int:
        """Largest number of runs at a time."""
        return self.jobs * self.runs_per_job

    def _faults(self) -> Iterator[Fault]:
        if self.scheduler not in SCHEDULERS:
            known = ", ".join(SCHEDULERS)
            yield messages.NOT_KNOWN.fault("scheduler", given=self.scheduler, known=known)
        for key in ("jobs", "runs_per_job", "cores_per_run"):
            count = getattr(self, key)
            if count is not None and count < 1:
                yield messages.BELOW_ONE.fault(key, given=count)
        yield from self._faults_with_own_parsl() if self.parsl else self._faults_of_jobs()

    def _faults_with_own_parsl(self) -> Iterator[Fault]:
        for key in ("partition", "account", "walltime", "setup", "options"):
            if getattr(self, key):
                yield messages.BESIDE_PARSL.fault(key)

    def _faults_of_jobs(self) -> Iterator[Fault]:
        for key in ("partition", "account"):
            name = getattr(self, key)
            if name is not None and not _NAME.fullmatch(name):
                yield messages.NO_NAME.fault(key, given=name)
        if self.walltime is None:
            yield messages.NO_WALLTIME.fault("walltime")
        elif not SHORTEST_WALLTIME <= self.walltime <= LONGEST_WALLTIME:
            yield messages.WALLTIME.fault("walltime", given=self.walltime)
        for line in self.setup:
            if not line.strip() or not line.isprintable():
                yield messages.NOT_ONE_LINE.fault("setup", given=line)
        for option in self.options:
            yield from _faults_of_option(option)


def _faults_of_option(option: str) -> Iterator[Fault]:
    form = _OPTION.fullmatch(option)
    if form is None or not option.isprintable():
        yield messages.NO_DIRECTIVE.fault("options", given=option)
        return
    # sbatch understands the beginning of a name too.
    name = form["name"]
    for directive, key in _KEYS.items():
        if directive.startswith(name):
            yield messages.HAS_A_KEY.fault("options", given=option, key=key)
    if any(directive.startswith(name) for directive in _DECIDED):
        yield messages.DECIDED.fault("options", given=option)
