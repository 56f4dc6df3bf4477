"""Animation of runs: simulate them with frames, and write a page for each."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from grainfit.animation import messages
from grainfit.animation.drawn_film import DrawnFilm, draw_film
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.campaign.batch import run_folders, simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.contact_models.registry import material_units
from grainfit.errors import InputError, NotMeasurableError, RunFailedError
from grainfit.evaluation import Evaluation, name_of_test
from grainfit.files import write_atomically, writing
from grainfit.formatting import assigned, counted, in_a_row, number, plain
from grainfit.preview.scene_picture import COLOURS
from grainfit.preview.scene_text import stage_text
from grainfit.report.package_page import package_page
from grainfit.report.rendering import script_json
from grainfit.scenes.film import FILM, Film
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.wall_travels import StageSpan

PAGE = "animation.html"
#: Work folder of runs that are simulated again, within the work folder; gone at the end.
_AGAIN = "filming"
#: A film of fewer frames, over those that are asked for, is made again.
_SHARE = 0.5
_STATES: Mapping[str, str] = {"still": "stand still", "moving": "move", "later": "are put later"}
#: Ends of stages in words.
_OUTCOMES: Mapping[str, str] = {
    "at_rest": "at rest",
    "done": "done",
    "restless": "did not come to rest",
    "unloaded": "the load was not held",
    "unstable": "became unstable",
    "broken": "particles broke out",
    "": "the run stopped here",
}


@dataclass(frozen=True)
class Animation:
    """Page that shows a run.

    Parameters
    ----------
    test : str
        Name of the test.
    path : Path, optional
        The page; None if there is nothing to show.
    frames : int
        Number of frames.
    size : int
        Of the page, bytes.
    problem : str
        Why there is no page; empty if there is one.
    """

    test: str
    path: Path | None
    frames: int = 0
    size: int = 0
    problem: str = ""


def filming(setup: CalibrationSetup, frames: int) -> CalibrationSetup:
    """Return a calibration whose runs keep frames of the particles; they are the same runs.

    A page shows about so many frames.

    Raises
    ------
    InputError
        No test has a scene.
    """
    if not setup.bulk_tests:
        raise InputError(messages.NO_SCENE.fault("test"), str(setup.file.path))
    solvers = {name: solver.filming(frames) for name, solver in setup.solvers.items()}
    return replace(setup, solvers=solvers)


def animate(
    setup: CalibrationSetup,
    evaluation: Evaluation,
    workdir: Path,
    frames: int,
    on_again: Callable[[list[str]], None] | None = None,
) -> Iterator[Animation]:
    """Write a page beside each run of an evaluation; simulate those again that kept no frames.

    Parameters
    ----------
    setup : CalibrationSetup
        The calibration, from `filming`.
    evaluation : Evaluation
        Runs of its tests, finished or failed.
    workdir : Path
        The work folder that keeps them.
    frames : int
        About how many frames a page shows.
    on_again : callable, optional
        Called with the tests whose runs are simulated again, before.

    Yields
    ------
    Animation
        For each test, in their order.

    Raises
    ------
    InputError
        A page cannot be written.
    StoreError
        The folder cannot be used.
    """
    folders = run_folders(setup.solvers, evaluation, workdir)
    sources = dict(folders)
    without = [
        test
        for test, folder in folders.items()
        if _needs_film(setup, evaluation, test, folder, frames)
    ]
    again = workdir.absolute() / _AGAIN
    if without:
        solvers = {
            test: setup.solvers[test].filming(frames, _duration(folders[test])) for test in without
        }
        options = CampaignOptions(len(solvers), setup.timeouts)
        # Apart from the runs that are kept, which stay as they are whatever happens.
        if on_again is not None:
            on_again(without)
        [made] = simulate_batch(solvers, [evaluation.proposal], again, options)
        sources |= run_folders(solvers, made, again)
    for test in evaluation.runs:
        yield _animation(setup, evaluation, test, folders.get(test), sources.get(test), frames)
    shutil.rmtree(again, ignore_errors=True)


def _needs_film(
    setup: CalibrationSetup, evaluation: Evaluation, test: str, folder: Path, frames: int
) -> bool:
    if setup.solvers[name_of_test(test)].bulk_test is None:
        return False
    try:
        film = Film(folder / FILM)
    except NotMeasurableError:
        # A run that was made now, and has none, did not come to its simulation.
        return evaluation.reused > 0
    return len(film.steps) < _SHARE * frames


def _duration(folder: Path) -> float | None:
    """Return the simulated time of a run, s; None if it is not known."""
    ends = RunOutput(folder).ends
    return ends[-1].time if ends else None


def _animation(
    setup: CalibrationSetup,
    evaluation: Evaluation,
    test: str,
    folder: Path | None,
    source: Path | None,
    frames: int,
) -> Animation:
    solver = setup.solvers[test]
    if solver.bulk_test is None or folder is None or source is None:
        return Animation(test, None, problem=messages.OWN_MODEL())
    proposal, run = evaluation.proposal, RunOutput(source)
    try:
        film = Film(source / FILM)
        scene = solver.experiment(proposal.parameters, proposal.seed)
        drawn = draw_film(scene, run, film, frames)
    except (NotMeasurableError, RunFailedError) as error:
        reason = evaluation.failures.get(test) or str(error)
        return Animation(test, None, problem=messages.NO_FRAMES(reason=reason))
    about = AnimatedRun(
        setup.name,
        test,
        solver.name,
        proposal.seed,
        proposal.parameters,
        material_units(proposal.parameters) | setup.problem.units,
        evaluation.failures.get(test, ""),
    )
    path = folder / PAGE
    with writing(path):
        folder.mkdir(parents=True, exist_ok=True)
        if source != folder:
            shutil.move(source / FILM, folder / FILM)
        write_atomically(path, animation_page(about, drawn))
    return Animation(test, path, drawn.frames, path.stat().st_size)


@dataclass(frozen=True)
class AnimatedRun:
    """A run that is shown.

    Parameters
    ----------
    name, test, solver : str
        Of the calibration, of the test, and of the program that simulated it.
    seed : int
        Insertion seed.
    parameters : mapping of str to float
        Values of the free parameters.
    units : mapping of str to str
        Their units.
    failure : str
        Why the run failed; empty if it did not.
    """

    name: str
    test: str
    solver: str
    seed: int
    parameters: Mapping[str, float]
    units: Mapping[str, str]
    failure: str


def animation_page(run: AnimatedRun, film: DrawnFilm) -> str:
    """Return a page that needs no network."""
    return package_page(
        "grainfit.animation",
        name=plain(run.name),
        run=run,
        values=in_a_row(assigned(run.parameters, run.units)),
        failure=plain(run.failure),
        frames=counted(film.frames, "frame"),
        particles=_particles(film),
        stages=[_stage(span) for span in film.spans],
        legend=[(_STATES[state], COLOURS[state]) for state in COLOURS if state in film.states],
        bodies="Walls and glued particles" if film.data["glued"] else "Walls",
        missing=[*_missing(film)],
        data=script_json(film.data),
    )


def _particles(film: DrawnFilm) -> str:
    words = counted(film.particles, "particle")
    return words if film.drawn >= film.particles else f"{words} ({film.drawn} of them are drawn)"


def _stage(span: StageSpan) -> dict[str, Any]:
    end = "" if math.isinf(span.end) else f" to {number(span.end, 3)}"
    return {
        "name": span.stage.name,
        "remark": span.stage.remark,
        "words": stage_text(span.stage),
        "times": f"{number(span.begin, 3)}{end} s" if end else f"from {number(span.begin, 3)} s",
        "outcome": _OUTCOMES.get(span.outcome, span.outcome),
        "is_good": span.outcome in ("at_rest", "done"),
    }


def _missing(film: DrawnFilm) -> Iterator[str]:
    if film.is_thinned:
        yield f"Of so many particles there are {film.frames} frames only: the page stays small."
    for name, stages in film.unknown.items():
        yield (
            f"The {name} is not drawn in {in_a_row(stages)}: a load moves it, and the scene does "
            "not record its travel there."
        )
    if film.not_drawn:
        yield f"Not drawn, because their shape is not known here: {in_a_row(film.not_drawn)}."
