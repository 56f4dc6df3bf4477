"""Material parameters in the calibration file: fixed or free, and particle sizes."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from grainfit.calibration_file import messages
from grainfit.calibration_file.photographed import PHOTOS
from grainfit.calibration_file.photographed_repeats import SLOPE_KEYS, slope_in
from grainfit.errors import InputError
from grainfit.materials.parameters import MaterialParameter
from grainfit.materials.wall_friction import MEASURED_BY_ANGLE, STEEPEST, friction_of_angle
from grainfit.materials.walls import plain_name
from grainfit.options.kinds import Choice, Kind, Quantity, Schema, Text
from grainfit.options.places import Place, show
from grainfit.options.tables import Key, Table, Values
from grainfit.problem import Parameter
from grainfit.problem import messages as of_problem
from grainfit.units import is_unit

_SCALE = Key(
    "scale",
    Choice(("linear", "log")),
    'Of the design: "log" for a parameter that spans orders of magnitude.',
)
# None of these can be part of a quantity, and all of them are ways to write an interval.
_INTERVAL_SIGNS = re.compile(r"\.\.|…|–|—|±|\+/?-|\bto\b|\s-\s|[;\[{]|,\s")


def _interval_keys(quantity: Quantity) -> tuple[Key, ...]:
    return (
        Key("min", quantity, "Lower bound.", required=True),
        Key("max", quantity, "Upper bound.", required=True),
        _SCALE,
    )


def is_value(table: dict[str, Any]) -> bool:
    """Return whether a table is the value of a parameter: an interval, an angle, pictures of it."""
    keys = (*_interval_keys(Quantity(None)), *_ANGLE.keys, *SLOPE_KEYS)
    return any(key.name in table for key in keys)


def _note_value_in_table(table: dict[str, Any], place: Place, example: str) -> bool:
    """Return whether a parameter is written as targets are, and note it."""
    if "value" not in table:
        return False
    place.at("value").fault(messages.FIXED_IN_TABLE, key=place.key, example=example)
    return True


def _note_bad_bounds(values: Values, place: Place) -> bool:
    low, high = values.get("min"), values.get("max")
    if low is None or high is None:
        return True
    if low >= high:
        word = "equal" if low == high else "swapped"
        place.fault(of_problem.BOUNDS_NOT_IN_ORDER, order=word, low=low, high=high)
        return True
    if values.get("scale") == "log" and low <= 0:
        place.at("min").fault(of_problem.NOT_POSITIVE_ON_LOG_SCALE, low=low)
        return True
    return "scale" in values and values["scale"] is None


def _parameter(name: str, unit: str, values: Values, place: Place) -> Parameter | None:
    """Return a free parameter; None after noting faults of its interval."""
    if _note_bad_bounds(values, place):
        return None
    try:
        return Parameter(name, values["min"], values["max"], values.get("scale", "linear"), unit)
    except InputError as error:
        place.note(error, values, place)
        return None


@dataclass(frozen=True)
class MeasuredAngle:
    """Friction on a wall that was measured as an angle of an inclined plane.

    Parameters
    ----------
    name : str
        Of the parameter.
    angle : float
        At which sliding or rolling begins, degrees.
    uncertainty : float, optional
        Its standard uncertainty, degrees; without it, the parameter is fixed.
    """

    name: str
    angle: float
    uncertainty: float | None = None

    @property
    def value(self) -> float | Parameter:
        """Tangent of the angle; with an uncertainty, a free parameter about it."""
        if self.uncertainty is None:
            return friction_of_angle(self.angle)
        return Parameter.from_angle(self.name, self.angle, self.uncertainty)

    def __str__(self) -> str:
        friction = f"{friction_of_angle(self.angle):.4g}"
        words = f"{self.name} is {friction}, the tangent of the measured angle of {self.angle:g}°"
        if self.uncertainty is None:
            return f"{words}."
        free = Parameter.from_angle(self.name, self.angle, self.uncertainty)
        return (
            f"{words}, with a standard uncertainty of {free.uncertainty:.2g} ({self.uncertainty:g}°"
            ") that is part of all intervals."
        )


_ANGLE = Table(
    (
        Key(
            "measured_angle",
            Quantity("deg", highest=STEEPEST, above_zero=True),
            "Angle of an inclined plane of the wall's material at which sliding (of particles, or "
            "of the bulk solid) or rolling (of a single particle) begins: the parameter is its "
            "tangent.",
            required=True,
            example='"21.8 deg"',
        ),
        Key(
            "uncertainty",
            Quantity("deg", highest=STEEPEST, above_zero=True),
            "Standard uncertainty of the angle. With it, the parameter is free about its value, "
            "and all intervals contain the uncertainty.",
            example='"0.5 deg"',
            default="none: the parameter is fixed, which takes no run",
        ),
    )
)
_SLOPE = Table(SLOPE_KEYS, slope_in)


def _has(value: Any, key: str) -> bool:
    return isinstance(value, dict) and key in value


@dataclass(frozen=True)
class FixedOrFree(Kind):
    """A material parameter: a quantity when fixed, an interval when free.

    Friction on walls may be an angle that was measured, too.
    """

    parameter: MaterialParameter

    @property
    def _is_angle(self) -> bool:
        return plain_name(self.parameter.name) in MEASURED_BY_ANGLE

    @property
    def _quantity(self) -> Quantity:
        return self.parameter.possible

    @property
    def _interval(self) -> Table:
        return Table(_interval_keys(self._quantity), self._free)

    def _free(self, values: Values, place: Place) -> Parameter | None:
        return _parameter(self.parameter.name, self.parameter.unit, values, place)

    def _measured(self, value: dict[str, Any], place: Place) -> MeasuredAngle | None:
        if PHOTOS in value:
            found = _SLOPE.read(value, place)
            return None if found is None else MeasuredAngle(self.parameter.name, *found)
        read = _ANGLE.read(value, place)
        if read.get("measured_angle") is None or None in read.values():
            return None
        return MeasuredAngle(self.parameter.name, read["measured_angle"], read.get("uncertainty"))

    def read(self, value: Any, place: Place) -> float | Parameter | MeasuredAngle | None:
        """Read a fixed value, in SI, the interval of a free parameter, or a measured angle."""
        by_angle = [key for key in ("measured_angle", PHOTOS) if _has(value, key)]
        if by_angle:
            if self._is_angle:
                return self._measured(value, place)
            names = " and ".join(MEASURED_BY_ANGLE)
            place.at(by_angle[0]).fault(messages.NO_TANGENT, known=names)
            return None
        if isinstance(value, dict):
            if _note_value_in_table(value, place, self.parameter.example):
                return None
            free: Parameter | None = self._interval.read(value, place)
            return free
        if isinstance(value, list) or (isinstance(value, str) and _INTERVAL_SIGNS.search(value)):
            place.fault(messages.NO_INTERVAL, given=show(value))
            return None
        return self._quantity.read(value, place)

    def schema(self) -> Schema:
        """Return the JSON Schema of both forms."""
        angle = [_ANGLE.schema(), _SLOPE.schema()] if self._is_angle else []
        return {"anyOf": [*self._quantity.schema()["anyOf"], self._interval.schema(), *angle]}


@dataclass(frozen=True)
class OwnParameter(Kind):
    """A parameter of the user's own model, of any name: a number, or an interval when free."""

    def _interval(self, quantity: Quantity) -> Table:
        unit = Key("unit", Text(), "Unit that the model takes the parameter in, for example J/m^3.")
        return Table((*_interval_keys(quantity), unit), self._free)

    @staticmethod
    def _free(values: Values, place: Place) -> Parameter | None:
        return _parameter(place.key, values.get("unit") or "", values, place)

    def read(self, value: Any, place: Place) -> float | Parameter | None:
        """Read a fixed number or the interval of a free parameter."""
        if isinstance(value, dict):
            if _note_value_in_table(value, place, "4"):
                return None
            free: Parameter | None = self._interval(own_quantity(value)).read(value, place)
            return free
        return Quantity(None).read(value, place)

    def schema(self) -> Schema:
        """Return the JSON Schema of both forms."""
        return {"anyOf": [{"type": "number"}, self._interval(Quantity(None)).schema()]}


def own_quantity(table: dict[str, Any]) -> Quantity:
    """Return the quantity that a table of the user's own model holds, by its key ``unit``."""
    unit = table.get("unit")
    known = isinstance(unit, str) and is_unit(unit)
    return Quantity(unit if known else None)
