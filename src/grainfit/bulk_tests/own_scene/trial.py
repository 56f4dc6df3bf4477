"""Try a function of the user in a child process: what ends Python, or never returns, ends there."""

from __future__ import annotations

import faulthandler
import multiprocessing
import os
import signal
import threading
from collections.abc import Mapping
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

from grainfit.bulk_tests.own_scene import messages
from grainfit.bulk_tests.own_scene.user_function import call
from grainfit.errors import RunFailedError
from grainfit.options.python_file import PythonFile

#: Longest time of a trial, s: `check` waits for it.
LIMIT = 60.0
_tried: set[tuple[str, bytes]] = set()


def require_return(function: PythonFile, possible: Mapping[str, Any], limit: float = LIMIT) -> None:
    """Call a function in a child process, the first time that this process needs it.

    Its errors are left to the call that follows; only the end of Python and a loop without end are
    found here. A process with several threads tries nothing: its child could wait for their locks.

    Parameters
    ----------
    function : PythonFile
        The function.
    possible : mapping of str to object
        Arguments by name.
    limit : float
        Longest time, s.

    Raises
    ------
    RunFailedError
        The function ended Python, crashed it, or did not return in time.
    """
    key = (f"{function.path}:{function.function}", function.source)
    if key in _tried or threading.active_count() > 1:
        return
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)
    child = context.Process(target=_call, args=(function, possible, there), daemon=True)
    child.start()
    there.close()
    ended = here.poll(limit)
    with suppress(EOFError):
        if ended and here.recv():
            child.join()
            _tried.add(key)
            return
    if not ended:
        child.kill()
    child.join()
    name = f"{function.function}() in {function.path.name}"
    if not ended:
        raise RunFailedError(messages.NEVER_RETURNS(function=name, limit=limit), "", "timeout")
    how = _how(child.exitcode or 0)
    raise RunFailedError(messages.ENDS_PYTHON(function=name, how=how), kind="evaluation")


def _call(function: PythonFile, possible: Mapping[str, Any], returned: Connection) -> None:
    faulthandler.disable()
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    with suppress(BaseException):
        call(function, possible)
    returned.send(True)
    os._exit(0)


def _how(exit_code: int) -> str:
    if exit_code < 0:
        with suppress(ValueError):
            return f"signal {signal.Signals(-exit_code).name}"
    return f"exit code {exit_code}"
