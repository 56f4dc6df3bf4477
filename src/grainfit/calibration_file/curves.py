"""Measured curves in the calibration file: points in a CSV file, and their uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from grainfit.bulk_tests.response_info import CurveInfo
from grainfit.calibration_file import messages
from grainfit.calibration_file.targets import Deviation, TargetTable
from grainfit.errors import Fault, InputError
from grainfit.files import LARGEST_CURVE
from grainfit.messages import Message
from grainfit.options.kinds import Kind, ListOf, Quantity, Schema, Text, note_wrong_kind
from grainfit.options.paths import Located
from grainfit.options.places import Place, show
from grainfit.options.tables import Key, Table, Values
from grainfit.problem import Target
from grainfit.problem.curve_target import MOST_POINTS, CurveTarget
from grainfit.table_files.curve_points import Points, note_at, read_covariance, read_points
from grainfit.table_files.reading import Wanted, column_of
from grainfit.table_files.table import Table as HeadedTable
from grainfit.table_files.table import read_table
from grainfit.units import UnitError, how_to_write, is_unit, to_si, to_unit

#: Key that makes a target a curve.
CURVE = "curve"
#: Key of several tables of one curve.
MEASUREMENTS = "measurements"
#: A curve as a calibration file gives it.
CURVE_EXAMPLE = '{ curve = "curve.csv", uncertainty = "2 %", systematic = "2 %" }'

_ERRORS = ("uncertainty", "systematic")
_WIDTHS = (*_ERRORS, "tolerance")
#: Name of `systematic` in version 0.2.0.
_FORMER = "common_uncertainty"
#: Endings of tables, by which a list of measurements is one of curves.
_TABLES = (".csv", ".tsv", ".txt", ".dat")


@dataclass(frozen=True)
class CurveTable(Kind):
    """The target of one response that is a curve.

    Parameters
    ----------
    unit, coordinate_unit : str or None
        SI units of values and coordinates; None when only the user's own model knows.
    coordinate : str
        Name of the coordinate.
    info : CurveInfo, optional
        What is physically possible; None when only the user's own model knows.
    """

    unit: str | None = None
    coordinate_unit: str | None = None
    coordinate: str = ""
    info: CurveInfo | None = None

    def read(self, value: Any, place: Place) -> CurveTarget | None:
        """Read the options of a curve, and its points from the CSV file."""
        if not isinstance(value, dict):
            note_wrong_kind(value, place, "a table", f"Write {place.key} = {CURVE_EXAMPLE}.")
            return None
        known = self
        if self.unit is None:
            tables = _readable_tables(value, place.findings.folder)
            units = (
                _own_unit(value, "unit", "y", tables),
                _own_unit(value, "coordinate_unit", "x", tables),
            )
            known = replace(self, unit=units[0], coordinate_unit=units[1])
        plain = {key: value[key] for key in _WIDTHS if _is_plain(value.get(key))}
        written = value.get("y_unit")
        if isinstance(written, str) and written != known.unit:
            _note_unclear_errors(plain, f"y_unit is {show(written)}", written, place)
            plain = {}
        if _FORMER in value:
            place.at(_FORMER).fault(messages.RENAMED_TO_SYSTEMATIC)
            value = {key: given for key, given in value.items() if key != _FORMER}
        keys = known._keys(is_own=self.unit is None)
        target: CurveTarget | None = Table(keys, partial(known._target, plain=plain)).read(
            value, place
        )
        return target

    def _keys(self, *, is_own: bool) -> tuple[Key, ...]:
        keys = _curve_keys(self.unit)
        return (*keys, *_OWN_UNITS) if is_own else keys

    def _target(
        self, values: Values, place: Place, plain: Mapping[str, float] | None = None
    ) -> CurveTarget | None:
        """Return the curve; ``plain`` are the uncertainties that have no unit."""
        is_repeated = _is_repeated(values, place)
        tables = self._tables(values, place)
        if not is_repeated and (tables is None or not tables[0].standard_errors):
            _note_missing_errors(values, place)
        if tables is None or None in values.values():
            return None
        for unit in {points.unit for points in tables if points.unit and plain}:
            _note_unclear_errors(plain or {}, f"the values are in {show(unit)}", unit, place)
        known: dict[str, Any] = {
            "unit": self.unit or values.get("unit", ""),
            "coordinate_unit": self.coordinate_unit or values.get("coordinate_unit", ""),
            "coordinate": self.coordinate or tables[0].coordinate,
        }
        known |= _given(values, "tolerance")
        try:
            return _repeated(values, tables, known, place) or self._single(
                values, tables[0], known, place
            )
        except InputError as error:
            place.note(error, values, place.at(MEASUREMENTS if is_repeated else CURVE))
            return None

    def _single(
        self, values: Values, points: Points, known: Mapping[str, Any], place: Place
    ) -> CurveTarget | None:
        """Return the curve of one table; None after noting faults of its uncertainties."""
        errors = _errors(values, points, self.unit or "", place)
        if errors is None:
            return None
        return CurveTarget(place.key, points.coordinates, points.values, **errors, **known)

    def _tables(self, values: Values, place: Place) -> list[Points] | None:
        """Read the points of all tables; None after noting faults."""
        x = self._column(values, "x", self.coordinate_unit, place)
        y = self._column(values, "y", self.unit, place)
        repeats, path = values.get(MEASUREMENTS), values.get(CURVE)
        at = place.at(MEASUREMENTS)
        places = {p: at.at(i) for i, p in enumerate(repeats or ())} or {path: place.at(CURVE)}
        if None in places or x is None or y is None:
            return None
        tells_spread = not repeats and not values.keys() & {"uncertainty", "covariance"}
        names = (values.get("x"), values.get("y"))
        found = [
            read_points(one, (x, y), names, there, most=MOST_POINTS, with_spread=tells_spread)
            for one, there in places.items()
        ]
        good = [
            points
            for points, (path, there) in zip(found, places.items(), strict=True)
            if points is not None and self._is_possible(points, path, there)
        ]
        return good if len(good) == len(found) else None

    def _is_possible(self, points: Points, path: Path, place: Place) -> bool:
        """Return whether all values are physically possible; note the first that is not."""
        found = None if self.info is None else self.info.impossible_point(points.values)
        if found is None:
            return True
        position, fault = found
        note_at(place, path, [replace(fault, key=f"line {points.lines[position]}")])
        return False

    def _column(self, values: Values, key: str, unit: str | None, place: Place) -> Wanted | None:
        """Return a column and its units; None after noting a unit that cannot be converted."""
        if key in values and values[key] is None:
            return None
        written = values.get(f"{key}_unit", "")
        own = values.get("unit" if key == "y" else "coordinate_unit")
        if written is None:
            return None
        if written and written != (own or unit) and not _converts(written, unit, own, place, key):
            return None
        given = "" if written == (own or unit) else written
        # Without a unit to convert to, no heading states one that can be converted.
        is_fixed = written or unit is None
        return Wanted(
            Quantity(unit), key, given=given if is_fixed else None, unit_key=f"{key}_unit"
        )

    def schema(self) -> Schema:
        """Return the JSON Schema of the curve's table."""
        schema = Table(self._keys(is_own=self.unit is None)).schema()
        # Columns of the file may have the uncertainty.
        schema["not"] = {"required": ["uncertainty", "covariance"]}
        schema["oneOf"] = [{"required": [key]} for key in (CURVE, MEASUREMENTS)]
        return schema


