"""Call a function of the user, with a time limit, and report its errors by its own lines."""

from __future__ import annotations

import errno
import inspect
import threading
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grainfit.bulk_tests.own_scene import messages
from grainfit.errors import RunFailedError, error_in_words
from grainfit.options.python_file import PythonFile

#: Longest time of a call, s.
LIMIT = 600.0
_TAIL_LINES = 20
#: Folder of grainfit.
_PACKAGE = str(Path(__file__).parents[2])
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.ENOMEM)


def call(function: PythonFile, possible: Mapping[str, Any], limit: float = LIMIT) -> Any:
    """Call a function with those of the possible arguments that it names.

    Parameters
    ----------
    function : PythonFile
        The function; its file is executed before the first call.
    possible : mapping of str to object
        Arguments by name.
    limit : float
        Time after which the call counts as failed, s. The function cannot be stopped: it goes on
        in the background until the program ends.

    Raises
    ------
    RunFailedError
        The function raised an exception, takes other arguments, or did not return in time. The
        reason names its file and line.
    MemoryError, OSError
        The machine has no memory or no disk left.
    """
    outcome: list[Any] = []
    raised: list[BaseException] = []

    def run() -> None:
        try:
            outcome.append(_called(function, possible))
        # A function that calls sys.exit must not end the whole calibration.
        except BaseException as error:
            raised.append(error)

    thread = threading.Thread(target=run, name=function.function, daemon=True)
    thread.start()
    thread.join(limit)
    if raised:
        raise _failure(function, raised[0]) from raised[0]
    if not outcome:
        raise RunFailedError(
            messages.DID_NOT_RETURN(function=name_of(function), limit=limit), "", "timeout"
        )
    return outcome[0]


def _called(function: PythonFile, possible: Mapping[str, Any]) -> Any:
    loaded = function.load()
    if not callable(loaded):
        raise RunFailedError(messages.NO_FUNCTION(function=name_of(function)), kind="evaluation")
    parameters = inspect.signature(loaded).parameters.values()
    if any(p.kind is inspect.Parameter.VAR_KEYWORD for p in parameters):
        return loaded(**possible)
    unknown = [
        p.name
        for p in parameters
        if p.name not in possible
        and p.default is inspect.Parameter.empty
        and p.kind is not inspect.Parameter.VAR_POSITIONAL
    ]
    if unknown:
        raise RunFailedError(
            messages.UNKNOWN_ARGUMENTS(
                function=name_of(function), unknown=", ".join(unknown), possible=", ".join(possible)
            ),
            kind="evaluation",
        )
    return loaded(**{p.name: possible[p.name] for p in parameters if p.name in possible})


def name_of(function: PythonFile) -> str:
    """Return the name of a function and of its file, for readers."""
    return f"{function.function}() in {function.path.name}"


def _failure(function: PythonFile, error: BaseException) -> BaseException:
    """Return the exception to raise instead of the user's, with the line where it happened."""
    if isinstance(error, MemoryError) or getattr(error, "errno", None) in _FULL:
        return error
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not frame.filename.startswith(_PACKAGE)]
    own = [frame for frame in own if not frame.filename.startswith("<frozen")]
    own = own[next((i for i, f in enumerate(own) if f.filename == str(function.path)), len(own)) :]
    if not own and isinstance(error, RunFailedError):
        return error
    words = error_in_words(error)
    tail = "".join(traceback.format_list(own)).splitlines()[-_TAIL_LINES:]
    kind = error.kind if isinstance(error, RunFailedError) else "evaluation"
    if isinstance(error, SyntaxError):
        words = f"line {error.lineno}: {words}"
    where = next((f for f in reversed(own) if f.filename == str(function.path)), None)
    place = f"{function.path.name}, line {where.lineno}" if where else function.path.name
    return RunFailedError(f"{place}: {words}", "\n".join([*tail, words]), kind)
