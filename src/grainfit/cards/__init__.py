"""Material cards: a calibrated material in the words of a solver, and how well it is known."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from grainfit.cards.csv_card import render_csv
from grainfit.cards.from_calibration import make_card
from grainfit.cards.json_card import render_json
from grainfit.errors import Fault, InputError
from grainfit.materials.card import CardParameter, CardResponse, MaterialCard
from grainfit.solvers.dem.lammps.card import render_lammps
from grainfit.solvers.dem.liggghts.card import render_liggghts
from grainfit.solvers.dem.yade.card import render_yade
from grainfit.work_folder.saved_calibration import SavedCalibration, read_answer

__all__ = [
    "FORMATS",
    "CardParameter",
    "CardResponse",
    "MaterialCard",
    "material_card",
    "render",
    "require_format",
]

_RENDERERS: Mapping[str, Callable[[MaterialCard], str]] = {
    "liggghts": render_liggghts,
    "lammps": render_lammps,
    "yade": render_yade,
    "json": render_json,
    "csv": render_csv,
}
#: What a card can be written for.
FORMATS = tuple(_RENDERERS)


def material_card(
    source: str | Path | SavedCalibration,
    posterior: Mapping[str, tuple[float, float]] | None = None,
) -> MaterialCard:
    """Return the card of the calibration that was started last in a work folder.

    Parameters
    ----------
    source : path or SavedCalibration
        The work folder, or what was read of it.
    posterior : mapping of str to pair of float, optional
        95 % credible intervals of the free parameters. Without it they are worked out.

    Raises
    ------
    StoreError
        It is not a work folder, or the result in it is damaged.
    InputError
        There is no answer yet.

    Examples
    --------
    >>> import tempfile
    >>> from grainfit import Parameter, Problem, Target, calibrate
    >>> problem = Problem([Parameter("friction", 0.1, 0.9)], [Target("angle", 30.0)])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     result = calibrate(problem, lambda p, _: {"angle": 60 * p["friction"]}, workdir=folder)
    ...     card = material_card(folder)
    >>> card.parameters[0].name, card.calibrated
    ('friction', True)
    """
    reading = source if isinstance(source, SavedCalibration) else SavedCalibration.open(source)
    if posterior is not None:
        return make_card(reading, posterior)
    intervals, notes = _credible_intervals(reading)
    card = make_card(reading, intervals)
    return replace(card, notices=(*card.notices, *notes))


def render(card: MaterialCard, to: str) -> str:
    """Return a card as text.

    Parameters
    ----------
    card : MaterialCard
        The material.
    to : {"liggghts", "lammps", "yade", "json", "csv"}
        What for.

    Raises
    ------
    InputError
        There is no such format, or the solver needs what the card does not have.
    """
    return require_format(to)(card)


def require_format(to: str) -> Callable[[MaterialCard], str]:
    """Return what writes a card in a format.

    Raises
    ------
    InputError
        There is no such format.
    """
    if to not in _RENDERERS:
        raise InputError(
            Fault("--to", f"is {to!r}.", f"Use {', '.join(FORMATS[:-1])} or {FORMATS[-1]}.")
        )
    return _RENDERERS[to]


def _credible_intervals(
    reading: SavedCalibration,
) -> tuple[dict[str, tuple[float, float]], tuple[str, ...]]:
    """Intervals by name of the free parameter, and what the reader should know of them."""
    from grainfit.analysis import analyse

    answer = read_answer(reading).parameters
    if reading.why_nothing_agrees:
        return {}, (reading.why_nothing_agrees,)
    analysis = analyse(reading.problem, reading.known, seed=reading.seed, answer=answer)
    if analysis.posterior is None:
        return {}, analysis.notes
    return {name: analysis.posterior.interval(name) for name in answer}, analysis.notes
