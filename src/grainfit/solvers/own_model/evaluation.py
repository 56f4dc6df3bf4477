"""Evaluate the folder of a simulation with functions of the user, each in a process of its own."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from json import JSONDecodeError, loads
from pathlib import Path

from grainfit.errors import GrainfitError, RunFailedError
from grainfit.evaluation import Measured
from grainfit.evaluation.exchange import about_missing, read_responses
from grainfit.files import LARGEST_RESPONSES, log_tail, read_within
from grainfit.options.python_file import PythonFile
from grainfit.solvers.base import Workspace
from grainfit.solvers.own_model import measure_folder, messages
from grainfit.solvers.process.process import LOG_NAME, run_process

RESPONSES_NAME = "responses.json"
_NAMED_FILES = 8


def measure_with(
    functions: Iterable[PythonFile],
    model: Path,
    workspace: Workspace,
    seconds: float,
    expected: Sequence[str] | None,
) -> dict[str, Measured]:
    """Return the responses of all functions, but those that differ and are not expected.

    Parameters
    ----------
    functions : iterable of PythonFile
        Functions of the folder of a run.
    model : path
        Folder of the model: the copy of a file in it is used, which is in the folder of the run.
    workspace : Workspace
        Folder of the run, and its time-out, which holds for simulation and evaluation.
    seconds : float
        Wall time of the simulation, s.
    expected : sequence of str, optional
        Responses that the functions must return together; None: any.

    Raises
    ------
    RunFailedError
        A function failed, took too long, or returned no usable responses; an expected response is
        missing, or two functions return different values of it.
    """
    found: dict[str, Measured] = {}
    origins: dict[str, str] = {}
    ambiguous: set[str] = set()
    for number, function in enumerate(functions, 1):
        seconds += _call(function, model, workspace, seconds, evaluation_log(number))
        origin = f"{function.path.name}:{function.function}"
        responses = responses_in(workspace.folder / RESPONSES_NAME, origin, expected)
        for name in responses.keys() & found.keys():
            if responses[name] == found[name]:
                continue
            if expected is None or name in expected:
                reason = messages.TWO_VALUES(first=origins[name], second=origin, name=name)
                raise RunFailedError(reason, kind="evaluation")
            ambiguous.add(name)
        found |= responses
        origins |= dict.fromkeys(responses, origin)
    tail = log_tail(workspace.folder / LOG_NAME)
    require(found, expected, " and ".join(dict.fromkeys(origins.values())), tail)
    return {name: value for name, value in found.items() if name not in ambiguous}


def evaluation_log(number: int) -> str:
    """Return the name of the log of a function by its number, from 1."""
    return "evaluation.log" if number == 1 else f"evaluation_{number}.log"


def _call(
    function: PythonFile, model: Path, workspace: Workspace, seconds: float, log: str
) -> float:
    """Let a function evaluate the folder within the time that is left; return its wall time, s."""
    file = function.path
    if file.is_relative_to(model):
        file = workspace.folder / file.relative_to(model)
    program = [sys.executable, "-P", measure_folder.__file__]
    # A file from the simulation must not be taken for the result of the evaluation.
    (workspace.folder / RESPONSES_NAME).unlink(missing_ok=True)
    left = None
    if workspace.timeout is not None:
        left = max(0.0, workspace.timeout - seconds)
    try:
        return run_process(
            [*program, str(file), function.function, RESPONSES_NAME],
            replace(workspace, timeout=left),
            log_name=log,
        )
    except RunFailedError as error:
        if error.kind in ("cancelled", "machine"):
            raise
        if error.kind == "timeout":
            reason = messages.EVALUATION_TOO_LONG(timeout=workspace.timeout)
            raise RunFailedError(reason, error.log_tail, "timeout") from error
        what = error.log_tail.rstrip().rpartition("\n")[2] or error.reason
        reason = messages.EVALUATION_FAILED(file=file.name, function=function.function, reason=what)
        raise RunFailedError(reason, error.log_tail, "evaluation") from error


def responses_in(
    file: Path, origin: str, expected: Sequence[str] | None, known: Iterable[str] = ()
) -> Mapping[str, Measured]:
    """Read responses from a JSON file in the folder of a run.

    Parameters
    ----------
    file : path
        The file.
    origin : str
        Source of the responses, for messages.
    expected : sequence of str, optional
        Responses that must be usable if they are there; None: all of them.
    known : iterable of str
        Files of the folder that are not named where the file is missing.

    Raises
    ------
    RunFailedError
        The file is missing, cannot be read, or has a response that is not usable.
    """
    tail = log_tail(file.parent / LOG_NAME)
    try:
        # Of bytes it knows the encoding: UTF-8 or UTF-16, with a byte order mark or without.
        found = loads(read_within(file, LARGEST_RESPONSES))
        there = found if isinstance(found, Mapping) else ()
        wanted = None if expected is None else [name for name in expected if name in there]
        return read_responses(found, wanted, origin)
    except FileNotFoundError:
        reason = messages.NOTHING_WRITTEN(file=file.name, left=_left(file.parent, known))
    except OSError as error:
        reason = messages.RESPONSES_UNREADABLE(file=file.name, reason=error.strerror)
    except JSONDecodeError as error:
        reason = messages.CUT_SHORT(file=file.name, reason=error)
    except (ValueError, RecursionError) as error:
        reason = messages.NO_JSON(file=file.name, reason=error)
    except GrainfitError as error:
        reason = str(error)
    raise RunFailedError(reason, tail, "evaluation")


def require(
    found: Mapping[str, Measured], expected: Sequence[str] | None, origin: str, tail: str
) -> None:
    """Raise an error if an expected response is missing.

    Raises
    ------
    RunFailedError
        With the names of those that are missing, and of those that are there.
    """
    if missing := about_missing(found, expected, origin):
        raise RunFailedError(missing, tail, "evaluation")


def _left(folder: Path, known: Iterable[str]) -> str:
    left = sorted({path.name for path in folder.iterdir()}.difference(known))
    more = ", ..." if len(left) > _NAMED_FILES else ""
    return ", ".join(left[:_NAMED_FILES]) + more
