"""Faults of the infrastructure that makes runs, told from faults of the runs themselves."""

from __future__ import annotations

from concurrent.futures import BrokenExecutor

#: By the library and the name of the class: none of them needs to be installed.
_LOST = {
    ("parsl", "ManagerLost"),
    ("parsl", "WorkerLost"),
    ("distributed", "KilledWorker"),
}


def is_lost_worker(error: BaseException) -> bool:
    """Whether a run gave no result because its worker, its job or its node is gone.

    Parameters
    ----------
    error : BaseException
        As the future of a run gives it.
    """
    return isinstance(error, BrokenExecutor) or any(
        (kind.__module__.partition(".")[0], kind.__name__) in _LOST for kind in type(error).__mro__
    )
