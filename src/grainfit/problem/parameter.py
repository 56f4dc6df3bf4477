"""Free parameters: the intervals in which their values are searched."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from grainfit.contact_models.registry import material_parameter
from grainfit.errors import Fault, InputError
from grainfit.formatting import short_repr
from grainfit.materials.wall_friction import MEASURED_BY_ANGLE, friction_about
from grainfit.materials.walls import plain_name
from grainfit.problem import messages
from grainfit.problem.quantities import (
    make_floats,
    read_quantities,
    require_units,
    share_of,
    shown,
)
from grainfit.validation import NOT_COMPUTABLE, SMALLEST_SHARE, as_number, is_computable

Scale = Literal["linear", "log"]
_MEASUREMENT = ("measured", "uncertainty")
#: Significant digits of values for people, and least number of different values in an interval.
_DIGITS_SHOWN, _STEPS_SHOWN = 4, 500


@dataclass(frozen=True)
class Parameter:
    """A free parameter and the interval in which its value is searched.

    Parameters
    ----------
    name : str
        For example ``"particle_particle.rolling_friction"``.
    minimum, maximum : float or str
        The interval: numbers in SI units, or quantities such as ``"1.4 g/cm^3"``.
    scale : {"linear", "log"}
        ``"log"`` for parameters that span orders of magnitude, such as Young's modulus.
    unit : str
        SI unit, for display; by default that of the quantities, or of the material parameter.
    measured, uncertainty : float or str, optional
        Value that a measurement of its own gave, with its standard uncertainty (``"1 %"`` is a
        share of the value). The calibration
        keeps the value as far as the tests agree with it, and the uncertainty is part of all
        intervals.

    Raises
    ------
    InputError
        A quantity cannot be read, the bounds are not finite, swapped, equal, or not positive on
        a log scale, or the measured value is outside of them or has no uncertainty.

    Examples
    --------
    >>> Parameter("particle.density", "2400 kg/m^3", "2600 kg/m^3").maximum
    2600.0
    """

    name: str
    minimum: float
    maximum: float
    scale: Scale = "linear"
    unit: str = ""
    measured: float | None = None
    uncertainty: float | None = None

    if TYPE_CHECKING:
        # Quantities are read: attributes are numbers.
        def __init__(
            self,
            name: str,
            minimum: float | str,
            maximum: float | str,
            scale: Scale = "linear",
            unit: str = "",
            measured: float | str | None = None,
            uncertainty: float | str | None = None,
        ) -> None: ...

    @classmethod
    def from_angle(cls, name: str, angle: float | str, uncertainty: float | str) -> Parameter:
        """Return wall friction that was measured as an angle of an inclined plane.

        Its interval has three standard uncertainties on either side. Without an uncertainty, fix
        the parameter at `friction_of_angle`: that takes no run.

        Parameters
        ----------
        name : str
            ``"particle_wall.sliding_friction"`` or ``"particle_wall.rolling_friction"``.
        angle, uncertainty : float or str
            Angle at which sliding or rolling begins, and its standard uncertainty, degrees, or
            quantities.

        Raises
        ------
        InputError
            The parameter is no tangent of an angle, or an angle is out of range.

        Examples
        --------
        >>> found = Parameter.from_angle("particle_wall.sliding_friction", "21.8 deg", "0.5 deg")
        >>> round(found.measured, 4), round(found.uncertainty, 4)
        (0.4, 0.0101)
        """
        if plain_name(name) not in MEASURED_BY_ANGLE:
            known = " and ".join(MEASURED_BY_ANGLE)
            raise InputError(messages.NO_TANGENT.fault(name, known=known))
        value, spread, low, high = friction_about(angle, uncertainty)
        return cls(name, low, high, measured=value, uncertainty=spread)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError(messages.NO_PARAMETER_NAME.fault("parameter"))
        require_units(self, "unit")
        known = material_parameter(self.name)
        unit = known.unit if known else None
        keys = {"minimum": "min", "maximum": "max", "measured": "measured"}
        read_quantities(self, keys, unit)
        object.__setattr__(self, "uncertainty", share_of(self.uncertainty, self.measured))
        read_quantities(self, {"uncertainty": "uncertainty"}, unit)
        InputError.raise_for(list(_interval_faults(self)) or list(_measurement_faults(self)))
        make_floats(self, "minimum", "maximum", *_MEASUREMENT)

    def __repr__(self) -> str:
        return short_repr(self, "name", "minimum", "maximum")

    def to_json(self) -> dict[str, Any]:
        """Return plain data of the parameter, without a measurement that there is not."""
        data = asdict(self)
        return {k: v for k, v in data.items() if k not in _MEASUREMENT or v is not None}

    def standardised_residual(self, position: float) -> float:
        """Return the deviation of a position from the measured value, in uncertainties."""
        assert self.measured is not None
        assert self.uncertainty is not None
        return (self.from_unit(position) - self.measured) / self.uncertainty

    def standardised_residual_slope(self, position: float) -> float:
        """Return the slope of `standardised_residual`, per unit interval."""
        assert self.uncertainty is not None
        if self.scale == "log":
            rise = self.from_unit(position) * math.log(self.maximum / self.minimum)
        else:
            rise = self.maximum - self.minimum
        return rise / self.uncertainty

    def contains(self, value: float) -> bool:
        """Return True if a value is within the interval."""
        return self.minimum <= value <= self.maximum

    def widened_to(self, values: Sequence[float]) -> Parameter:
        """Return the parameter with its interval widened to some values."""
        low, high = min([self.minimum, *values]), max([self.maximum, *values])
        return replace(self, minimum=low, maximum=high)

    def to_unit(self, value: float) -> float:
        """Return the position of a value in the interval: 0 at the minimum, 1 at the maximum."""
        if self.scale == "log":
            return math.log(value / self.minimum) / math.log(self.maximum / self.minimum)
        return (value - self.minimum) / (self.maximum - self.minimum)

    def rounded(self, value: float) -> float:
        """Round a value to the digits that people read, or to more in a narrow interval."""
        largest = max(abs(self.minimum), abs(self.maximum))
        step = (self.maximum - self.minimum) / _STEPS_SHOWN
        needed = math.floor(math.log10(largest)) + 1 - math.floor(math.log10(step))
        shown = float(f"{value:.{max(_DIGITS_SHOWN, needed)}g}")
        return min(max(shown, self.minimum), self.maximum)

    def from_unit(self, position: float) -> float:
        """Return the value at a position: exactly a bound at 0 and 1, extrapolated outside."""
        if position in (0.0, 1.0):
            return self.maximum if position else self.minimum
        if self.scale == "log":
            return self.minimum * math.exp(position * math.log(self.maximum / self.minimum))
        return self.minimum + position * (self.maximum - self.minimum)


def _interval_faults(parameter: Parameter) -> Iterator[Fault]:
    name, low, high = parameter.name, as_number(parameter.minimum), as_number(parameter.maximum)
    if parameter.scale not in ("linear", "log"):
        yield messages.UNKNOWN_SCALE.fault(f"{name}.scale", scale=parameter.scale)
        return
    given = (("min", low, parameter.minimum), ("max", high, parameter.maximum))
    bounds = [
        messages.NOT_FINITE.fault(f"{name}.{key}", given=shown(written))
        for key, value, written in given
        if not math.isfinite(value)
    ]
    bounds = bounds or [
        messages.BAD_SIZE.fault(f"{name}.{key}", given=value, remedy=NOT_COMPUTABLE)
        for key, value, _ in given
        if not is_computable(value)
    ]
    if bounds:
        yield from bounds
    elif low >= high:
        order = "equal" if low == high else "swapped"
        yield messages.BOUNDS_NOT_IN_ORDER.fault(name, order=order, low=low, high=high)
    elif parameter.scale == "log" and low <= 0:
        yield messages.NOT_POSITIVE_ON_LOG_SCALE.fault(f"{name}.min", low=low)
    elif high - low < SMALLEST_SHARE * max(abs(low), abs(high)):
        yield messages.BOUNDS_ALMOST_EQUAL.fault(name, low=low, high=high)


def _measurement_faults(parameter: Parameter) -> Iterator[Fault]:
    given = {key: getattr(parameter, key) for key in _MEASUREMENT}
    missing = [key for key, value in given.items() if value is None]
    if len(missing) == len(given):
        return
    if missing:
        yield messages.HALF_A_MEASUREMENT.fault(f"{parameter.name}.{missing[0]}")
        return
    value, spread = (as_number(number) for number in given.values())
    width = parameter.maximum - parameter.minimum
    measured, uncertainty = (f"{parameter.name}.{key}" for key in _MEASUREMENT)
    as_given = shown(given["uncertainty"])
    if not parameter.minimum <= value <= parameter.maximum:
        yield messages.MEASURED_OUTSIDE.fault(
            measured, given=shown(given["measured"]), low=parameter.minimum, high=parameter.maximum
        )
    elif not 0 < spread < math.inf:
        yield messages.NOT_ABOVE_ZERO.fault(uncertainty, given=as_given)
    elif spread / width < SMALLEST_SHARE:
        yield messages.UNCERTAINTY_TOO_SMALL.fault(uncertainty, given=as_given, width=width)
    elif spread / width > 1 / SMALLEST_SHARE:
        yield messages.UNCERTAINTY_TOO_LARGE.fault(uncertainty, given=as_given, width=width)
