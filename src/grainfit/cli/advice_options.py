"""Options of the commands that compare tests: advise and design."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Annotated, Any

import typer

from grainfit.cli import messages
from grainfit.cli.help_texts import shown_default
from grainfit.cli.simulating import simulating
from grainfit.errors import Fault, InputError

Tests = Annotated[
    list[str] | None,
    typer.Option(
        "--test",
        metavar="NAME",
        help=f"Test to compare. Repeat as needed. {shown_default('all bulk tests')}",
        show_default=False,
    ),
]
Accuracies = Annotated[
    list[str] | None,
    typer.Option(
        "--accuracy",
        metavar="RESPONSE=VALUE",
        help="How well you measure a response, instead of the usual accuracy: "
        "angle_of_repose='0.5 deg' or draw_down.mass_flow=3%. Repeat as needed.",
    ),
]
Simulate = Annotated[
    bool,
    typer.Option("--simulate", help="Simulate the tests at a few parameter sets first."),
]
MaxTime = Annotated[
    str | None,
    typer.Option(
        "--max-time", metavar="TIME", help="Stop simulating after this time, such as 10min."
    ),
]
Seeds = Annotated[
    int | None,
    typer.Option(metavar="N", min=1, help=f"Runs of each parameter set. {shown_default('2')}"),
]
Yes = Annotated[bool, typer.Option("--yes", "-y", help="Do not ask before simulating.")]

#: Options that are called otherwise than the argument of Python.
_OPTIONS = {"max_seconds": "max-time"}


@contextmanager
def comparing(*, ask: bool) -> Iterator[dict[str, Any]]:
    """Yield callbacks that show the progress of simulated trials, see `simulating`.

    Raises
    ------
    InputError
        Of what is compared, by the names of the options.
    """
    try:
        with simulating("reading the runs", "parameter sets", ask=ask) as report:
            yield report
    except InputError as error:
        faults = [replace(one, key=_OPTIONS.get(one.key, one.key)) for one in error.faults]
        raise InputError(faults, error.source) from None


def read_seconds(text: str | None) -> float | None:
    """Return the seconds of a time such as ``10min``; a bare number is in seconds."""
    from grainfit.units import UnitError, to_unit

    if text is None:
        return None
    try:
        seconds = to_unit(text, "s")
    except UnitError as error:
        raise InputError(Fault("max-time", error.message, error.remedy)) from None
    if not seconds > 0:
        raise InputError(messages.NO_TIME.fault("max-time", given=text))
    return seconds
