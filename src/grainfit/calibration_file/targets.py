"""Targets in the calibration file: laboratory measurements and their uncertainty."""

from __future__ import annotations

import json
import statistics
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_args

from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.calibration_file import messages
from grainfit.calibration_file.content import PlannedTarget
from grainfit.calibration_file.parameters import own_quantity
from grainfit.errors import InputError
from grainfit.formatting import plain
from grainfit.options.kinds import Choice, Kind, ListOf, Quantity, Schema, Text, note_wrong_kind
from grainfit.options.places import Place, show
from grainfit.options.tables import Key, Table, Values
from grainfit.problem import Target
from grainfit.problem.messages import NO_DEFAULT_TOLERANCE, SHARE_OF_ZERO
from grainfit.problem.target import Statistic
from grainfit.units import percentage

#: Longer texts are not repeated in a remedy.
_LONGEST_SHOWN = 40

_SMALLEST_SHARE, _LARGEST_SHARE = 1e-9, 10.0


@dataclass(frozen=True)
class Deviation(Kind):
    """A deviation from a target: absolute in its unit, or relative as a percentage.

    The value read is a pair: the number, and whether it is a share of the target's value.
    """

    unit: str | None

    @property
    def _absolute(self) -> Quantity:
        return Quantity(self.unit, above_zero=True)

    def read(self, value: Any, place: Place) -> tuple[float, bool] | None:
        """Read a deviation above zero."""
        share = percentage(value) if isinstance(value, str) else None
        if share is None:
            absolute = self._absolute.read(value, place)
            return None if absolute is None else (absolute, False)
        if not _SMALLEST_SHARE <= share <= _LARGEST_SHARE:
            place.fault(messages.SHARE_OUT_OF_RANGE, given=show(value))
            return None
        return share, True

    def schema(self) -> Schema:
        """Return the JSON Schema of both forms."""
        return self._absolute.schema()


@dataclass(frozen=True)
class TargetTable(Kind):
    """The target of one response.

    Parameters
    ----------
    quantity : Quantity, optional
        Possible values of the response; None when only the user's own model knows.
    """

    quantity: Quantity | None = None

    def read(self, value: Any, place: Place) -> Target | None:
        """Read a measured value, or repeated measurements, with their options."""
        if not isinstance(value, dict):
            note_wrong_kind(
                value, place, "a table", f"Write {place.key} = {{ value = {_as_toml(value)} }}."
            )
            return None
        target: Target | None = self._table(value).read(value, place)
        return target

    def _table(self, value: dict[str, Any]) -> Table:
        if self.quantity is not None:
            return Table(_target_keys(self.quantity), self._target)
        return Table((*_target_keys(own_quantity(value)), _OWN_UNIT), self._target)

    def _target(self, values: Values, place: Place) -> Target | None:
        value = _measured(values, place)
        if value is None or None in values.values() or _note_relative_to_zero(values, value, place):
            return None
        options: dict[str, Any] = {
            key: absolute(values[key], value) for key in _WIDTHS if key in values
        }
        options |= {key: values[key] for key in ("weight", "statistic") if key in values}
        unit = values.get("unit", "") if self.quantity is None else self.quantity.unit or ""
        try:
            if "measurements" in values:
                measurements = values["measurements"]
                return Target.of_measurements(place.key, measurements, unit=unit, **options)
            return Target(place.key, value, unit=unit, **options)
        except InputError as error:
            place.note(error, values, place.at("measurements"))
            return None

    def schema(self) -> Schema:
        """Return the JSON Schema of the target's table."""
        schema = self._table({}).schema()
        schema["oneOf"] = [{"required": ["value"]}, {"required": ["measurements"]}]
        return schema


@dataclass(frozen=True)
class PlannedTargetTable(TargetTable):
    """A target before the laboratory: its value may be missing."""

    def _target(self, values: Values, place: Place) -> PlannedTarget | None:  # type: ignore[override]
        if None in values.values():
            return None
        if "measurements" in values:
            target = super()._target(values, place)
            if target is None:
                return None
            return PlannedTarget(target.value, Accuracy(target.standard_uncertainty))
        given = values.get("uncertainty") or values.get("tolerance")
        return PlannedTarget(values.get("value"), Accuracy(*given) if given else None)


