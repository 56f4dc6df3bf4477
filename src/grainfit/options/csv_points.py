"""Read the points of a measured curve, and the covariance of their errors, from CSV files."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

from grainfit.errors import InputError
from grainfit.files import LARGEST_CURVE
from grainfit.options.csv_file import read_csv
from grainfit.options.kinds import Quantity
from grainfit.options.places import Findings, Place, show
from grainfit.units import UnitError, is_unit, to_unit

_MOST_FAULTS = 20
_MOST_NAMED = 10
_POINTS = "a header, and one line for each point"
#: Unit behind the name of a column, as in "opening [mm]" and "opening (mm)".
_UNIT_IN_NAME = re.compile(r"[\[(]\s*([^\[\]()]*?)\s*[\])]\s*$")
_MATRIX = "a row of numbers for each point of the curve, without a header"

Cells = list[str]
Lines = Sequence[tuple[int, Cells]]
Locate = Callable[[Sequence[str]], tuple[int, int]]


@dataclass(frozen=True)
class Column:
    """A column of the CSV file of a curve.

    Parameters
    ----------
    key : str
        Key of the calibration file that names it.
    position : int
        Its position when the calibration file does not name it.
    name : str or None
        Name in the header.
    written : str or None
        Unit of its numbers; empty when there is nothing to convert, None when the header states
        it, as in ``opening [mm]``.
    unit : str
        Unit to convert to.
    is_known : bool
        Whether the unit of its numbers is known, so that the header must not state another one.
    """

    key: str
    position: int
    name: str | None
    written: str | None
    unit: str
    is_known: bool = False

    def convert(self, number: float) -> float:
        """Return a number of the column in the unit of the response."""
        return to_unit(f"{number!r} {self.written}", self.unit) if self.written else number

    @property
    def scale(self) -> float:
        """Factor of conversion of a difference."""
        return self.convert(1.0) - self.convert(0.0)


@dataclass(frozen=True)
class Points:
    """Points of a curve, coordinates increasing.

    Parameters
    ----------
    coordinate : str
        Name of the column of the coordinates.
    coordinates, values : tuple of float
        The points.
    lines : tuple of int
        Their lines in the file.
    order : tuple of int
        Their positions in the file, counted from 0.
    """

    coordinate: str
    coordinates: tuple[float, ...]
    values: tuple[float, ...]
    lines: tuple[int, ...]
    order: tuple[int, ...]


def stated_unit(heading: str) -> str:
    """Return the unit behind the name of a column; empty if there is none.

    Examples
    --------
    >>> stated_unit("opening [mm]")
    'mm'
    """
    stated = _UNIT_IN_NAME.search(heading)
    return "" if stated is None else stated[1]


def read_points(
    path: Path, x: Column, y: Column, place: Place, *, most: int, locate: Locate | None = None
) -> Points | None:
    """Read the points of a curve; None after noting every fault at a place.

    Parameters
    ----------
    path : Path
        CSV file with a header.
    x, y : Column
        Columns of coordinates and values.
    place : Place
        Of the file in the calibration file.
    most : int
        Largest number of points.
    locate : callable, optional
        Returns the positions of both columns by the headings, or raises `InputError`; by default
        those of the columns count.
    """
    lines = _read(path, _POINTS, place)
    if lines is None:
        return None
    notes = _Notes(path, place)
    header, rows = lines[0][1], lines[1:]
    columns = _find_columns(header, (x, y), locate, notes)
    if columns is None:
        return None
    if not 2 <= len(rows) <= most:
        remedy = f"Give 2 to {most}; average neighbours of a longer curve."
        notes.note("", f"has {len(rows)} points.", remedy)
        return None
    found = [
        [_number(notes, line, cells, len(header), place_of, column) for place_of, column in columns]
        for line, cells in rows
    ]
    numbers = [(a, b) for a, b in found if a is not None and b is not None]
    if len(numbers) < len(rows):
        notes.finish()
        return None
    order = sorted(range(len(rows)), key=lambda i: numbers[i][0])
    name = header[columns[0][0]]
    points = Points(
        name,
        tuple(numbers[i][0] for i in order),
        tuple(numbers[i][1] for i in order),
        tuple(rows[i][0] for i in order),
        tuple(order),
    )
    _note_repeated(points, notes)
    return None if notes.finish() else points


def read_covariance(
    path: Path, points: Points, scale: float, place: Place
) -> list[list[float]] | None:
    """Read the covariance of the errors of a curve; None after noting every fault at a place.

    Parameters
    ----------
    path : Path
        CSV file without a header, its rows and columns in the order of the lines of the curve.
    points : Points
        Points of the curve.
    scale : float
        Factor to the square of the unit of the values.
    place : Place
        Of the file in the calibration file.
    """
    lines = _read(path, _MATRIX, place)
    if lines is None:
        return None
    notes, count = _Notes(path, place), len(points.values)
    remedy = f"Give {count} rows of {count} numbers, one for each point of the curve."
    if len(lines) != count:
        notes.note("", f"has {len(lines)} rows, and the curve {count} points.", remedy)
    matrix = []
    for line, cells in lines:
        if len(cells) != count:
            notes.note(f"line {line}", f"has {len(cells)} numbers.", remedy)
            continue
        matrix.append([_parse(text) for text in cells])
        for position, (text, number) in enumerate(zip(cells, matrix[-1], strict=True), start=1):
            if not math.isfinite(number):
                where = f"line {line}, column {position}"
                notes.note(where, f"is {show(text)}, not a number.", "Use a decimal point.")
    if notes.finish():
        return None
    return [[scale * matrix[i][j] for j in points.order] for i in points.order]


class _Notes:
    """Faults of one file; of many, the first ones are noted."""

    def __init__(self, path: Path, place: Place) -> None:
        self._name = path.name
        self._place = place
        self.count = 0

    def note(self, where: str, message: str, remedy: str = "") -> None:
        self.count += 1
        if self.count <= _MOST_FAULTS:
            separator = ", " if where else ""
            self._place.fault(f"{self._name}{separator}{where} {message}", remedy)

    def finish(self) -> bool:
        """Note the number of further faults; return True if there are faults."""
        if self.count > _MOST_FAULTS:
            self._place.fault(f"{self._name} has {self.count - _MOST_FAULTS} more faults.")
        return self.count > 0


def _read(path: Path, content: str, place: Place) -> Lines | None:
    try:
        return read_csv(path, largest=LARGEST_CURVE, content=content)
    except InputError as error:
        for fault in error.faults:
            place.fault(f"{path.name} {fault.message}", fault.remedy)
        return None


def _find_columns(
    header: Cells, columns: Sequence[Column], locate: Locate | None, notes: _Notes
) -> list[tuple[int, Column]] | None:
    """Return the columns with their positions."""
    if all(math.isfinite(_parse(name)) for name in header):
        notes.note("line 1", "has no names of columns.", "Name the columns in the first line.")
        return None
    if len(header) == 1:
        remedy = "Separate columns by commas." if any(s in header[0] for s in ";\t") else ""
        notes.note("", f"has one column, {show(header[0])}.", remedy or f"Give {_POINTS}.")
        return None
    found = (
        _located(header, locate, notes)
        if locate is not None
        else [_position(header, column, notes) for column in columns]
    )
    if None in found:
        return None
    if len(set(found)) < len(found):
        name = show(header[found[0] or 0])
        notes.note(f"column {name}", "is both x and y.", 'Name two: x = "...", y = "...".')
        return None
    for name in dict.fromkeys(header[at] for at in found if at is not None):
        if name and header.count(name) > 1:
            notes.note(f"column {show(name)}", "is there more than once.", "Keep one of them.")
    located = [
        (at, _with_unit(column, header[at], notes))
        for at, column in zip(found, columns, strict=True)
        if at is not None
    ]
    return None if notes.count else located


def _with_unit(column: Column, name: str, notes: _Notes) -> Column:
    """Return the column with the unit that its name in the header states, if it shall."""
    if column.written is not None:
        if column.is_known:
            _note_other_unit(column, name, notes)
        return column
    written = stated_unit(name)
    try:
        to_unit(f"1 {written}", column.unit)
    except UnitError:
        message = f"has the unit {show(written)}." if written else "has no unit."
        remedy = f'State the unit behind the name: "{column.key} [{column.unit}]".'
        notes.note(f"column {show(name)}", message, remedy)
    return replace(column, written=written)


def _note_other_unit(column: Column, name: str, notes: _Notes) -> None:
    stated, taken = stated_unit(name), column.written or column.unit
    # What is in brackets may be a remark.
    if not stated or not is_unit(stated):
        return
    try:
        is_same = math.isclose(to_unit(f"1 {stated}", column.unit), column.convert(1.0))
    except UnitError:
        is_same = False
    if not is_same:
        where = f"in {taken}" if taken else "as they are, without a unit"
        message = f"states {show(stated)}, and its numbers are taken {where}."
        remedy = f'Write {column.key}_unit = "{stated}", or correct the heading.'
        notes.note(f"column {show(name)}", message, remedy)


def _located(header: Cells, locate: Locate, notes: _Notes) -> list[int | None]:
    try:
        return [*locate(header)]
    except InputError as error:
        for fault in error.faults:
            notes.note("", fault.message, fault.remedy)
        return [None]


def _position(header: Cells, column: Column, notes: _Notes) -> int | None:
    if column.name is None:
        return column.position
    if column.name in header:
        return header.index(column.name)
    there = ", ".join(show(name) for name in header[:_MOST_NAMED])
    remedy = f"{column.key} can be one of: {there}."
    notes.note(f"column {show(column.name)}", "is missing.", remedy)
    return None


def _number(
    notes: _Notes, line: int, cells: Cells, width: int, position: int, column: Column
) -> float | None:
    """Return the number in a cell, converted; None after noting its fault."""
    if len(cells) > width:
        if column.key == "x":
            message = f"has {len(cells)} cells, and the header {width}."
            notes.note(f"line {line}", message, "Use decimal points, and a comma between cells.")
        return None
    where = f"line {line}, column {column.name or position + 1}"
    text = cells[position] if position < len(cells) else ""
    if not text:
        notes.note(where, "has no value.", "Leave the point out, or complete it.")
        return None
    number = _parse(text)
    if math.isnan(number):
        notes.note(where, f"is {show(text)}, not a number.", "Use a decimal point.")
        return None
    for message, remedy in _faults_of_size(number, column):
        notes.note(where, message, remedy)
        return None
    return column.convert(number)


def _faults_of_size(number: float, column: Column) -> Iterator[tuple[str, str]]:
    findings = Findings(Path())
    try:
        value = column.convert(number) if math.isfinite(number) else number
    except UnitError as error:
        yield error.message, error.remedy
        return
    Quantity(column.unit).read_converted(value, Place(findings))
    for fault in findings.faults:
        yield fault.message, fault.remedy


def _note_repeated(points: Points, notes: _Notes) -> None:
    neighbours = pairwise(zip(points.coordinates, points.lines, strict=True))
    for (low, first), (high, second) in neighbours:
        if low == high:
            message = f"has the same {points.coordinate} as line {first}, {high:g}."
            remedy = f"Give one point for each {points.coordinate}, such as the mean of several."
            notes.note(f"line {second}", message, remedy)


def _parse(text: str) -> float:
    """Return the number that a text is; NaN for none."""
    # Python reads 1_000 as a thousand; in a table it means something else.
    try:
        return math.nan if "_" in text else float(text)
    except ValueError:
        return math.nan
