"""Options of the cluster jobs that execute DEM runs."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

from grainfit.campaign import messages
from grainfit.campaign.cluster.parsl_configuration import ParslConfiguration
from grainfit.campaign.cluster.schedulers import SCHEDULERS
from grainfit.errors import Fault, InputError
from grainfit.formatting import duration
from grainfit.options.fields import option
from grainfit.options.kinds import Choice, ListOf, Quantity, Text, Whole

#: Limits of the time that a job lasts, s.
_SHORTEST, _LONGEST = 60.0, 365 * 86400.0
_COUNT = Whole(1, 4096)
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.,:@+-]{0,199}")


@dataclass(frozen=True)
class ClusterOptions:
    """Options of the cluster jobs that execute DEM runs: the fields below, as in the file.

    Raises
    ------
    InputError
        Options that cannot be used; lists all faults.
    """

    scheduler: str = option(
        Choice(tuple(SCHEDULERS)),
        "Scheduler of the cluster; local for runs on this machine.",
        example='"slurm"',
        default="slurm",
        kw_only=False,
    )
    partition: str | None = option(
        Text(),
        "Partition (queue) of the jobs.",
        example='"short"',
        default_text="the scheduler's own",
    )
    account: str | None = option(
        Text(),
        "Account (project) to charge.",
        example='"bulk-solids"',
        default_text="the scheduler's own",
    )
    walltime: float | None = option(
        Quantity("s", above_zero=True),
        "Longest duration of a job, rounded down to whole minutes. Required with jobs and without "
        "parsl.",
        example='"2 h"',
    )
    jobs: int = option(_COUNT, "Largest number of jobs at a time.", example="4", default=1)
    runs_per_job: int = option(_COUNT, "Runs at a time in one job.", example="16", default=1)
    cores_per_run: int | None = option(
        _COUNT,
        "Cores that a run takes; a job requests the cores of all its runs.",
        example="4",
        default_text="the ranks of the tests",
    )
    nodes_per_run: int = option(
        _COUNT,
        "Nodes over which the MPI ranks of a run spread, of Slurm alone. A job then has one run.",
        example="2",
        default=1,
    )
    setup: tuple[str, ...] = option(
        ListOf(Text()),
        "Shell lines that a job executes first.",
        example='["module load liggghts"]',
        default=(),
        default_text="none",
    )
    options: tuple[str, ...] = option(
        ListOf(Text()),
        "Further directives for the scheduler.",
        example='["--mem=4G", "--constraint=skylake"]',
        default=(),
        default_text="none",
    )
    parallel_environment: str | None = option(
        Text(),
        "Parallel environment of Grid Engine that gives a job several cores of one node.",
        example='"smp"',
        default_text="smp",
    )
    parsl: str | None = option(
        ParslConfiguration(),
        "Custom Parsl configuration, a file and the name in it. It replaces all other options "
        "except jobs and runs_per_job, which then give the number of runs at a time.",
        example='"my_parsl.py:config"',
    )

    def __post_init__(self) -> None:
        InputError.raise_for(self._faults())

    @property
    def workers(self) -> int:
        """Largest number of runs at a time."""
        return self.jobs * self.runs_per_job

    @property
    def cores(self) -> int:
        """Cores of a job."""
        return self.runs_per_job * (self.cores_per_run or 1)

    @property
    def tasks_per_node(self) -> int:
        """MPI ranks of a run on each of its nodes."""
        return math.ceil(self.cores / self.nodes_per_run)

    def _faults(self) -> Iterator[Fault]:
        if self.scheduler not in SCHEDULERS:
            known = ", ".join(SCHEDULERS)
            yield messages.NOT_KNOWN.fault("scheduler", given=self.scheduler, known=known)
            return
        yield from self._faults_of_counts()
        if self.parallel_environment and (self.scheduler != "sge" or self.parsl):
            yield messages.OF_GRID_ENGINE.fault("parallel_environment")
        yield from self._faults_with_own_parsl() if self.parsl else self._faults_of_jobs()

    def _faults_of_counts(self) -> Iterator[Fault]:
        for key in ("jobs", "runs_per_job", "cores_per_run", "nodes_per_run"):
            count = getattr(self, key)
            if count is not None and count < 1:
                yield messages.BELOW_ONE.fault(key, given=count)

    def _faults_of_nodes(self, nodes: int) -> Iterator[Fault]:
        if nodes <= 1:
            return
        if self.scheduler != "slurm":
            yield messages.OF_SLURM.fault("nodes_per_run")
        if self.runs_per_job > 1:
            yield messages.ONE_RUN.fault("runs_per_job", given=self.runs_per_job, nodes=nodes)
        if self.cores_per_run is not None and self.cores_per_run < nodes:
            yield messages.IDLE_NODES.fault("cores_per_run", given=self.cores_per_run, nodes=nodes)

    def _faults_with_own_parsl(self) -> Iterator[Fault]:
        for key in ("partition", "account", "walltime", "setup", "options"):
            if getattr(self, key):
                yield messages.BESIDE_PARSL.fault(key)
        if self.nodes_per_run > 1:
            yield messages.BESIDE_PARSL.fault("nodes_per_run")

    def _faults_of_jobs(self) -> Iterator[Fault]:
        yield from self._faults_of_nodes(self.nodes_per_run)
        for key in ("partition", "account", "parallel_environment"):
            name = getattr(self, key)
            if name is not None and not _NAME.fullmatch(name):
                yield messages.NO_NAME.fault(key, given=name)
        if self.walltime is None:
            if self.scheduler != "local":
                yield messages.NO_WALLTIME.fault("walltime")
        elif not _SHORTEST <= self.walltime <= _LONGEST:
            yield messages.WALLTIME.fault("walltime", given=duration(self.walltime))
        for line in self.setup:
            if not line.strip() or not line.isprintable():
                yield messages.NOT_ONE_LINE.fault("setup", given=line)
        if self.scheduler != "local":
            for option in self.options:
                yield from self._faults_of_option(option)

    def _faults_of_option(self, option: str) -> Iterator[Fault]:
        known = SCHEDULERS[self.scheduler]
        if known.form.fullmatch(option) is None or not option.isprintable():
            yield messages.NO_DIRECTIVE.fault("options", given=option, example=known.example)
        elif key := known.key_of(option):
            yield messages.HAS_A_KEY.fault("options", given=option, key=key)
        elif known.decides(option):
            yield messages.DECIDED.fault("options", given=option)
