"""Measured curves in the calibration file: points in a CSV file, and their uncertainty."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from grainfit.calibration_file.targets import Deviation, TargetTable
from grainfit.errors import InputError
from grainfit.options.kinds import Kind, Quantity, Schema, Text, note_wrong_kind
from grainfit.options.paths import Located
from grainfit.options.places import Place, show
from grainfit.options.tables import Key, Table, Values
from grainfit.problem import Target
from grainfit.problem.curve_target import MOST_POINTS, CurveTarget
from grainfit.table_files.curve_points import Points, read_covariance, read_points
from grainfit.table_files.reading import Wanted
from grainfit.units import UnitError, how_to_write, is_unit, to_si, to_unit

#: Key that makes a target a curve.
CURVE = "curve"
#: A curve as a calibration file gives it.
CURVE_EXAMPLE = '{ curve = "curve.csv", uncertainty = "2 %", common_uncertainty = "2 %" }'

_ERRORS = ("uncertainty", "common_uncertainty")


@dataclass(frozen=True)
class CurveTable(Kind):
    """The target of one response that is a curve.

    Parameters
    ----------
    unit, coordinate_unit : str or None
        SI units of values and coordinates; None when only the user's own model knows.
    coordinate : str
        Name of the coordinate.
    """

    unit: str | None = None
    coordinate_unit: str | None = None
    coordinate: str = ""

    def read(self, value: Any, place: Place) -> CurveTarget | None:
        """Read the options of a curve, and its points from the CSV file."""
        if not isinstance(value, dict):
            note_wrong_kind(value, place, "a table", f"Write {place.key} = {CURVE_EXAMPLE}.")
            return None
        known = self
        if self.unit is None:
            units = (
                _own_unit(value, "unit", "y_unit"),
                _own_unit(value, "coordinate_unit", "x_unit"),
            )
            known = replace(self, unit=units[0], coordinate_unit=units[1])
        plain = {key: value[key] for key in _ERRORS if _is_plain(value.get(key))}
        written = value.get("y_unit")
        if isinstance(written, str) and written != known.unit:
            _note_unclear_errors(plain, f"y_unit is {show(written)}", written, place)
            plain = {}
        if "tolerance" in value:
            remedy = "What is accepted follows from the uncertainties: remove it."
            place.at("tolerance").fault("is not a known key of a curve.", remedy)
            value = {key: given for key, given in value.items() if key != "tolerance"}
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
        x = self._column(values, "x", self.coordinate_unit, place)
        y = self._column(values, "y", self.unit, place)
        path = values.get(CURVE)
        says_errors = "uncertainty" in values or "covariance" in values
        points = None
        if path is not None and x is not None and y is not None:
            names = (values.get("x"), values.get("y"))
            points = read_points(
                path, (x, y), names, place.at(CURVE), most=MOST_POINTS, with_spread=not says_errors
            )
        if points is None or not points.standard_errors:
            _note_missing_errors(values, place)
        if points is None or None in values.values():
            return None
        if points.unit and plain:
            _note_unclear_errors(
                plain, f"the values are in {show(points.unit)}", points.unit, place
            )
        errors = _errors(values, points, self.unit or "", place)
        if errors is None:
            return None
        try:
            return CurveTarget(
                place.key,
                points.coordinates,
                points.values,
                **errors,
                unit=self.unit or values.get("unit", ""),
                coordinate_unit=self.coordinate_unit or values.get("coordinate_unit", ""),
                coordinate=self.coordinate or points.coordinate,
            )
        except InputError as error:
            place.note(error, values, place.at(CURVE))
            return None

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
        # Only where the unit of the model is known, the heading can state another one.
        is_fixed = written or unit is None
        return Wanted(
            Quantity(unit), key, given=given if is_fixed else None, unit_key=f"{key}_unit"
        )

    def schema(self) -> Schema:
        """Return the JSON Schema of the curve's table."""
        schema = Table(self._keys(is_own=self.unit is None)).schema()
        # Columns of the file may have the uncertainty.
        schema["not"] = {"required": ["uncertainty", "covariance"]}
        return schema


@dataclass(frozen=True)
class RefusedCurve(Kind):
    """A curve where only single numbers can be targets.

    Parameters
    ----------
    message, remedy : str
        The reason, and what to do.
    """

    message: str
    remedy: str

    def read(self, value: Any, place: Place) -> None:  # noqa: ARG002
        """Refuse the curve."""
        place.fault(self.message, self.remedy)

    def schema(self) -> Schema:
        """Return the JSON Schema that nothing satisfies."""
        return {"not": {}}


