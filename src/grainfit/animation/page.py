"""Page of an animation: one file that works offline and holds everything that it shows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from grainfit.animation.drawn_film import DrawnFilm
from grainfit.formatting import assigned, counted, in_a_row, number, plain
from grainfit.preview.scene_picture import COLOURS
from grainfit.preview.scene_text import stage_text
from grainfit.report.package_page import package_page
from grainfit.report.rendering import script_json
from grainfit.scenes.wall_travels import StageSpan

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
