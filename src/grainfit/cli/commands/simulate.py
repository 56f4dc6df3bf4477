"""The command that simulates the tests of a calibration file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.consoles import err_remarks, out, out_remarks
from grainfit.cli.exit_codes import BAD_INPUT
from grainfit.cli.help_texts import shown_default
from grainfit.cli.options import CalibrationPath, Workers, settings_option, workdir_option
from grainfit.cli.simulating import simulating
from grainfit.errors import InputError

if TYPE_CHECKING:
    from grainfit.analysis.scatter import RepeatedRuns
    from grainfit.calibration_file.build import CalibrationSetup
    from grainfit.evaluation import Evaluation

#: Frames of an animation.
_FRAMES = 60

_SET = "A parameter's value, units allowed: particle.density=2300. Repeat as needed."
_AnswerOf = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        help="Work folder of a calibration: its answer is simulated. FILE may have another "
        "test, another size or another solver.",
    ),
]
_FirstSeed = Annotated[
    int,
    typer.Option(
        metavar="N", min=1, max=900_000_000, help="Insertion seed, the first with --repeat."
    ),
]
_Repeat = Annotated[
    int,
    typer.Option(metavar="N", min=1, max=100_000, help="Runs of each test, with seeds N, N+1 ..."),
]
_Workdir = Annotated[
    Path | None,
    workdir_option(
        "Where runs are kept, for example the work folder of the calibration.",
        "the file's name with .simulated, here",
    ),
]
_Animate = Annotated[
    bool,
    typer.Option(
        "--animate",
        help="Write a page beside each run that plays it in three dimensions, with the walls "
        "where they are. Also of a run that fails: it shows why.",
    ),
]
_Frames = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        min=2,
        max=1000,
        help=f"Largest number of frames of --animate. {shown_default(str(_FRAMES))}",
        show_default=False,
    ),
]


def simulate(
    file: CalibrationPath,
    settings: Annotated[list[str] | None, settings_option(_SET)] = None,
    answer_of: _AnswerOf = None,
    seed: _FirstSeed = 1,
    repeat: _Repeat = 1,
    workers: Workers = None,
    workdir: _Workdir = None,
    animated: _Animate = False,
    frames: _Frames = None,
) -> None:
    """Simulate every test once and show its responses and its folder.

    With --repeat, simulate it with several seeds and show mean and scatter of the responses beside
    the tolerances. Finished runs are kept: stop it with Ctrl-C, start it again, also with more
    seeds, and only what is missing is simulated.

    With --animate, watch what a test does: animation.html in the folder of the run opens in any
    browser, without network. The run is the same, to the last digit of its responses; one that was
    simulated before without frames is simulated again, and stays as it is.

    Free parameters that are not set take the middle of their interval, or with --answer-of the
    values of the answer of a calibration.

    Example:  grainfit simulate beads.toml --repeat 20

    Example:  grainfit simulate full_size.toml --answer-of beads.grainfit
    """
    from grainfit.campaign.work_folder import simulations_folder
    from grainfit.work_folder.repeat_runs import repeat_runs

    film = _frames_to_film(animated, frames, repeat)
    setup = _prepared(file, settings or (), film)
    given: dict[str, Any] = {"settings": settings or (), "answer_of": answer_of}
    given |= {"workdir": workdir, "workers": workers}
    with simulating() as report:
        runs = repeat_runs(setup, repeat=repeat, seed=seed, **given, **report)
    _show(runs, setup, workdir or simulations_folder(file), film)


def _frames_to_film(animated: bool, frames: int | None, repeat: int) -> int:
    """Return the largest number of frames of an animation; 0 for none."""
    if frames is not None and not animated:
        raise InputError(messages.FRAMES_WITHOUT_ANIMATION.fault(""))
    if animated and repeat > 1:
        raise InputError(messages.ANIMATION_OF_ONE_RUN.fault(""))
    return (frames or _FRAMES) if animated else 0


def _prepared(file: Path, settings: Sequence[str], frames: int) -> CalibrationSetup:
    """Return a calibration that can be simulated; its runs leave frames for an animation."""
    from grainfit.calibration_file.build import load_calibration

    setup = load_calibration(file)
    for note in setup.outside(settings):
        err_remarks.print(f"Note: {note}", highlight=False, markup=False)
    if frames:
        from grainfit.animation.animation import filming

        return filming(setup, frames)
    return setup


def _show(runs: RepeatedRuns, setup: CalibrationSetup, folder: Path, frames: int) -> None:
    """Print the responses; exit with an error if a run failed."""
    from grainfit.campaign.absent_responses import absences
    from grainfit.campaign.batch import run_folders

    if len(runs.evaluations) > 1:
        show.print_parts(out, runs.summary())
    else:
        [evaluation] = runs.evaluations
        show.print_run(out, runs, run_folders(setup.solvers, evaluation, folder))
        if frames:
            _animate(setup, evaluation, folder, frames)
    show.print_absences(out, absences(setup.solvers, runs.evaluations))
    if runs.failures:
        raise typer.Exit(BAD_INPUT)


def _animate(setup: CalibrationSetup, evaluation: Evaluation, folder: Path, frames: int) -> None:
    """Write the pages of the runs of a command, and print where they are."""
    from grainfit.animation.animation import animate

    def say(tests: list[str]) -> None:
        text = messages.SIMULATED_AGAIN(tests=", ".join(tests))
        out_remarks.print(text, highlight=False, markup=False)

    with simulating("animation"):
        for animation in animate(setup, evaluation, folder, frames, say):
            show.print_animation(out, animation)