@dataclass(frozen=True)
class OrMeasured(Kind):
    """A target that is given, or is measured when the file is read.

    Parameters
    ----------
    otherwise : Kind
        Kind of the target that is given.
    measured : mapping of str to Table
        Keys of the target that is measured, by the one that names what it is measured on.
    """

    otherwise: Kind
    measured: Mapping[str, Table]

    def read(self, value: Any, place: Place) -> Any:
        """Measure, where one of these keys is there."""
        given = value if isinstance(value, dict) else {}
        named = (table for key, table in self.measured.items() if key in given)
        kind: Kind = next(named, self.otherwise)
        return kind.read(value, place)

    def schema(self) -> Schema:
        """Return the JSON Schema of all forms."""
        return {"oneOf": [kind.schema() for kind in (self.otherwise, *self.measured.values())]}


#: Keys that are deviations from the value.
_WIDTHS = ("uncertainty", "systematic", "tolerance")
_OWN_UNIT = Key("unit", Text(), "Unit of the response as your model yields it, for people.")


def _target_keys(quantity: Quantity) -> tuple[Key, ...]:
    deviation = Deviation(quantity.unit)
    return (
        Key("value", quantity, "Measured value."),
        Key(
            "measurements",
            ListOf(quantity, shortest=2),
            "Instead of value and uncertainty: repeated measurements, at least 2. "
            "Their mean is the value; its uncertainty is the standard error of the mean, with "
            "Student's factor for few, together with the systematic part.",
        ),
        Key(
            "systematic",
            deviation,
            "Beside measurements: standard uncertainty that they share, such as that of a scale or "
            "a protractor.",
        ),
        Key(
            "uncertainty",
            deviation,
            'Standard uncertainty of the measured value; "1 %" means 1 % of it.',
        ),
        Key(
            "tolerance",
            deviation,
            "Largest accepted deviation of the calibrated response: what is good enough. "
            "By default the uncertainty; without one, 2 % of the value. From measurements without "
            "a systematic part at least 1 % of the value, or 0.5 degrees.",
        ),
        Key(
            "weight",
            Quantity("", above_zero=True),
            "Weight of this target's relative deviation against the others'; 1 by default.",
        ),
        Key(
            "statistic",
            Choice(get_args(Statistic)),
            'What the measured value is compared with: the "mean" over seeds, with jams and other '
            'outlying runs (default), or the "median", which these do not move.',
        ),
    )


def _measured(values: Values, place: Place) -> float | None:
    """Return the value, given or the mean of measurements; note faults."""
    if "measurements" not in values:
        if "value" not in values:
            place.at("value").fault(messages.NO_MEASURED_VALUE)
        if "systematic" in values:
            place.at("systematic").fault(messages.SYSTEMATIC_ALONE)
            return None
        return values.get("value")
    for key in ("value", "uncertainty"):
        if key in values:
            place.at(key).fault(messages.BESIDE_MEASUREMENTS, key=key)
    given = any(key in values for key in ("value", "uncertainty"))
    measurements = values["measurements"]
    return None if given or measurements is None else statistics.fmean(measurements)


def absolute(deviation: tuple[float, bool] | None, value: float) -> float | None:
    """Return a deviation in the unit of a value, of which it may be a share."""
    if deviation is None:
        return None
    number, is_share = deviation
    return number * abs(value) if is_share else number


def _note_relative_to_zero(values: Values, value: float, place: Place) -> bool:
    """Note what a value of zero does not have: percentages, and a default tolerance."""
    if value != 0:
        return False
    widths = {key: values[key] for key in _WIDTHS if key in values}
    for key, (number, is_share) in widths.items():
        if is_share:
            place.at(key).fault(SHARE_OF_ZERO, given=f"{100 * number:g} %")
    if not widths and "measurements" not in values:
        place.at("tolerance").fault(NO_DEFAULT_TOLERANCE)
        return True
    return any(is_share for _, is_share in widths.values())


def _as_toml(value: object) -> str:
    if not isinstance(value, str) or len(value) >= _LONGEST_SHOWN:
        return "..."
    return plain(json.dumps(value, ensure_ascii=False))