@dataclass(frozen=True)
class RefusedCurve(Kind):
    """A curve where only single numbers can be targets.

    Parameters
    ----------
    message : Message
        The reason, and what to do.
    """

    message: Message

    def read(self, value: Any, place: Place) -> None:  # noqa: ARG002
        """Refuse the curve."""
        place.fault(self.message)

    def schema(self) -> Schema:
        """Return the JSON Schema that nothing satisfies."""
        return {"not": {}}


PLANNED_CURVE = RefusedCurve(messages.PLANNED_CURVE)
CURVE_OF_TABLE = RefusedCurve(messages.CURVE_OF_TABLE)


@dataclass(frozen=True)
class OwnTarget(Kind):
    """The target of a response of the user's own model: one number, or a curve.

    Parameters
    ----------
    number : TargetTable
        Kind of a target that is one number.
    curve : CurveTable or RefusedCurve
        Kind of a target with the key ``curve``, or with tables as measurements.
    """

    number: TargetTable
    curve: CurveTable | RefusedCurve

    def read(self, value: Any, place: Place) -> Target | CurveTarget | None:
        """Read a curve if tables are named, or else one number."""
        kind = self.curve if _names_tables(value) else self.number
        target: Target | CurveTarget | None = kind.read(value, place)
        return target

    def schema(self) -> Schema:
        """Return the JSON Schema of both forms."""
        if isinstance(self.curve, RefusedCurve):
            return self.number.schema()
        return {"oneOf": [self.number.schema(), self.curve.schema()]}


