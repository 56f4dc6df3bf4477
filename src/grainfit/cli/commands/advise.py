"""The command that says which test to do next."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from grainfit.cli import console as show
from grainfit.cli.advice_options import (
    Accuracies,
    MaxTime,
    Seeds,
    Tests,
    Yes,
    comparing,
    read_seconds,
)
from grainfit.cli.consoles import out
from grainfit.cli.options import Workers, WorkFolder, workdir_option

_KEPT = ("Where further runs are kept.", "the work folder of the calibration")


def advise(
    folder: WorkFolder,
    tests: Tests = None,
    accuracies: Accuracies = None,
    seeds: Seeds = None,
    max_time: MaxTime = None,
    workers: Workers = None,
    workdir: Annotated[Path | None, workdir_option(*_KEPT)] = None,
    yes: Yes = False,
) -> None:
    """Say which test to do next: what it would leave of the open parameters.

    Simulates every bulk test that the calibration does not have at a few parameter sets that agree
    with the measurements, and compares how much its responses differ between them with how much
    they scatter and how well a laboratory measures them. The runs and the time are said first.

    Finished runs are kept: stop it with Ctrl-C, and the same command continues.

    Example:  grainfit advise beads.grainfit --max-time 10min
    """
    from grainfit.calibration_file.accuracies import read_settings
    from grainfit.opened import open_calibration

    with comparing(ask=not yes and max_time is None) as report:
        found = open_calibration(folder).advise(
            tests=tests or (),
            accuracies=read_settings(accuracies or []),
            seeds=seeds,
            max_seconds=read_seconds(max_time),
            workers=workers,
            workdir=workdir,
            **report,
        )
    show.print_parts(out, found.summary())
