"""The command that shows what the size of the apparatus changes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.consoles import out
from grainfit.cli.help_texts import shown_default
from grainfit.cli.options import (
    CalibrationPath,
    Force,
    Workdir,
    Workers,
    output_option,
    require_free,
    settings_option,
)
from grainfit.cli.simulating import simulating

_TIMES_DEFAULT = shown_default("1,2,4, or what makes 1,000, 2,000 and 4,000 particles")
_Times = Annotated[
    str,
    typer.Option(
        metavar="F,F,...",
        help=f"Numbers of particles to simulate, over those of the file. {_TIMES_DEFAULT}",
    ),
]
_To = Annotated[
    float | None,
    typer.Option(
        metavar="F",
        help="Number of particles for which the trend is told, over that of the file. "
        + shown_default("1 for an apparatus of more than 4,000 particles, else 16"),
    ),
]
_Seeds = Annotated[int, typer.Option(metavar="N", min=1, help="Runs of each size.")]
_SET_DEFAULT = shown_default("the middle of its interval")
_SET = f"A parameter's value, units allowed. Repeat as needed. {_SET_DEFAULT}"
_OUTPUT = "The picture. " + shown_default("the file's name with .size.png, here")


def size(
    file: CalibrationPath,
    times: _Times = "",
    to: _To = None,
    seeds: _Seeds = 3,
    settings: Annotated[list[str] | None, settings_option(_SET)] = None,
    output: Annotated[Path | None, output_option("FILE.png", _OUTPUT)] = None,
    workers: Workers = None,
    workdir: Workdir = None,
    force: Force = False,
) -> None:
    """Show what the size of the apparatus changes, and the trend to the real one.

    A laboratory's vessel holds ten or a hundred times the particles that are simulated in
    minutes. Give its real dimensions in the file: this command simulates it smaller, with the same
    particles and outlets, and says what the trend gives at its real size, how sure that is, and
    how long a run of it takes. Finished runs are kept: stop it with Ctrl-C, and start it again.

    Example:  grainfit size bucket.toml --seeds 5
    """
    picture = output or Path(f"{file.stem}.size.png")
    require_free(picture, force=force)
    from grainfit.work_folder.size_picture import draw_sizes
    from grainfit.work_folder.size_study import size_study

    with simulating() as report:
        study = size_study(
            file,
            times=show.read_numbers("times", times) if times else (),
            to=to,
            seeds=seeds,
            settings=settings or (),
            workdir=workdir,
            workers=workers,
            **report,
        )
    show.print_parts(out, study.summary())
    draw_sizes(study, picture)
    show.print_parts(out, (f"Picture: {picture}",))