_OWN_UNITS = (
    Key(
        "unit",
        Text(),
        "Unit of the response as your model yields it; SI by default.",
    ),
    Key(
        "coordinate_unit",
        Text(),
        "Unit of the coordinates as your model yields them; SI by default.",
    ),
)


def _curve_keys(unit: str | None) -> tuple[Key, ...]:
    deviation = Deviation(unit)
    return (
        Key(
            CURVE,
            Located(),
            "Table with the measured curve: a header, and one line for each point.",
            example='"curve.csv"',
        ),
        Key(
            MEASUREMENTS,
            ListOf(Located(), shortest=2),
            "Instead of curve and uncertainty: tables of the same curve, measured at least twice. "
            "Their mean is the curve; its uncertainty follows from their differences, with "
            "Student's factor for few, together with the systematic part.",
            example='["first.csv", "second.csv", "third.csv"]',
        ),
        Key("x", Text(), "Column of the coordinates.", default="the first one"),
        Key("y", Text(), "Column of the values.", default="the second one"),
        Key(
            "x_unit",
            Text(),
            "Unit of that column; that of its heading, or SI, by default.",
            example='"%"',
        ),
        Key(
            "y_unit",
            Text(),
            "Unit of that column; that of its heading, or SI, by default.",
            example='"kPa"',
        ),
        Key(
            "uncertainty",
            deviation,
            "Standard uncertainty of the values that is independent from point to point; "
            '"2 %" is a share of each value. Columns of the file may have it instead: a standard '
            "error, or a standard deviation and the number of measurements.",
            example='"2 %"',
        ),
        Key(
            "systematic",
            deviation,
            "Standard uncertainty that all points share: they are all too high, or all too low.",
            default="none",
            example='"2 %"',
        ),
        Key(
            "tolerance",
            deviation,
            "Largest accepted deviation of the calibrated curve at each point: what is good "
            'enough. "5 %" is a share of each value, and of a tenth of the largest where values '
            "are smaller.",
            default="two standard uncertainties, as the method has it",
            example='"5 %"',
        ),
        Key(
            "covariance",
            Located(),
            "Instead of both uncertainties: CSV file with the covariance of the values, a row and "
            "a column for each point in the order of the curve's file, no header, in the square "
            "of the unit of the column.",
            example='"covariance.csv"',
        ),
    )


def _names_tables(value: Any) -> bool:
    """Return whether a target is given by tables, and so is a curve."""
    if not isinstance(value, dict):
        return False
    listed = value.get(MEASUREMENTS)
    texts = [one for one in listed if isinstance(one, str)] if isinstance(listed, list) else []
    return CURVE in value or any(one.lower().endswith(_TABLES) for one in texts)


def _is_repeated(values: Values, place: Place) -> bool:
    """Return whether there are several tables; note what does not go with them."""
    if MEASUREMENTS not in values:
        if CURVE not in values:
            place.at(CURVE).fault(messages.NO_CURVE)
        return False
    for key in (CURVE, "uncertainty", "covariance"):
        if key in values:
            place.at(key).fault(messages.BESIDE_MEASURED_CURVES, key=key)
            values[key] = None
    return True


def _repeated(
    values: Values, tables: Sequence[Points], known: Mapping[str, Any], place: Place
) -> CurveTarget | None:
    """Return the curve of several tables; None where there is one."""
    if MEASUREMENTS not in values:
        return None
    curves = [(points.coordinates, points.values) for points in tables]
    return CurveTarget.of_measurements(place.key, curves, **_given(values, "systematic"), **known)


