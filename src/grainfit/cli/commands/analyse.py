"""The command that analyses runs that exist."""

from __future__ import annotations

from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.consoles import err_remarks, out
from grainfit.cli.options import CalibrationPath


def analyse(
    file: CalibrationPath,
    runs: Annotated[
        list[str],
        typer.Option(
            "--runs",
            metavar="TABLE",
            help="Runs: a CSV file with a column for each free parameter and each target, with "
            "several tests as TEST=TABLE; or a work folder. Repeat as needed.",
            show_default=False,
        ),
    ],
) -> None:
    """Show what existing runs say, without any simulation.

    Which parameter sets agree with the measurements, how well each parameter
    is determined, and on which parameters the responses depend.

    Example:  grainfit analyse beads.toml --runs runs.csv
    """
    with err_remarks.status("analysis"):
        from grainfit.calibration_file.build import load_calibration
        from grainfit.work_folder.analyse_runs import analyse_runs

        found = analyse_runs(load_calibration(file), runs)
    show.print_parts(out, found.summary())
