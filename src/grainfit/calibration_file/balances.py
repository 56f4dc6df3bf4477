"""Targets that are measured on the records of a balance: mass over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grainfit.arrays import Array
from grainfit.calibration_file import messages
from grainfit.calibration_file.photos import OF_NUMBER
from grainfit.calibration_file.targets import Deviation, absolute
from grainfit.errors import InputError, NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement.flow_rate import discharge_time, discharged_mass, flow_rate
from grainfit.options.kinds import OneOrMore, Quantity, Text
from grainfit.options.paths import Located
from grainfit.options.places import Place
from grainfit.options.tables import Key, Table, Values
from grainfit.problem import CurveTarget, Target
from grainfit.table_files.curve_points import read_points
from grainfit.table_files.reading import Wanted
from grainfit.units import UnitError, to_unit

#: Key that makes a target one of a balance.
BALANCE = "balance"
#: Responses that a balance tells.
WEIGHED = ("mass_flow", "discharge_time", "discharged_mass")
#: Most lines of a record; points of a curve.
_MOST_LINES, _POINTS = 200_000, 40
#: Standard uncertainty of what a record without any scatter tells, over the value.
_LEAST_UNCERTAINTY = 1e-6
#: Share of the mass that has left when the outlet counts as open, and that may still leave in the
#: last lines of a record.
_BEGUN, _STILL = 0.01, 0.005
#: A record changes by so many times the scatter from line to line at least.
_LEAST_CHANGE = 20.0
_UNITS = {"mass_flow": "kg/s", "discharge_time": "s", "discharged_mass": "kg"}


@dataclass(frozen=True)
class Weighed:
    """One discharge, from the opening of the outlet on.

    Parameters
    ----------
    time, remaining : ndarray of shape (n,)
        s, and mass in the container less that which stays there, kg.
    """

    time: Array
    remaining: Array

    @classmethod
    def of(cls, time: Sequence[float], mass: Sequence[float]) -> Weighed:
        """Return the discharge in a record; the balance has the receiver on it, or the container.

        The outlet was opened where the flow of the first 10 %, prolonged, begins.

        Raises
        ------
        NotMeasurableError
            The mass does not change, goes both ways, or does not come to an end.
        """
        times, masses = np.asarray(time, dtype=float), np.asarray(mass, dtype=float)
        few = max(2, len(masses) // 25)
        first, last = float(np.median(masses[:few])), float(np.median(masses[-few:]))
        left = (masses - first) * np.sign(last - first)
        total = abs(last - first)
        scatter = float(np.median(np.abs(np.diff(masses, 2)))) if len(masses) > 2 else 0.0
        if not total > _LEAST_CHANGE * scatter:
            raise NotMeasurableError(messages.NO_DISCHARGE(change=1000 * total))
        before = float(np.median(masses[-2 * few : -few]))
        if abs(last - before) > max(_STILL * total, 3 * scatter):
            raise NotMeasurableError(messages.NO_END())
        if left.max() - total > 0.1 * total or left.min() < -0.1 * total:
            raise NotMeasurableError(messages.BOTH_WAYS())
        grown = np.maximum.accumulate(np.clip(left, 0.0, total))
        begun, tenth = (_time_of(times, grown, share * total) for share in (_BEGUN, 0.1))
        opened = begun - _BEGUN / (0.1 - _BEGUN) * (tenth - begun)
        after = times > opened
        return cls(np.r_[opened, times[after]], np.r_[total, total - grown[after]])

    def measure(self, response: str) -> Response:
        """Measure the response of a simulated discharge."""
        flow = flow_rate(self.time, self.remaining)
        if response == "mass_flow":
            return flow.response
        return discharge_time(self.time, self.remaining, flow, 0.0)


def _time_of(time: Array, left: Array, mass: float) -> float:
    at = int(np.argmax(left >= mass))
    return float(np.interp(mass, left[max(at - 1, 0) : at + 1], time[max(at - 1, 0) : at + 1]))


def balance_table(response: str) -> Table:
    """Return the keys of a target that records of a balance tell."""
    unit = _UNITS[response]

    def number(values: Values, place: Place) -> Target | None:
        return _number(response, values, place)

    return Table(_keys(unit), _curve if response == "discharged_mass" else number)


def _keys(unit: str) -> tuple[Key, ...]:
    deviation = Deviation(unit)
    keys = (
        Key(
            BALANCE,
            OneOrMore(Located()),
            "Table with mass over time, or several of repeats; their scatter is the uncertainty. "
            "The balance is below the outlet, or carries the container.",
            required=True,
            example='["first.csv", "second.csv", "third.csv"]',
        ),
        Key("x", Text(), "Column of the time.", default="the first one"),
        Key("y", Text(), "Column of the mass.", default="the second one"),
        Key("x_unit", Text(), "Unit of the time; that of its heading by default.", example='"s"'),
        Key("y_unit", Text(), "Unit of the mass; that of its heading by default.", example='"g"'),
        Key(
            "systematic",
            deviation,
            "Standard uncertainty that all records share, such as that of the balance or its lag.",
            default="none",
            example='"1 %"',
        ),
        Key(
            "tolerance",
            deviation,
            "Largest accepted deviation of the calibrated response: what is good enough.",
            default="as of a target that is given by measurements",
            example='"3 %"',
        ),
    )
    if unit == _UNITS["discharged_mass"]:
        return keys
    return (*keys, *OF_NUMBER)


def _number(response: str, values: Values, place: Place) -> Target | None:
    found = _records(values, place)
    if found is None:
        return None
    unit = _UNITS[response]
    measured: list[Response] = []
    for record, path, at in found:
        try:
            one = record.measure(response)
        except NotMeasurableError as error:
            at.fault(messages.FILE_REFUSED, file=path.name, reason=error)
            return None
        measured.append(one)
        name = response.replace("_", " ")
        text = messages.WEIGHED(file=path.name, response=name, value=one.value, unit=unit)
        place.findings.tables.append(text)
    mean = float(np.mean([one.value for one in measured]))
    options: dict[str, Any] = {
        key: absolute(values[key], mean) for key in ("systematic", "tolerance") if key in values
    }
    options |= {key: values[key] for key in ("weight", "statistic") if key in values}
    try:
        if len(measured) > 1:
            rounded = [_digits(one.value) for one in measured]
            return Target.of_measurements(place.key, rounded, unit=unit, **options)
        shared = options.pop("systematic", 0.0)
        least = _LEAST_UNCERTAINTY * abs(mean)
        uncertainty = _digits(max(float(np.hypot(measured[0].standard_error, shared)), least))
        return Target(place.key, _digits(mean), uncertainty, unit=unit, **options)
    except InputError as fault:
        place.note(fault, values, place.at(BALANCE))
        return None


def _curve(values: Values, place: Place) -> CurveTarget | None:
    found = _records(values, place)
    if found is None:
        return None
    if len(found) < 2:
        place.at(BALANCE).fault(messages.ONE_RECORD)
        return None
    curves = [discharged_mass(record.time, record.remaining) for record, _, _ in found]
    end = min(curve.coordinates[-1] for curve in curves)
    times = np.linspace(0.0, end, _POINTS + 1)[1:]
    options: dict[str, Any] = {
        key: f"{100 * values[key][0]:.15g} %" if values[key][1] else values[key][0]
        for key in ("systematic", "tolerance")
        if key in values
    }
    try:
        return CurveTarget.of_measurements(
            place.key,
            [
                (times.round(6), np.interp(times, one.coordinates, one.values).round(9))
                for one in curves
            ],
            unit="kg",
            coordinate_unit="s",
            coordinate="time",
            **options,
        )
    except InputError as fault:
        place.note(fault, values, place.at(BALANCE))
        return None


def _records(values: Values, place: Place) -> list[tuple[Weighed, Path, Place]] | None:
    """Read the records; None after noting every fault."""
    if None in values.values():
        return None
    x = _column(values, "x", "time", "s", place)
    y = _column(values, "y", "mass", "kg", place)
    names = (values.get("x"), values.get("y"))
    if x is None or y is None:
        return None
    records: list[tuple[Weighed, Path, Place]] = []
    failed = False
    for number, path in enumerate(values[BALANCE]):
        at = place.at(BALANCE, number)
        points = read_points(path, (x, y), names, at, most=_MOST_LINES)
        if points is None:
            failed = True
            continue
        try:
            records.append((Weighed.of(points.coordinates, points.values), path, at))
        except NotMeasurableError as error:
            at.fault(messages.FILE_REFUSED, file=path.name, reason=error)
            failed = True
    return None if failed else records


def _column(
    values: Mapping[str, Any], key: str, name: str, unit: str, place: Place
) -> Wanted | None:
    """Return a column; None after noting a unit that cannot be converted."""
    written = values.get(f"{key}_unit")
    try:
        if written:
            to_unit(f"1 {written}", unit)
    except UnitError as error:
        place.at(f"{key}_unit").refuse(error)
        return None
    # A balance writes grams as often as kilograms: nothing is taken for granted.
    return Wanted(Quantity(unit), name, given=written, unit_key=f"{key}_unit", needs_unit=True)


def _digits(value: float) -> float:
    """Round to six digits, as people write them."""
    return float(f"{value:.6g}")
