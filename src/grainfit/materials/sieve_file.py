"""Read a sieve curve from a table."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from grainfit.errors import InputError
from grainfit.materials import messages
from grainfit.materials.size_distributions import SieveCurve, point_faults
from grainfit.options.kinds import Quantity
from grainfit.options.places import Findings, Place, show
from grainfit.table_files.curve_points import note_at, read_points
from grainfit.table_files.headings import Heading
from grainfit.table_files.reading import Wanted
from grainfit.units import UnitError, to_unit

#: Sieves of a curve at most; a laser diffractometer gives about 100 sizes.
_MOST_SIEVES = 400
_PASSING_IN_PERCENT = Wanted(Quantity(""), "passing", given="%")
#: By ISO 9276, Q3 is the cumulative passing, and q3 its density.
_PASSING = re.compile(r"(?i:pass|finer|undersize|under size)|\bQ_?3\b")
_RETAINED = re.compile(r"retain|residue|coarser|oversize|over size", re.IGNORECASE)
_OPENING = re.compile(r"opening|aperture|sieve|mesh|size|diameter|^[dx]\b", re.IGNORECASE)
#: Headings that are named in a message, at most.
_MOST_NAMED = 10


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
    findings = Findings(Path())
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
        place.at("opening_unit").fault(error.message, error.remedy)
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
