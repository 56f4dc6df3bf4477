"""Schedulers that accept a job, and then do not say what has become of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from grainfit.campaign import messages
from grainfit.campaign.cluster import followed, parsl_executor
from grainfit.campaign.cluster import slurm as slurm_jobs
from grainfit.campaign.cluster.executor import cluster_executor
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.errors import ExecutorError

pytest.importorskip("parsl")

#: Of every scheduler: how it accepts a job, and its command that lists the jobs.
COMMANDS = {
    "slurm": ("sbatch", "Submitted batch job 7", "squeue"),
    "pbs": ("qsub", "7.server", "qstat"),
    "sge": ("qsub", "Your job 7 (grainfit) has been submitted", "qstat"),
    "lsf": ("bsub", "Job <7> is submitted to queue <normal>.", "bjobs"),
}


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(followed, "_STATUS_SECONDS", 1)
    monkeypatch.setattr(parsl_executor, "_LOOK_SECONDS", 1)
    monkeypatch.setattr(slurm_jobs, "_FAILED_START_SECONDS", 2.0)


def write(folder: Path, name: str, *lines: str) -> None:
    (folder / name).write_text("\n".join(["#!/bin/sh", *lines, ""]))
    (folder / name).chmod(0o755)


@pytest.mark.parametrize(
    ("scheduler", "is_there"), [*((name, True) for name in COMMANDS), ("slurm", False)]
)
def test_a_scheduler_that_does_not_list_its_jobs_is_given_up(
    scheduler: str, is_there: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    submit, accepted, listing = COMMANDS[scheduler]
    write(tmp_path, submit, f"echo '{accepted}'")
    for command in ("scancel", "qdel", "bkill"):
        write(tmp_path, command)
    if is_there:
        write(tmp_path, listing, "echo 'no controller' >&2", "exit 1")
    monkeypatch.setenv("PATH", str(tmp_path))  # no scheduler of this machine
    options = ClusterOptions(scheduler, walltime=600.0)

    with cluster_executor(options, tmp_path / "work") as executor:
        error = executor.submit(divmod, 7, 3).exception(60)

    assert isinstance(error, ExecutorError)
    assert messages.NO_JOB_STARTS.is_in(str(error))
    if is_there:
        assert messages.NO_LIST.is_in(str(error), reason="no controller")
    else:
        assert messages.NO_COMMAND.is_in(str(error), command=listing)
