"""The command that says which test to do next."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from grainfit.cli import console as show
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
from grainfit.cli.options import Workers, WorkFolder, workdir_option

_KEPT = ("Where further runs are kept.", "the work folder of the calibration")


def advise(
    folder: WorkFolder,
    tests: Tests = None,
    accuracies: Accuracies = None,
    simulate: Simulate = False,
    seeds: Seeds = None,
    max_time: MaxTime = None,
    workers: Workers = None,
    workdir: Annotated[Path | None, workdir_option(*_KEPT)] = None,
    yes: Yes = False,
) -> None:
    """Say which test to do next: what it would leave of the open parameters.

    Compares how much the responses of every other bulk test differ between the parameter sets that
    agree with the measurements, how much they scatter, and how well a laboratory measures them: by
    the atlas, at once; or, with --simulate, by runs at a few of these sets, whose number and time
    are said first. Finished runs are kept: stop it with Ctrl-C, and the same command continues.

    Example:  grainfit advise beads.grainfit
    """
    from grainfit.calibration_file.accuracies import read_settings
    from grainfit.opened import open_calibration

    with comparing(ask=not yes and max_time is None) as report:
        found = open_calibration(folder).advise(
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
