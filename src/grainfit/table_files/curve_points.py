"""Points of a measured curve, with their spread or covariance, from tables."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

from grainfit.errors import Fault, InputError
from grainfit.files import LARGEST_CURVE
from grainfit.options.kinds import Quantity
from grainfit.options.places import Place
from grainfit.student import student_factor
from grainfit.table_files import messages
from grainfit.table_files.dialects import Row
from grainfit.table_files.headings import WITHOUT_UNIT, Heading
from grainfit.table_files.numbers import decimal_mark, parse_number
from grainfit.table_files.reading import Reading, TableFaults, Wanted, find_column, require_headings
from grainfit.table_files.table import Table, read_table

_POINTS = "a header, and one line for each point"
_MATRIX = "a row of numbers for each point of the curve, without a header"

#: Returns the positions of coordinates and values by the headings, or raises `InputError`.
Locate = Callable[[Sequence[Heading]], tuple[int, int]]
_DEVIATION = re.compile(
    r"\b(?:standard[ _]?deviation|st\.?[ _]?dev(?:iation)?|stdev|stddev|std|s\.?d\.?)(?:\b|$)",
    re.IGNORECASE,
)
_ERROR = re.compile(
    r"standard[ _]?(?:error|uncertainty)|\bstd?\.?[ _]?err(?:or)?\b|\bs\.?e\.?m?\.?(?:\b|$)",
    re.IGNORECASE,
)
_COUNT = re.compile(r"n|(?i:count|repeats|repetitions|replicates|number of \w+)")


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
    standard_errors : tuple of float
        Standard errors of the values, where the table has columns for them; else empty.
    unit : str
        Unit from which the values were converted, "" for none.
    scale : float
        Factor of the conversion of differences between values.
    understood : str
        How the table was understood, in one line.
    """

    coordinate: str
    coordinates: tuple[float, ...]
    values: tuple[float, ...]
    lines: tuple[int, ...]
    order: tuple[int, ...]
    standard_errors: tuple[float, ...]
    unit: str
    scale: float
    understood: str


def read_points(
    path: Path,
    columns: tuple[Wanted, Wanted],
    names: tuple[str | None, str | None] | Locate,
    place: Place,
    *,
    most: int,
    with_spread: bool = False,
) -> Points | None:
    """Read the points of a curve; None after noting every fault at a place.

    Parameters
    ----------
    path : Path
        Table with a header.
    columns : pair of Wanted
        Coordinates and values.
    names : pair of str or None, or callable
        Their headings, None for those of the first two columns; or a function that returns their
        positions.
    place : Place
        Of the file in the calibration file.
    most : int
        Largest number of points.
    with_spread : bool
        Read standard errors as well, where columns tell them.
    """
    try:
        table = read_table(path, largest=LARGEST_CURVE, content=_POINTS)
        points = _points(table, columns, names, most, with_spread)
    except InputError as error:
        note_at(place, path, error.faults)
        return None
    place.findings.tables.append(points.understood)
    return points


def note_at(place: Place, path: Path, faults: Sequence[Fault]) -> None:
    """Note faults of a table at its place in the calibration file."""
    for fault in faults:
        where = f", {fault.key}" if fault.key else ""
        place.refuse(replace(fault, message=f"{path.name}{where} {fault.message}"))