def _own_unit(
    value: dict[str, Any], key: str, column: str, tables: Sequence[HeadedTable]
) -> str | None:
    """Return the unit in which the user's own model yields numbers; None if nothing says it."""
    named, written = value.get(key), value.get(f"{column}_unit")
    if named is not None:
        return named if isinstance(named, str) and is_unit(named) else None
    if written is None:
        written = _stated_unit(value.get(column, "xy".index(column)), tables)
    if not isinstance(written, str):
        return None
    try:
        return to_si(f"1 {written}")[1]
    except UnitError:
        return None


def _readable_tables(value: dict[str, Any], folder: Path) -> list[HeadedTable]:
    """Return the tables of a curve, without those that cannot be read."""
    listed = value.get(MEASUREMENTS)
    names = [value.get(CURVE), *(listed if isinstance(listed, list) else ())]
    found = []
    for name in names:
        with suppress(InputError):
            if isinstance(name, str):
                found.append(read_table(folder / name, largest=LARGEST_CURVE))
    return found


def _stated_unit(column: Any, tables: Sequence[HeadedTable]) -> str | None:
    """Return the unit that a heading states for a column, by its name or position."""
    for table in tables:
        at = column_of(table, column) if isinstance(column, str) else column
        for heading in table.headings:
            if heading.position == at and heading.unit and is_unit(heading.unit):
                return heading.unit
    return None


def _converts(written: str, unit: str | None, own: str | None, place: Place, key: str) -> bool:
    """Return whether a column can be converted; note it when it cannot."""
    at = place.at(f"{key}_unit")
    if unit is None and own and is_unit(written):
        of_model = "unit" if key == "y" else "coordinate_unit"
        at.fault(
            messages.UNIT_OF_OWN_MODEL, written=show(written), of_model=of_model, own=show(own)
        )
        return False
    try:
        # Without a unit to convert to, the text is no unit: this says so.
        to_unit(f"1 {written}", "m" if unit is None else unit)
    except UnitError as error:
        remedy = error.remedy if unit is not None else how_to_write("Pa")
        at.refuse(Fault("", error.message, remedy))
        return False
    return True


def _note_missing_errors(values: Values, place: Place) -> None:
    if "covariance" in values:
        # A covariance that cannot be read may be another key, misspelt.
        for key in _ERRORS if values["covariance"] is not None else ():
            if key in values:
                place.at(key).fault(messages.BESIDE_COVARIANCE, key=key)
    elif "uncertainty" not in values:
        place.at("uncertainty").fault(messages.NO_UNCERTAINTY_OF_CURVE)


def _is_plain(given: Any) -> bool:
    return isinstance(given, (int, float)) and not isinstance(given, bool)


def _note_unclear_errors(plain: Mapping[str, float], why: str, unit: str, place: Place) -> None:
    """Note plain numbers that may be in the unit of the file, or in that of the response."""
    for key, given in plain.items():
        place.at(key).fault(
            messages.UNIT_NOT_CLEAR, given=show(given), why=why, value=given, unit=unit[:20]
        )


def _errors(values: Values, points: Points, unit: str, place: Place) -> dict[str, Any] | None:
    """Return the uncertainties as the target takes them; None after noting their faults."""
    if "covariance" in values:
        at = place.at("covariance")
        matrix = read_covariance(values["covariance"], points, points.scale**2, at)
        return (
            None
            if matrix is None or not values.keys().isdisjoint(_ERRORS)
            else {"covariance": matrix}
        )
    found = _given(values, *_ERRORS)
    if points.standard_errors:
        return {**found, "uncertainty": points.standard_errors}
    if "uncertainty" not in values:
        return None
    number, is_share = values["uncertainty"]
    zeros = [line for line, v in zip(points.lines, points.values, strict=True) if v == 0]
    if is_share and zeros:
        place.at("uncertainty").fault(
            messages.SHARE_OF_ZERO_IN_LINE,
            percent=100 * number,
            line=zeros[0],
            file=values[CURVE].name,
            such_as=_such_as(unit),
        )
        return None
    return found


def _given(values: Values, *keys: str) -> dict[str, float | str]:
    """Return those deviations that are given, as the target takes them."""
    return {key: _error(*values[key]) for key in keys if key in values}


def _error(number: float, is_share: bool) -> float | str:
    """Return an uncertainty as the target takes it: its percentages are not of measured values."""
    return f"{100 * number:.15g} %" if is_share else number


def _such_as(unit: str) -> str:
    return f', such as "1 {unit}"' if unit else ", without %"
