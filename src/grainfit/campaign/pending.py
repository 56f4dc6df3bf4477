"""Runs that have not ended, and the jobs of a cluster in which they execute: plain data."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

#: States of jobs that have not ended.
ALIVE = ("running", "pending", "held", "unknown")
PendingState = Literal["submitted", "postponed", "elsewhere"]


@dataclass(frozen=True)
class PendingRun:
    """A run that has not ended.

    Parameters
    ----------
    identity, test : str
        Identity of the run and name of its test.
    state : {"submitted", "postponed", "elsewhere"}
        Submitted to a worker, which may be busy; waiting for another try after a fault of the
        machine; or executed by another process that shares the store.
    submitted : float
        Time of its last submission, seconds since the epoch; 0 elsewhere.
    tries : int
        Number of tries, this one included.
    has_folder : bool
        Whether it works in a folder of its own, which appears when a worker begins with it.
    has_begun : bool
        Whether a worker is known to have begun with it; not for runs in other processes.
    """

    identity: str
    test: str
    state: PendingState
    submitted: float = 0.0
    tries: int = 1
    has_folder: bool = True
    has_begun: bool = False


@dataclass(frozen=True)
class ClusterJob:
    """A job of a cluster.

    Parameters
    ----------
    number : str
        By which the scheduler knows it; empty when it was refused.
    state : str
        ``pending``, ``running``, or how it ended.
    message : str
        Message of the scheduler, such as the reason why the job waits.
    """

    number: str
    state: str
    message: str


def executing(under_way: int, workers: int, jobs: Sequence[ClusterJob]) -> int:
    """Return how many runs execute of those under way: the others wait for a worker.

    Parameters
    ----------
    under_way : int
        Runs that were submitted and have not ended.
    workers : int
        Largest number of runs at a time.
    jobs : sequence of ClusterJob
        Jobs of a cluster; in those that wait in its queue, nothing executes.

    Examples
    --------
    >>> waiting, at_work = ClusterJob("7", "pending", ""), ClusterJob("8", "running", "")
    >>> executing(5, 4, [])
    4
    >>> executing(5, 4, [waiting]), executing(5, 4, [waiting, at_work])
    (0, 2)
    """
    states = [job.state for job in jobs]
    running, alive = states.count("running"), sum(state in ALIVE for state in states)
    # Jobs have the same number of workers.
    return min(under_way, workers * running // alive if alive else workers)


@runtime_checkable
class _HasJobs(Protocol):
    def cluster_jobs(self) -> Sequence[ClusterJob]: ...


def jobs_of(executor: Executor) -> Sequence[ClusterJob]:
    """Return the jobs of an executor; none when it has no cluster."""
    return executor.cluster_jobs() if isinstance(executor, _HasJobs) else ()
