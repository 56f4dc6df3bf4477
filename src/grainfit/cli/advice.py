"""The commands that say which test to do next, and which tests to do at all."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.consoles import out as _out
from grainfit.cli.help_texts import WORK_FOLDER, shown_default
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
Workers = Annotated[int | None, typer.Option(metavar="N", min=1, help="Runs at a time.")]
Yes = Annotated[bool, typer.Option("--yes", "-y", help="Do not ask before simulating.")]

_comparing = partial(simulating, "reading the runs", "parameter sets")


def advise(
    folder: Annotated[
        Path,
        typer.Argument(metavar="DIR", help="Work folder of a calibration.", show_default=False),
    ],
    tests: Tests = None,
    accuracies: Accuracies = None,
    seeds: Seeds = None,
    max_time: MaxTime = None,
    workers: Workers = None,
    workdir: Annotated[
        Path | None,
        typer.Option(
            "--workdir",
            metavar="DIR",
            help="Where further runs are kept. "
            f"{shown_default('the work folder of the calibration')}",
            show_default=False,
        ),
    ] = None,
    yes: Yes = False,
) -> None:
    """Say which test to do next: what it would leave of the open parameters.

    Simulates every bulk test that the calibration does not have at a few parameter sets that agree
    with the measurements, and compares how much its responses differ between them with how much
    they scatter and how well a laboratory measures them. The runs and the time are said first.

    Finished runs are kept: stop it with Ctrl-C, and the same command continues.

    [bold]Example:[/bold]  grainfit advise beads.grainfit --max-time 10min
    """
    from grainfit.calibration_file.accuracies import read_settings
    from grainfit.opened import open_calibration

    with _comparing(ask=not yes and max_time is None) as report:
        found = open_calibration(folder).advise(
            tests=tests or (),
            accuracies=read_settings(accuracies or []),
            seeds=seeds,
            max_seconds=_seconds(max_time),
            workers=workers,
            workdir=workdir,
            **report,
        )
    show.print_parts(_out, found.summary())


def design(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Calibration file (TOML); measured values may be missing.",
            show_default=False,
        ),
    ],
    wanted: Annotated[
        str,
        typer.Option(
            metavar="SHARE", help="Wanted half of the 95 % interval of every free parameter."
        ),
    ] = "20%",
    tests: Tests = None,
    accuracies: Accuracies = None,
    simulate: Annotated[
        bool,
        typer.Option(
            "--simulate", help="Simulate the tests at a few points of the intervals first."
        ),
    ] = False,
    seeds: Seeds = None,
    max_time: MaxTime = None,
    workers: Workers = None,
    workdir: Annotated[
        Path | None,
        typer.Option(
            "--workdir",
            metavar="DIR",
            help=f"Where runs are kept. {shown_default(WORK_FOLDER)}",
        ),
    ] = None,
    yes: Yes = False,
) -> None:
    """Say which tests to measure, before the laboratory: which would settle the free parameters.

    Ranks combinations of one to three bulk tests by what they leave and what they cost, from
    recorded sensitivities, so at once; or, with --simulate, from runs at a few points of the
    intervals. Tests of the file are taken with the accuracies that it gives, such as
    targets.angle_of_repose = { uncertainty = "0.5 deg" }, all others with the usual ones.

    [bold]Example:[/bold]  grainfit design plan.toml --wanted 30%
    """
    from grainfit.calibration_file.accuracies import read_settings
    from grainfit.work_folder.design import design as plan

    with _comparing(ask=not yes and max_time is None) as report:
        found = plan(
            file,
            wanted=_share(wanted),
            tests=tests or (),
            accuracies=read_settings(accuracies or []),
            simulate=simulate,
            seeds=seeds,
            max_seconds=_seconds(max_time),
            workers=workers,
            workdir=workdir,
            **report,
        )
    show.print_parts(_out, found.summary())


def _seconds(text: str | None) -> float | None:
    """Read a time such as ``10min``; a bare number is in seconds."""
    from grainfit.units import UnitError, to_unit

    if text is None:
        return None
    try:
        seconds = to_unit(text, "s")
    except UnitError as error:
        raise InputError(Fault("max-time", error.message, error.remedy)) from None
    if not seconds > 0:
        raise InputError(Fault("max-time", f"is {text!r}.", "Give a time above 0, as 10min."))
    return seconds


def _share(text: str) -> float:
    """Read a share such as ``20%``."""
    from grainfit.units import percentage

    share = percentage(text)
    if share is None or not share > 0:
        raise InputError(Fault("wanted", f"is {text!r}.", "Give a percentage above 0, as 20%."))
    return share
