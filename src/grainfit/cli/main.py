"""Run the command line: every error that grainfit knows ends in one clear message."""

from __future__ import annotations

import faulthandler
import gc
import os
import sys
from contextlib import suppress
from typing import Any

import typer

from grainfit.cli import messages
from grainfit.cli.app import app
from grainfit.cli.console import print_error
from grainfit.cli.consoles import err
from grainfit.cli.documents import error_document, json_is_wanted, print_document
from grainfit.cli.encoding import lose_no_output
from grainfit.cli.exit_codes import BAD_INPUT, INTERRUPTED
from grainfit.cli.interruption import interruption
from grainfit.errors import GrainfitError

#: Base of what Typer raises for an unknown command, option or value.
_WRONG_USAGE: Any = typer.BadParameter.__base__


def main() -> None:
    """Run the command line and exit with its code."""
    interruption.listen()
    lose_no_output()
    # A user's function that crashes Python itself would otherwise end it without a word; a window
    # without a terminal has no stream to write to.
    with suppress(AttributeError, OSError, RuntimeError, ValueError):
        faulthandler.enable(all_threads=False)
    code = _with_json() if json_is_wanted() else _with_text()
    # A reader may be gone, such as a pager; the exit code is not.
    with suppress(OSError):
        sys.stdout.flush()
        sys.stderr.flush()
    interruption.exit_at_once(code)
    if code == INTERRUPTED:
        # A user's function that still runs in a thread would delay the exit of Python.
        os._exit(code)
    # At its end, Python would look through all modules for cycles.
    gc.freeze()
    # ``python -m`` exits as if killed by SIGINT if the last code executed from a text, such as that
    # of a data class, was interrupted, even if the interrupt was handled.
    exec("")
    sys.exit(code)


def _with_text() -> int:
    """Run the command line; print an error as text."""
    try:
        app()
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else 0
    except (GrainfitError, MemoryError) as error:
        print_error(err, _known(error))
        return BAD_INPUT
    except KeyboardInterrupt:
        err.print(messages.INTERRUPTED())
        return INTERRUPTED
    return 0


def _with_json() -> int:
    """Run the command line; print an error as a document."""
    try:
        return int(app(standalone_mode=False) or 0)
    except _WRONG_USAGE as raised:
        error, text, code = raised, raised.format_message(), int(raised.exit_code)
    except (GrainfitError, MemoryError) as raised:
        error = _known(raised)
        text, code = str(error), BAD_INPUT
    except (KeyboardInterrupt, typer.Abort) as raised:
        error, text, code = raised, messages.INTERRUPTED(), INTERRUPTED
    print_document("error", error_document(error, text, code))
    return code


def _known(error: GrainfitError | MemoryError) -> GrainfitError:
    if isinstance(error, GrainfitError):
        return error
    reason = " ".join(str(error).split())
    why = f": {reason[:1].lower()}{reason[1:]}" if reason else ""
    return GrainfitError(messages.NO_MEMORY(why=why))
