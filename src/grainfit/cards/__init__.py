"""Material cards: a calibrated material in the syntax of a solver, with its uncertainty."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from os import PathLike
from pathlib import Path

from grainfit.cards import messages
from grainfit.cards.csv_card import render_csv
from grainfit.cards.from_calibration import make_card
from grainfit.cards.json_card import render_json
from grainfit.cards.other_programs.aspherix import ASPHERIX
from grainfit.cards.other_programs.base import render_other
from grainfit.cards.other_programs.edem import EDEM
from grainfit.cards.other_programs.mercurydpm import MERCURYDPM
from grainfit.cards.other_programs.mfix import MFIX
from grainfit.cards.other_programs.pfc import PFC
from grainfit.cards.other_programs.rocky import ROCKY
from grainfit.errors import InputError
from grainfit.files import write_atomically, writing
from grainfit.materials.card import CardParameter, CardResponse, MaterialCard
from grainfit.registration import require_complete
from grainfit.solvers.dem.lammps.card import render_lammps
from grainfit.solvers.dem.liggghts.card import render_liggghts
from grainfit.solvers.dem.yade.card import render_yade
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.validation import kind_faults
from grainfit.work_folder.saved_calibration import SavedCalibration, read_answer

__all__ = [
    "FORMATS",
    "FORMAT_TITLES",
    "CardParameter",
    "CardResponse",
    "MaterialCard",
    "WritableCard",
    "material_card",
    "render",
    "require_format",
    "write_card",
]

_OTHER = (EDEM, ROCKY, MERCURYDPM, PFC, MFIX, ASPHERIX)
_RENDERERS: Mapping[str, Callable[[MaterialCard], str]] = {
    "liggghts": render_liggghts,
    "lammps": render_lammps,
    "yade": render_yade,
    **{program.name: render_other(program) for program in _OTHER},
    "json": render_json,
    "csv": render_csv,
}
for _program in DEM_PROGRAMS:
    require_complete("solver", _program, [] if _program in _RENDERERS else ["its card is missing"])

_PROGRAM_TITLES = {name: program.title for name, program in DEM_PROGRAMS.items()}
_PROGRAM_TITLES |= {program.name: program.title for program in _OTHER}
#: Formats of a card with their names for people.
FORMAT_TITLES: Mapping[str, str] = {
    name: _PROGRAM_TITLES.get(name, name.upper()) for name in _RENDERERS
}
#: Formats of a card.
FORMATS = tuple(_RENDERERS)


@dataclass(frozen=True)
class WritableCard(MaterialCard):
    """A material card that writes itself for solvers and other programs."""

    def __repr__(self) -> str:
        return f"<MaterialCard {self.name!r}: {len(self.parameters)} parameters, {self.verdict}>"

    def write(self, to: str, path: str | Path) -> Path:
        """Write the card to a file, in place of one that is there; all of it or nothing.

        Raises
        ------
        InputError
            There is no such format, the card lacks a value that the solver needs, or the file
            cannot be written.
        """
        wanted = "the path of a file"
        InputError.raise_for(kind_faults("path", path, str | PathLike, wanted))
        write_card(Path(path), render(self, to))
        return Path(path)


def material_card(source: str | Path | SavedCalibration) -> WritableCard:
    """Return the card of the calibration that was started last in a work folder.

    Parameters
    ----------
    source : path or SavedCalibration
        The work folder, or the calibration read from it.

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
    reading = SavedCalibration.of(source)
    read_answer(reading)
    card = make_card(reading, reading.intervals)
    notes = () if reading.intervals else _why_no_intervals(reading)
    return _writable(replace(card, notices=(*card.notices, *notes)))


def _writable(card: MaterialCard) -> WritableCard:
    return WritableCard(**{field.name: getattr(card, field.name) for field in fields(card)})


def render(card: MaterialCard, to: str) -> str:
    """Return a card as text.

    Parameters
    ----------
    card : MaterialCard
        The material.
    to : str
        The format, one of `FORMATS`.

    Raises
    ------
    InputError
        There is no such format, or the card lacks a value that the solver needs.
    """
    return require_format(to)(card)


def require_format(to: str, key: str = "to") -> Callable[[MaterialCard], str]:
    """Return the function that writes a card in a format.

    Parameters
    ----------
    to : str
        The format, one of `FORMATS`.
    key : str
        Name of the argument or of the option, for the message.

    Raises
    ------
    InputError
        There is no such format.
    """
    if to not in FORMATS:
        *others, last = FORMATS
        known = ", ".join(others)
        raise InputError(messages.NO_FORMAT.fault(key, given=to, known=known, last=last))
    return _RENDERERS[to]


def write_card(path: Path, text: str) -> None:
    """Write a card to a file, in place of one that is there; all of it or nothing.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    with writing(path):
        write_atomically(path, text)


def _why_no_intervals(reading: SavedCalibration) -> tuple[str, ...]:
    why = reading.why_nothing_agrees
    return (why,) if why else reading.analyse_parameters().notes
