"""The command that says which tests to measure."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.advice_options import (
    Accuracies,
    MaxTime,
    Seeds,
    Simulate,
    Tests,
    Yes,
    comparing,
    read_seconds,
)
from grainfit.cli.consoles import out
from grainfit.cli.options import Workers, workdir_option
from grainfit.errors import InputError

_PlanPath = Annotated[
    Path,
    typer.Argument(
        metavar="FILE",
        help="Calibration file (TOML); measured values may be missing.",
        show_default=False,
    ),
]
_Wanted = Annotated[
    str,
    typer.Option(metavar="SHARE", help="Wanted half of the 95 % interval of every free parameter."),
]


def design(
    file: _PlanPath,
    wanted: _Wanted = "20%",
    tests: Tests = None,
    accuracies: Accuracies = None,
    simulate: Simulate = False,
    seeds: Seeds = None,
    max_time: MaxTime = None,
    workers: Workers = None,
    workdir: Annotated[Path | None, workdir_option("Where runs are kept.")] = None,
    yes: Yes = False,
) -> None:
    """Say which tests to measure, before the laboratory: which would settle the free parameters.

    Ranks combinations of one to three bulk tests by what they leave and what they cost, from
    the atlas, so at once; or, with --simulate, from runs at a few points of the
    intervals. Tests of the file are taken with the accuracies that it gives, such as
    targets.angle_of_repose = { uncertainty = "0.5 deg" }, all others with the usual ones.

    Example:  grainfit design plan.toml --wanted 30%
    """
    from grainfit.calibration_file.accuracies import read_settings
    from grainfit.work_folder.design import design as plan

    with comparing(ask=not yes and max_time is None) as report:
        found = plan(
            file,
            wanted=_share(wanted),
            tests=tests or (),
            accuracies=read_settings(accuracies or []),
            simulate=simulate,
            seeds=seeds,
            max_seconds=read_seconds(max_time),
            workers=workers,
            workdir=workdir,
            **report,
        )
    show.print_parts(out, found.summary())


def _share(text: str) -> float:
    """Read a share such as ``20%``."""
    from grainfit.units import percentage

    share = percentage(text)
    if share is None or not share > 0:
        raise InputError(messages.NO_SHARE.fault("wanted", given=text))
    return share
