"""Progress of a command that simulates a batch of runs outside a calibration."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import typer

from grainfit.cli import messages
from grainfit.cli.consoles import err as _err
from grainfit.cli.consoles import err_remarks as _remarks
from grainfit.cli.exit_codes import INTERRUPTED

if TYPE_CHECKING:
    from grainfit.campaign.batch import ExpectedWork


@contextmanager
def simulating(
    first: str = "simulating", unit: str = "", *, ask: bool = False
) -> Iterator[dict[str, Any]]:
    """Yield callbacks that show the progress of a batch of runs; Ctrl-C ends the command.

    Parameters
    ----------
    first : str
        Words shown before the work is known.
    unit : str
        Noun of the parts of the work that are counted.
    ask : bool
        Ask before simulating, on a terminal.
    """
    status = _remarks.status(first)

    def begin(work: ExpectedWork) -> None:
        status.stop()
        _remarks.print(f"{work}.", highlight=False)
        if ask and work.runs and sys.stdin.isatty():
            typer.confirm("Simulate?", default=True, abort=True, err=True)
        status.update("simulating")
        status.start()

    def show(done: int, count: int) -> None:
        status.update(f"simulating: {done} of {count} {unit}".rstrip())

    try:
        with status:
            yield {"on_start": begin, "on_progress": show}
    except KeyboardInterrupt:
        # Typer would end it without a word.
        _err.print(messages.STOPPED())
        raise typer.Exit(INTERRUPTED) from None