PLANNED_CURVE = RefusedCurve(
    "is a curve, and tests are compared by single responses only.",
    "Leave it out of the file from which tests are chosen.",
)
CURVE_OF_TABLE = RefusedCurve(
    "is a curve, and a recorded table holds single numbers only.",
    "Give a value that a column of the table can be compared with.",
)


@dataclass(frozen=True)
class OwnTarget(Kind):
    """The target of a response of the user's own model: one number, or a curve.

    Parameters
    ----------
    number : TargetTable
        Kind of a target that is one number.
    curve : CurveTable or RefusedCurve
        Kind of a target with the key ``curve``.
    """

    number: TargetTable
    curve: CurveTable | RefusedCurve

    def read(self, value: Any, place: Place) -> Target | CurveTarget | None:
        """Read a curve if the table has the key ``curve``, or else one number."""
        kind = self.curve if isinstance(value, dict) and CURVE in value else self.number
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
            required=True,
            example='"curve.csv"',
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
            "common_uncertainty",
            deviation,
            "Standard uncertainty that all points share: they are all too high, or all too low.",
            default="none",
            example='"2 %"',
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


def _own_unit(value: dict[str, Any], key: str, of_column: str) -> str | None:
    """Return the unit in which the user's own model yields numbers; None if nothing says it."""
    named, written = value.get(key), value.get(of_column)
    if named is not None:
        return named if isinstance(named, str) and is_unit(named) else None
    if not isinstance(written, str):
        return None
    try:
        return to_si(f"1 {written}")[1]
    except UnitError:
        return None


def _converts(written: str, unit: str | None, own: str | None, place: Place, key: str) -> bool:
    """Return whether a column can be converted; note it when it cannot."""
    at = place.at(f"{key}_unit")
    if unit is None and own and is_unit(written):
        of_model = "unit" if key == "y" else "coordinate_unit"
        at.fault(
            f"is {show(written)}, which cannot be converted to {of_model} = {show(own)}.",
            "Name a unit of the same dimension there, or convert the column.",
        )
        return False
    try:
        # Without a unit to convert to, the text is no unit: this says so.
        to_unit(f"1 {written}", "m" if unit is None else unit)
    except UnitError as error:
        at.fault(error.message, error.remedy if unit is not None else how_to_write("Pa"))
        return False
    return True


def _note_missing_errors(values: Values, place: Place) -> None:
    if "covariance" in values:
        # A covariance that cannot be read may be another key, misspelt.
        for key in _ERRORS if values["covariance"] is not None else ():
            if key in values:
                place.at(key).fault(
                    "is given beside covariance.", f"The covariance says it: remove {key}."
                )
    elif "uncertainty" not in values:
        place.at("uncertainty").fault(
            "is missing.",
            'Give the standard uncertainty of the values, such as "2 %", or a covariance; or give '
            "the file a column with the standard error, or two with the standard deviation and the "
            "number of measurements.",
        )


def _is_plain(given: Any) -> bool:
    return isinstance(given, (int, float)) and not isinstance(given, bool)


def _note_unclear_errors(plain: Mapping[str, float], why: str, unit: str, place: Place) -> None:
    """Note plain numbers that may be in the unit of the file, or in that of the response."""
    for key, given in plain.items():
        place.at(key).fault(
            f"is {show(given)}, and {why}: its unit is not clear.",
            f'Write it with its unit, such as "{given:g} {unit[:20]}".',
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
    found = {key: _error(*values[key]) for key in _ERRORS if key in values}
    if points.standard_errors:
        return {**found, "uncertainty": points.standard_errors}
    if "uncertainty" not in values:
        return None
    number, is_share = values["uncertainty"]
    zeros = [line for line, v in zip(points.lines, points.values, strict=True) if v == 0]
    if is_share and zeros:
        place.at("uncertainty").fault(
            f"is {100 * number:g} %, and the value in line {zeros[0]} of {values[CURVE].name} "
            "is 0.",
            f"Give an absolute one{_such_as(unit)}, or leave the point out.",
        )
        return None
    return found


def _error(number: float, is_share: bool) -> float | str:
    """Return an uncertainty as the target takes it: its percentages are not of measured values."""
    return f"{100 * number:.15g} %" if is_share else number


def _such_as(unit: str) -> str:
    return f', such as "1 {unit}"' if unit else ", without %"
