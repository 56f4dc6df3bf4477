"""One thread of linear algebra: metamodels are small, and more threads wait for each other."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module

from threadpoolctl import threadpool_limits


class _Here(threading.local):
    """What is in force in the thread of Python that asks."""

    is_limited = False


_here = _Here()


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit linear algebra to one thread; a block within another one costs nothing.

    Setting a limit takes 2 ms, because all libraries of the process are looked through, and a
    report has 40 blocks.
    """
    if _here.is_limited:
        yield
        return
    # Only libraries that are loaded are limited: NumPy has one, and SciPy its own.
    import_module("scipy.linalg")
    with threadpool_limits(limits=1, user_api="blas"):
        _here.is_limited = True
        try:
            yield
        finally:
            _here.is_limited = False
