"""Particle diameters as an option: one, classes by mass, a distribution, or a sieve file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from grainfit.errors import InputError
from grainfit.materials import messages
from grainfit.materials.size_classes import Truncation, divide
from grainfit.materials.size_distributions import (
    DIAMETER,
    LogNormal,
    RosinRammler,
    SieveCurve,
    SizeDistribution,
    point_faults,
)
from grainfit.materials.sizes import ParticleSizes
from grainfit.options.fields import option_keys
from grainfit.options.kinds import Kind, ListOf, Quantity, Schema, Share, Text, note_wrong_kind
from grainfit.options.paths import Located
from grainfit.options.places import Findings, Place, show
from grainfit.options.tables import Finish, Key, Table, Values
from grainfit.table_files.curve_points import note_at, read_points
from grainfit.table_files.headings import Heading
from grainfit.table_files.reading import Wanted
from grainfit.units import UnitError, to_unit

_FORMS = (
    'Write diameter = "10 mm"; a list: '
    '[{ value = "8 mm", mass_fraction = 0.3 }, { value = ..., mass_fraction = ... }]; or one of '
    '{ sieve_curve = "sieve.csv" }, { log_normal = { ... } } and { rosin_rammler = { ... } }.'
)
#: Sieves of a curve at most; a laser diffractometer gives about 100 sizes.
_MOST_SIEVES = 400
_PASSING_IN_PERCENT = Wanted(Quantity(""), "passing", given="%")
#: By ISO 9276, Q3 is the cumulative passing, and q3 its density.
_PASSING = re.compile(r"(?i:pass|finer|undersize|under size)|\bQ_?3\b")
_RETAINED = re.compile(r"retain|residue|coarser|oversize|over size", re.IGNORECASE)
_OPENING = re.compile(r"opening|aperture|sieve|mesh|size|diameter|^[dx]\b", re.IGNORECASE)
#: Headings that are named in a message, at most.
_MOST_NAMED = 10


@dataclass(frozen=True)
class Diameters(Kind):
    """The particle diameter, a discrete distribution of diameters, or a continuous one."""

    def read(self, value: Any, place: Place) -> ParticleSizes | None:
        """Read one diameter, a list of diameters with mass fractions, or a distribution."""
        if isinstance(value, list):
            return self._classes(value, place)
        if isinstance(value, dict):
            if value.keys().isdisjoint(_DISTRIBUTIONS):
                note_wrong_kind(value, place, "a length, a list or a distribution", _FORMS)
                return None
            sizes: ParticleSizes | None = DISTRIBUTION.read(value, place)
            return sizes
        diameter = DIAMETER.read(value, place)
        return None if diameter is None else ParticleSizes((diameter,))

    @staticmethod
    def _classes(value: list[Any], place: Place) -> ParticleSizes | None:
        classes = _SIZE_CLASSES.read(value, place)
        if classes is None or any(
            None in (c.get("value"), c.get("mass_fraction")) for c in classes
        ):
            return None
        diameters = tuple(c["value"] for c in classes)
        fractions = tuple(c["mass_fraction"] for c in classes)
        if len(set(diameters)) < len(diameters):
            place.fault(messages.SAME_DIAMETER)
        elif abs(sum(fractions) - 1) > 1e-6:
            place.fault(messages.SUM_OF_FRACTIONS, sum=sum(fractions))
        else:
            return ParticleSizes(diameters, fractions)
        return None

    def schema(self) -> Schema:
        """Return the JSON Schema of all forms."""
        forms = DIAMETER.schema()["anyOf"]
        return {"anyOf": [*forms, _SIZE_CLASSES.schema(), DISTRIBUTION.schema()]}


_SIZE_CLASSES = ListOf(
    Table(
        (
            Key("value", DIAMETER, "Diameter of this class.", required=True, example='"8 mm"'),
            Key(
                "mass_fraction",
                Share(),
                "Share of the mass in this class, as a sieve gives it; all sum to 1.",
                required=True,
                example="0.3",
            ),
        )
    )
)


def _note_all(error: InputError, place: Place, otherwise: Place) -> None:
    """Note faults at their keys below a place; those without a key elsewhere."""
    for fault in error.faults:
        at = place.at(fault.key) if fault.key else otherwise
        at.refuse(fault)


def _made_by(distribution: type[SizeDistribution]) -> Finish:
    def finish(values: Values, place: Place) -> SizeDistribution | None:
        if None in values.values():
            return None
        try:
            return distribution(**values)
        except InputError as error:
            _note_all(error, place, place)
            return None

    return finish


def _divided(values: Values, place: Place) -> ParticleSizes | None:
    given = [name for name in _DISTRIBUTIONS if name in values]
    if len(given) != 1:
        place.fault(messages.SEVERAL_DISTRIBUTIONS, given=" and ".join(given))
        return None
    [name] = given
    if "opening_unit" in values and name != SieveCurve.key:
        place.at("opening_unit").fault(messages.UNIT_WITHOUT_CURVE)
        return None
    if None in values.values():
        return None
    distribution = values[name]
    if name == SieveCurve.key:
        column = opening_column(values.get("opening_unit"), place)
        distribution = column and read_sieve_curve(distribution, column, place.at(name))
    if distribution is None:
        return None
    options = {key.name: values[key.name] for key in _TRUNCATION if key.name in values}
    try:
        return divide(distribution, Truncation(**options))
    except InputError as error:
        _note_all(error, place, place.at(name))
        return None


_DISTRIBUTIONS = (SieveCurve.key, LogNormal.key, RosinRammler.key)
_TRUNCATION = option_keys(Truncation)
#: A continuous distribution.
DISTRIBUTION = Table(
    (
        Key(
            SieveCurve.key,
            Located(),
            "CSV file of a sieve analysis: a header, and one line for each sieve with its opening "
            "and the share of the mass that passes it, in percent.",
            example='"sieve.csv"',
        ),
        Key(
            "opening_unit",
            Text(),
            "Unit of the openings, unless the header of the file states it.",
            example='"mm"',
        ),
        Key(
            LogNormal.key,
            Table(option_keys(LogNormal), _made_by(LogNormal)),
            "Log-normal distribution by mass: median and geometric_standard_deviation, or d10 and "
            "d90.",
            example='{ median = "3 mm", geometric_standard_deviation = 1.4 }',
        ),
        Key(
            RosinRammler.key,
            Table(option_keys(RosinRammler), _made_by(RosinRammler)),
            "Rosin-Rammler distribution by mass: d63 and exponent.",
            example='{ d63 = "3 mm", exponent = 3 }',
        ),
        *_TRUNCATION,
    ),
    _divided,
)


def sieve_curve(path: str | Path, opening_unit: str | None = None) -> SieveCurve:
    """Read a sieve curve from a table.

    Parameters
    ----------
    path : path
        Table with a header, and one line for each sieve with its opening and the share of the mass
        that passes it, in percent; in this order, unless the headings say which column is which.
    opening_unit : str, optional
        Unit of the openings, unless the header states it, as in ``opening [mm]``; it must not state
        another one.

    Raises
    ------
    InputError
        Names every fault of the file.
    """
    findings = Findings()
    place = Place(findings, ("sieve_curve",))
    openings = opening_column(opening_unit, place)
    curve = None if openings is None else read_sieve_curve(Path(path), openings, place)
    if curve is None:
        raise InputError(findings.faults)
    return curve


def opening_column(unit: str | None, place: Place) -> Wanted | None:
    """Return the column of the openings; None after noting that its unit is no length."""
    try:
        to_unit(f"1 {unit or 'm'}", "m")
    except UnitError as error:
        place.at("opening_unit").refuse(error)
        return None
    return Wanted(Quantity("m"), "opening", given=unit, unit_key="opening_unit", needs_unit=True)


def read_sieve_curve(path: Path, openings: Wanted, place: Place) -> SieveCurve | None:
    """Read a sieve curve; None after noting every fault at a place.

    Parameters
    ----------
    path : Path
        The table.
    openings : Wanted
        Column of the openings.
    place : Place
        Of the file in the calibration file.
    """
    columns = (openings, _PASSING_IN_PERCENT)
    points = read_points(path, columns, sieve_columns, place, most=_MOST_SIEVES)
    if points is None:
        return None
    faults = [*point_faults(points.coordinates, points.values)]
    at_lines = [replace(fault, key=f"line {points.lines[at]}") for at, fault in faults]
    note_at(place, path, at_lines)
    return None if faults else SieveCurve(points.coordinates, points.values)


def sieve_columns(headings: Sequence[Heading]) -> tuple[int, int]:
    """Return the positions of the openings and of what passes.

    Where two columns say nothing, they are taken in this order.

    Raises
    ------
    InputError
        The headings leave open which column it is, or tell of other quantities.

    Examples
    --------
    >>> from grainfit.table_files.headings import heading
    >>> texts = ["passing [%]", "mass [g]", "opening [mm]"]
    >>> sieve_columns([heading(at, text) for at, text in enumerate(texts)])
    (2, 0)
    """
    known = [one for one in headings if not _RETAINED.search(one.name)]
    shares = [one for one in known if not _is_in("kg", one) and not _is_in("m", one)]
    passing = _first_of(
        [one for one in shares if one.name.lower() == "passing"],
        [one for one in shares if _PASSING.search(one.name)],
        [one for one in shares if "%" in one.text],
        [one for one in shares if one.position == 1 and len(headings) == 2],
    )
    value = _only(passing, headings, "cumulative passing", "passing [%]")
    others = [one for one in known if one.position != value]
    lengths = [one for one in others if _is_in("m", one)]
    openings = _first_of(
        [one for one in lengths if _OPENING.search(one.name)],
        lengths,
        [one for one in others if _OPENING.search(one.name)],
        others[:1],
    )
    return _only(openings, headings, "opening", "opening [mm]"), value


def _is_in(unit: str, heading: Heading) -> bool:
    """Return whether the unit of a heading converts to another one."""
    try:
        to_unit(f"1 {heading.unit}", unit)
    except UnitError:
        return False
    return bool(heading.unit)


def _first_of(*ranks: list[Heading]) -> list[Heading]:
    """Return the headings of the first rank that any has: those that say it most clearly."""
    return next(filter(None, ranks), [])


def _only(found: list[Heading], there: Sequence[Heading], meaning: str, example: str) -> int:
    """Return the position of the only column that was found, or raise `InputError`."""
    if len(found) == 1:
        return found[0].position
    names = ", ".join(show(one.text) for one in there[:_MOST_NAMED])
    is_retained = not found and any(_RETAINED.search(one.name) for one in there)
    message = messages.SEVERAL_MAY_BE if found else messages.NONE_IS
    if is_retained:
        message = messages.ONLY_RETAINED
    raise InputError(message.fault("line 1", names=names, meaning=meaning, example=example))
