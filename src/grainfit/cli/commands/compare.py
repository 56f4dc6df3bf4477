"""The command that puts calibrations side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.consoles import out

Folders = typer.Argument(metavar="DIR", help="Work folders of calibrations.")


def compare(folders: Annotated[list[Path], Folders]) -> None:
    """Put calibrations side by side: two materials, or one with other tests, solvers or seeds.

    Parameters and responses whose 95 % intervals are apart differ; the others agree. Fixed
    parameters are shown where they are not the same.
    """
    from grainfit.work_folder.comparison import compare as compared
    from grainfit.work_folder.saved_calibration import SavedCalibration

    show.print_parts(out, compared([SavedCalibration.open(folder) for folder in folders]))