def _points(
    table: Table,
    columns: tuple[Wanted, Wanted],
    names: tuple[str | None, str | None] | Locate,
    most: int,
    with_spread: bool,
) -> Points:
    require_headings(table)
    faults, source = TableFaults(), str(table.path)
    x, y = positions = _positions(table, names, faults)
    faults.require_none(source)
    spread = columns_of_spread(table.headings, positions, columns[1]) if with_spread else None
    wanted = {x: columns[0], y: columns[1], **(spread.wanted if spread else {})}
    reading = Reading(table, wanted, faults)
    faults.require_none(source)
    if not 2 <= len(table.rows) <= most:
        raise InputError(_wrong_count(table, most), source)
    rows = reading.rows()
    read = [{at: reading.number(row, at) for at in wanted} for row in rows]
    errors = spread.standard_errors(read, reading, rows) if spread else []
    faults.require_none(source)
    # Without a fault, every cell has a number.
    numbers = [(one[x] or 0.0, one[y] or 0.0) for one in read]
    order = sorted(range(len(rows)), key=lambda i: numbers[i][0])
    points = Points(
        table.headings[x].text,
        tuple(numbers[i][0] for i in order),
        tuple(numbers[i][1] for i in order),
        tuple(rows[i].line for i in order),
        tuple(order),
        tuple(errors[i] for i in order if errors),
        reading.units[y],
        columns[1].scale(reading.units[y]),
        reading.describe(),
    )
    _note_repeated(points, table.headings[x].label, faults)
    faults.require_none(source)
    return points


def _positions(
    table: Table, names: tuple[str | None, str | None] | Locate, faults: TableFaults
) -> tuple[int, int]:
    """Return the positions of both columns; the faults say if they are of no use."""
    if callable(names):
        return names(table.headings)
    found = [
        at if name is None else find_column(table, name, faults) for at, name in enumerate(names)
    ]
    kinds = [kind_of_spread(heading) for heading in table.headings]
    if names[1] is None and kinds[1] and not all(kinds[2:]):
        where = f"line {table.line}, column {table.headings[1].label}"
        faults.note(messages.NO_VALUES.fault(where, why=kinds[1]))
    x, y = (at or 0 for at in found)
    if x == y and None not in found:
        where = f"line {table.line}, column {table.headings[x].label}"
        faults.note(messages.BOTH_X_AND_Y.fault(where))
    return x, y


def _wrong_count(table: Table, most: int) -> Fault:
    line = table.rows[-1].line if table.rows else table.line
    return messages.NUMBER_OF_POINTS.fault(f"line {line}", count=len(table.rows), most=most)


def _note_repeated(points: Points, label: str, faults: TableFaults) -> None:
    neighbours = pairwise(zip(points.coordinates, points.lines, strict=True))
    for (low, first), (high, second) in neighbours:
        if low == high:
            where = f"line {second}, column {label}"
            faults.note(messages.SAME_COORDINATE.fault(where, label=label, first=first, value=low))


def read_covariance(
    path: Path, points: Points, scale: float, place: Place
) -> list[list[float]] | None:
    """Read the covariance of the errors of a curve; None after noting every fault at a place.

    Parameters
    ----------
    path : Path
        Table without a header, its rows and columns in the order of the lines of the curve.
    points : Points
        Points of the curve.
    scale : float
        Factor to the square of the unit of the values.
    place : Place
        Of the file in the calibration file.
    """
    try:
        table = read_table(path, largest=LARGEST_CURVE, content=_MATRIX, has_header=False)
        matrix = _matrix(table, len(points.values))
    except InputError as error:
        note_at(place, path, error.faults)
        return None
    size = len(matrix)
    place.findings.tables.append(
        f"{path.name}: separator {table.separator_shown}, {size} rows of {size} numbers"
    )
    return [[scale * matrix[i][j] for j in points.order] for i in points.order]


def _matrix(table: Table, count: int) -> list[list[float]]:
    faults = TableFaults()
    if len(table.rows) != count:
        where, rows = f"line {table.rows[-1].line}", len(table.rows)
        faults.note(messages.ROWS_OF_COVARIANCE.fault(where, rows=rows, count=count))
    mark = decimal_mark(cell for row in table.rows for cell in row.cells)
    matrix = []
    for row in table.rows:
        if len(row.cells) != count:
            where = f"line {row.line}, column {len(row.cells)}"
            fault = messages.CELLS_OF_COVARIANCE.fault(where, cells=len(row.cells), count=count)
            faults.note(fault)
            continue
        matrix.append(
            [
                _element(at, text, row.line, mark, faults)
                for at, text in enumerate(row.cells, start=1)
            ]
        )
    faults.require_none(str(table.path))
    return matrix


