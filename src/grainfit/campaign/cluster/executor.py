"""Execute DEM runs on a cluster: an executor whose workers are in the jobs of its scheduler.

Parsl submits the jobs and sends the runs to them. It is imported only when it is used.
"""

from __future__ import annotations

import importlib.util
import re
import shutil
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path

from grainfit.campaign import messages
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.campaign.cluster.schedulers import SCHEDULERS
from grainfit.errors import GrainfitError
from grainfit.extras import how_to_install
from grainfit.formatting import counted

#: The path of the work folder is part of the job script, which a shell reads.
_SAFE_PATH = re.compile(r"[A-Za-z0-9_./+@,:=-]+")


def is_available(options: ClusterOptions) -> bool:
    """Return True if jobs can be submitted here; assumed for a custom Parsl configuration."""
    return (
        options.parsl is not None or shutil.which(SCHEDULERS[options.scheduler].command) is not None
    )


def describe_cluster(options: ClusterOptions) -> list[str]:
    """Describe the jobs that would be submitted, in a few lines."""
    workers = f"Cluster: {counted(options.workers, 'run')} at a time"
    if options.parsl is not None:
        return [f"{workers} by your own Parsl configuration."]
    if options.scheduler == "local":
        return [f"Cluster: {messages.RUNS_HERE()}"]
    assert options.walltime is not None, "options without it are refused"
    nodes = "one node" if options.nodes_per_run == 1 else f"{options.nodes_per_run} nodes"
    lines = [
        f"{workers} in up to {counted(options.jobs, 'job')} of {options.scheduler}, each with "
        f"{counted(options.runs_per_job, 'run')} on {counted(options.cores, 'core')} of {nodes} "
        "for at most "
        f"{options.walltime // 60:.0f} min; partition {options.partition or '(default)'}, account "
        f"{options.account or '(default)'}{''.join(f', {option}' for option in options.options)}."
    ]
    return lines if is_available(options) else [*lines, f"  {missing_scheduler(options)}"]


def executed_by(options: ClusterOptions) -> list[str]:
    """List the user's code that is executed for the jobs, here and in them."""
    if options.parsl is not None:
        return [f"Parsl configuration {options.parsl}, on this machine"]
    return [f"by the shell of every job: {line}" for line in options.setup]


def missing_scheduler(options: ClusterOptions) -> str:
    """Return the message that this machine has no scheduler, and the consequence."""
    if options.scheduler == "local":
        return messages.RUNS_HERE()
    command = SCHEDULERS[options.scheduler].command
    return messages.NO_SCHEDULER(command=command)


@contextmanager
def cluster_executor(options: ClusterOptions, folder: Path) -> Iterator[Executor]:
    """Open an executor that runs tasks in jobs of a cluster, and end all jobs on exit.

    Jobs are submitted when there are runs for them. When a job is lost, its run fails with an error
    of Parsl, and another job is submitted. When no job starts at all, every run fails with a
    `GrainfitError` that gives the reason.

    Parameters
    ----------
    options : ClusterOptions
        The jobs.
    folder : Path
        The work folder, on a file system that the nodes share; scripts and logs of the jobs go to
        ``parsl`` in it.

    Raises
    ------
    GrainfitError
        Parsl is not installed, or the folder or the custom configuration cannot be used.
    """
    folder = folder.absolute()
    if not _SAFE_PATH.fullmatch(str(folder)):
        raise GrainfitError(messages.PATH_FOR_SCRIPTS(folder=str(folder)))
    if importlib.util.find_spec("parsl") is None:
        raise GrainfitError(messages.NO_PARSL(install=how_to_install("parsl")))
    from grainfit.campaign.cluster.parsl_executor import jobs_of

    with jobs_of(options, folder / "parsl") as executor:
        yield executor
