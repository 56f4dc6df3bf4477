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

from grainfit import platforms
from grainfit.bulk_tests.own_scene import messages
from grainfit.bulk_tests.own_scene.user_function import call, name_of
from grainfit.errors import RunFailedError
from grainfit.options.python_file import PythonFile

#: Longest time of a trial, s: `check` waits for it.
LIMIT = 60.0
#: Failures by function and source, None for those that return.
_outcomes: dict[tuple[str, bytes], RunFailedError | None] = {}


def require_return(function: PythonFile, possible: Mapping[str, Any], limit: float = LIMIT) -> None:
    """Call a function in a child process, the first time that this process needs it.

    Its errors are left to the call that follows; only the end of Python and a loop without end are
    found here, and remembered. A process with several threads tries nothing: its child could wait
    for their locks. Windows, which does not fork, tries nothing either.

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
    if threading.active_count() > 1 or not platforms.HAS_FORK:
        return
    key = (f"{function.path}:{function.function}", function.source)
    if key not in _outcomes:
        _outcomes[key] = _outcome(function, possible, limit)
    if failure := _outcomes[key]:
        raise failure


def _outcome(
    function: PythonFile, possible: Mapping[str, Any], limit: float
) -> RunFailedError | None:
    """Call a function in a child process; return why it must not be called in this one."""
    context: Any = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)
    child = context.Process(target=_call, args=(function, possible, there), daemon=True)
    child.start()
    there.close()
    if not here.poll(limit):
        child.kill()
        child.join()
        text = messages.NEVER_RETURNS(function=name_of(function), limit=limit)
        return RunFailedError(text, "", "timeout")
    # The end of the pipe without a word is that of the child.
    with suppress(EOFError):
        here.recv()
        child.join()
        return None
    child.join()
    text = messages.ENDS_PYTHON(function=name_of(function), how=_how(child.exitcode or 0))
    return RunFailedError(text, kind="evaluation")


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