def _element(at: int, text: str, line: int, mark: str, faults: TableFaults) -> float:
    where = f"line {line}, column {at}"
    number = parse_number(text, mark, where)
    if isinstance(number, Fault):
        faults.note(number)
    elif not math.isfinite(number):
        faults.note(messages.NOT_FINITE.fault(where, number=number))
    else:
        return number
    return math.nan


@dataclass(frozen=True)
class Spread:
    """Columns from which the standard errors of the values follow.

    Parameters
    ----------
    wanted : mapping of int to Wanted
        The columns by their positions.
    error, deviation, count : int, optional
        Position of the standard error; or else of the standard deviation, and of the number of
        measurements.
    """

    wanted: Mapping[int, Wanted]
    error: int | None = None
    deviation: int | None = None
    count: int | None = None

    def standard_errors(
        self, read: Sequence[Mapping[int, float | None]], reading: Reading, rows: Sequence[Row]
    ) -> list[float]:
        """Return the standard error of each row; note the numbers that give none.

        One from a deviation has Student's factor for few measurements.
        """
        if self.error is not None:
            return [row[self.error] or 0.0 for row in read]
        assert self.deviation is not None
        assert self.count is not None
        label = reading.table.headings[self.count].label
        errors = []
        for numbers, row in zip(read, rows, strict=True):
            deviation, count = numbers[self.deviation], numbers[self.count]
            if count is not None and (count < 2 or count != int(count)):
                where = f"line {row.line}, column {label}"
                reading.faults.note(messages.NO_COUNT.fault(where, count=count))
            elif deviation is not None and count is not None:
                errors.append(student_factor(int(count)) * deviation / math.sqrt(count))
        return errors


def kind_of_spread(heading: Heading) -> str:
    """Return which number on a mean a column has, by its heading; "" for none."""
    if _ERROR.search(heading.name):
        return "a standard error"
    if _DEVIATION.search(heading.name):
        return "a standard deviation"
    return "a number of measurements" if _COUNT.fullmatch(heading.name) else ""


def columns_of_spread(
    headings: Sequence[Heading], points: tuple[int, int], values: Wanted
) -> Spread | None:
    """Return the columns with the spread of the values; None where they do not tell it.

    That is one column with the standard error; or one with the standard deviation and one with the
    number of measurements.
    """
    kinds: dict[str, list[int]] = {}
    for heading in headings:
        if heading.position not in points:
            kinds.setdefault(kind_of_spread(heading), []).append(heading.position)
    least = Quantity(values.quantity.unit, lowest=0.0)
    size = replace(values, quantity=least, needs_unit=False)
    number = Wanted(Quantity(""))
    errors, deviations, counts = (
        kinds.get(kind, [])
        for kind in ("a standard error", "a standard deviation", "a number of measurements")
    )
    value = headings[points[1]]
    if len(errors) == 1:
        of_error = _in_unit_of(value, headings[errors[0]], size)
        return Spread({errors[0]: of_error}, error=errors[0])
    if len(deviations) == len(counts) == 1:
        of_deviation = _in_unit_of(value, headings[deviations[0]], size)
        wanted = {deviations[0]: of_deviation, counts[0]: number}
        return Spread(wanted, deviation=deviations[0], count=counts[0])
    return None


def _in_unit_of(values: Heading, spread: Heading, wanted: Wanted) -> Wanted:
    """Return a column of the spread, in the unit of the values unless it states one."""
    if spread.states_unit and wanted.unit:
        return replace(wanted, given=None)
    if wanted.given is not None:
        return wanted
    stated = values.unit if values.states_unit else None
    return replace(wanted, given="" if stated in (*WITHOUT_UNIT, wanted.unit) else stated or "")
