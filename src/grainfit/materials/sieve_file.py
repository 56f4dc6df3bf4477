"""Read a sieve curve from a CSV file."""

from __future__ import annotations

from pathlib import Path

from grainfit.errors import InputError
from grainfit.materials.sieve_columns import sieve_columns
from grainfit.materials.size_distributions import SieveCurve, point_faults
from grainfit.options.csv_points import Column, read_points
from grainfit.options.places import Findings, Place
from grainfit.units import UnitError, to_unit

#: Sieves of a curve at most; a laser diffractometer gives about 100 sizes.
_MOST_SIEVES = 400
_PASSING = Column("passing", 1, None, "%", "")


def sieve_curve(path: str | Path, opening_unit: str | None = None) -> SieveCurve:
    """Read a sieve curve from a CSV file.

    Parameters
    ----------
    path : path
        CSV file: a header, and one line for each sieve with its opening and the share of the mass
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
    column = opening_column(opening_unit, place)
    curve = None if column is None else read_sieve_curve(Path(path), column, place)
    if curve is None:
        raise InputError(findings.faults)
    return curve


def opening_column(unit: str | None, place: Place) -> Column | None:
    """Return the column of the openings; None after noting that its unit is no length."""
    try:
        to_unit(f"1 {unit or 'm'}", "m")
    except UnitError as error:
        place.at("opening_unit").fault(error.message, error.remedy)
        return None
    return Column("opening", 0, None, unit, "m", is_known=True)


def read_sieve_curve(path: Path, openings: Column, place: Place) -> SieveCurve | None:
    """Read a sieve curve; None after noting every fault at a place.

    Parameters
    ----------
    path : Path
        The CSV file.
    openings : Column
        Column of the openings.
    place : Place
        Of the file in the calibration file.
    """
    points = read_points(path, openings, _PASSING, place, most=_MOST_SIEVES, locate=sieve_columns)
    if points is None:
        return None
    faults = [*point_faults(points.coordinates, points.values)]
    for position, message, remedy in faults:
        place.fault(f"{path.name}, line {points.lines[position]} {message}", remedy)
    return None if faults else SieveCurve(points.coordinates, points.values)
