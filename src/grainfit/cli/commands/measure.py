"""The command that measures a finished run again."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.consoles import out


def measure(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="PATH",
            help="A run folder, a dump of particles, a photograph, or a scan (PLY, XYZ, STL).",
        ),
    ],
) -> None:
    """Measure the responses of a finished run again; or a heap in a picture, or in a scan."""
    from grainfit.work_folder.remeasure import absent_from, measure_path

    found = measure_path(path)
    show.print_measurement(out, found)
    show.print_absences(out, absent_from(path, found))
