"""Signals that end a command: Ctrl-C, SIGTERM, and SIGHUP, sent when a terminal is closed."""

from __future__ import annotations

import os
import signal
import stat
import sys
import threading
import time
from types import FrameType
from typing import Any

import typer
from typing_extensions import override

from grainfit import platforms
from grainfit.cli import messages
from grainfit.cli.consoles import err
from grainfit.cli.documents import json_is_wanted
from grainfit.cli.exit_codes import INTERRUPTED
from grainfit.cli.help_texts import GroupWithSummaries
from grainfit.errors import GrainfitError

#: Sent together by a closed terminal or the end of a session; they count as one.
_SENT_BY_OTHERS = platforms.signals("SIGTERM", "SIGHUP")
_TOGETHER_SECONDS = 2.0
_AGAIN_SECONDS = 0.1


class Interruption:
    """The signals that end a command, each of them raised as `KeyboardInterrupt`.

    Signals that are ignored, such as SIGHUP with ``nohup``, and SIGINT in the background, remain
    ignored.

    Attributes
    ----------
    count : int
        Signals so far. A library that is interrupted, for example while it is imported, may raise
        any error: this tells that a signal caused it.
    """

    def __init__(self) -> None:
        self.count = 0
        self._last = float("-inf")

    def listen(self) -> None:
        """Raise `KeyboardInterrupt` for the signals from now on."""
        signal.signal(signal.SIGTERM, self._interrupt)
        for number in platforms.signals("SIGINT", "SIGHUP"):
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._interrupt)
        sys.unraisablehook = self._interrupt_again

    def exit_at_once(self, code: int) -> None:
        """Let signals end the process silently from now on: the command has ended."""

        def leave(_number: int, _frame: FrameType | None) -> None:
            os._exit(code)

        for number in (signal.SIGINT, *_SENT_BY_OTHERS):
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, leave)

    def _interrupt(self, number: int, _frame: FrameType | None) -> None:
        if number in platforms.signals("SIGHUP"):
            _leave_terminal()
        now = time.monotonic()
        if number in _SENT_BY_OTHERS and now - self._last < _TOGETHER_SECONDS:
            return
        self._last = now
        self.count += 1
        raise KeyboardInterrupt

    def _interrupt_again(self, ignored: Any) -> None:
        """Repeat an interrupt that came where Python cannot raise it, such as in a destructor."""
        if issubclass(ignored.exc_type, KeyboardInterrupt):
            self._last = float("-inf")
            again = platforms.send_to_itself
            threading.Timer(_AGAIN_SECONDS, again, (signal.SIGTERM,)).start()
        else:
            sys.__unraisablehook__(ignored)


def _leave_terminal() -> None:
    """Discard output to a terminal, which is an error after the terminal is closed."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (1, 2):
        # os.isatty is False for a terminal that is closed.
        if stat.S_ISCHR(os.fstat(stream).st_mode):
            os.dup2(nowhere, stream)
    os.close(nowhere)


#: The signals of this process.
interruption = Interruption()


class InterruptibleCommands(GroupWithSummaries):
    """All commands: an interrupted one ends with one line."""

    @override
    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except (typer.Exit, GrainfitError):
            raise
        except typer.Abort:
            if json_is_wanted():
                raise
            # A prompt that was left, also by the end of the input: the cursor is on its line.
            err.print()
            err.print(messages.INTERRUPTED())
            raise typer.Exit(INTERRUPTED) from None
        except (Exception, KeyboardInterrupt) as error:
            if not (isinstance(error, KeyboardInterrupt) or interruption.count):
                raise
            interruption.exit_at_once(INTERRUPTED)
            is_run = ctx.invoked_subcommand == "run"
            err.print(messages.STOPPED() if is_run else messages.INTERRUPTED())
            raise typer.Exit(INTERRUPTED) from None
