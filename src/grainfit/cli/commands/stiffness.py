"""The command that shows what the stiffness of the particles changes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.consoles import out
from grainfit.cli.options import Workdir, Workers, settings_option
from grainfit.cli.simulating import simulating

_SourcePath = Annotated[
    Path,
    typer.Argument(
        metavar="FILE-or-DIR",
        help="Work folder of a calibration, for its answer; or a calibration file.",
    ),
]
_Factors = Annotated[
    str,
    typer.Option(
        metavar="F,F,...",
        help="Moduli to simulate, over that of the calibration. A time step is 1/sqrt(F).",
    ),
]
_Seeds = Annotated[int, typer.Option(metavar="N", min=1, help="Runs of each modulus.")]
_SET = "For a file: a parameter's value, units allowed. Repeat as needed."


def stiffness(
    path: _SourcePath,
    factors: _Factors = "1,4,16",
    seeds: _Seeds = 3,
    settings: Annotated[list[str] | None, settings_option(_SET)] = None,
    workers: Workers = None,
    workdir: Workdir = None,
) -> None:
    """Show what the stiffness of the particles changes, and the smallest modulus that will do.

    DEM particles are chosen far softer than real ones, because the time step is proportional to
    1/sqrt(E). Soft particles overlap, which raises bulk densities; most angles do not change.
    This command simulates the tests again with stiffer particles and names the smallest modulus at
    which every response stays within its tolerance of that of the stiffest ones.

    For a work folder it simulates the answer; for a calibration file the values given by --set,
    other free parameters in the middle of their interval. Finished runs are kept: stop it with
    Ctrl-C, start it again with more seeds or factors, and only what is missing is simulated.

    Example:  grainfit stiffness beads.grainfit --factors 1,10 --seeds 5
    """
    from grainfit.work_folder.stiffness_study import stiffness_study

    with simulating() as report:
        study = stiffness_study(
            path,
            factors=show.read_numbers("factors", factors),
            seeds=seeds,
            settings=settings or (),
            workdir=workdir,
            workers=workers,
            **report,
        )
    show.print_parts(out, study.summary())
