"""Tell a command of the user's how a run of the command line has ended."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grainfit import platforms
from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.consoles import err
from grainfit.formatting import plain

if TYPE_CHECKING:
    from grainfit.result import Result

#: Longest time of the command, s.
LONGEST_SECONDS = 60.0

Notify = Annotated[
    str | None,
    typer.Option(
        "--notify",
        metavar="COMMAND",
        help="Shell command to execute at the end, whatever it is; GRAINFIT_STATUS, "
        "GRAINFIT_HEADLINE, GRAINFIT_WORKDIR, GRAINFIT_RESULT and GRAINFIT_REPORT tell it.",
    ),
]


@dataclass
class Ending:
    """End of a run.

    Parameters
    ----------
    result : Result, optional
        Its result; None until it has one.
    """

    result: Result | None = None


@contextmanager
def notifying(command: str | None, folder: Path) -> Iterator[Ending]:
    """Execute a command at the end of the block, also when it fails or is interrupted.

    What the command does has no influence on the end: a fault of it is a warning.

    Parameters
    ----------
    command : str, optional
        For the shell; None does nothing.
    folder : Path
        The work folder.
    """
    ending = Ending()
    error: BaseException | None = None
    try:
        yield ending
    except BaseException as raised:
        error = raised
        raise
    finally:
        if command is not None:
            _notify(command, _variables(folder, ending.result, error))


def _variables(folder: Path, result: Result | None, error: BaseException | None) -> dict[str, str]:
    """Return the environment variables that tell how a run has ended."""
    status, headline = "failed", " ".join(str(error).split())
    if isinstance(error, KeyboardInterrupt):
        status, headline = "interrupted", "interrupted"
    if result is not None:
        status, headline = result.status, result.headline

    def path(name: str) -> str:
        # Without a result, the files are those of an earlier start.
        found = folder.absolute() / name
        return str(found) if result is not None and found.is_file() else ""

    return {
        "GRAINFIT_STATUS": status,
        "GRAINFIT_HEADLINE": plain(headline),
        "GRAINFIT_WORKDIR": str(folder.absolute()),
        "GRAINFIT_RESULT": path("result.json"),
        "GRAINFIT_REPORT": path("report.html"),
    }


def _notify(command: str, variables: dict[str, str]) -> None:
    try:
        fault = _execute(command, os.environ | variables)
    except KeyboardInterrupt:
        fault = "it was interrupted"
    except (OSError, ValueError) as error:
        fault = str(error)
    if fault:
        with suppress(OSError):
            show.print_warning(err, messages.NOTIFICATION_FAILED(reason=fault))


def _execute(command: str, environment: dict[str, str]) -> str:
    """Execute a command of the shell; return why it failed, or ""."""
    sys.stdout.flush()
    process = subprocess.Popen(
        command,
        shell=True,
        env=environment,
        stdin=subprocess.DEVNULL,
        # All that a shell starts ends with it.
        **platforms.apart(),
    )
    try:
        code = process.wait(LONGEST_SECONDS)
    except subprocess.TimeoutExpired:
        return messages.NOTIFICATION_TOO_LONG(seconds=LONGEST_SECONDS)
    finally:
        if process.returncode is None:
            with suppress(OSError):
                platforms.signal_group(process.pid, platforms.STRONGEST_SIGNAL)
            process.wait()
    return f"exit code {code}" if code else ""
