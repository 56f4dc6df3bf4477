"""Calibration problems: free parameters, targets, and the Rayleigh time step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grainfit.checks import (
    NOT_COMPUTABLE,
    SMALLEST_SHARE,
    as_number,
    count_faults,
    is_computable,
)
from grainfit.contact_models.registry import material_parameter
from grainfit.correlations import (
    Correlation,
    correlated_groups,
    correlation_faults,
    correlation_matrix,
    split_covariance,
)
from grainfit.curve_target import CurveTarget
from grainfit.errors import Fault, InputError
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.materials.wall_friction import MEASURED_BY_ANGLE, friction_about
from grainfit.materials.walls import plain_name
from grainfit.units import UnitError, percentage, to_si, to_unit

#: Relative tolerance of a target for which neither an uncertainty nor a tolerance is given.
DEFAULT_RELATIVE_TOLERANCE = 0.02
#: Largest weight of a target; the smallest is its inverse.
LARGEST_WEIGHT = 1e6

Scale = Literal["linear", "log"]
Statistic = Literal["mean", "median"]
_MEASUREMENT = ("measured", "uncertainty")
_TARGET_WIDTHS = ("uncertainty", "tolerance")


def _shown(value: object) -> str:
    return repr(value) if isinstance(value, str) else str(value)


def _make_plain(owner: object, *keys: str) -> None:
    """Convert NumPy numbers to floats, because results are written as JSON."""
    for key in keys:
        value = getattr(owner, key)
        if value is not None:
            object.__setattr__(owner, key, float(value))


def _read_quantities(owner: Any, keys: Mapping[str, str], usual_unit: str = "") -> None:
    """Convert texts such as ``"2.1 g/cm^3"`` to numbers in the owner's unit.

    Without a unit, the owner gets the usual one, or that of the first quantity.
    """
    texts = {key: text for key in keys if isinstance(text := getattr(owner, key), str)}
    if not texts:
        return
    faults = []
    for key, text in texts.items():
        unit = owner.unit or usual_unit
        try:
            value, unit = (to_unit(text, unit), unit) if unit else to_si(text)
        except UnitError as error:
            faults.append(Fault(f"{owner.name}.{keys[key]}", error.message, error.remedy))
            continue
        object.__setattr__(owner, key, value)
        object.__setattr__(owner, "unit", unit)
    if faults:
        raise InputError(faults)


def _share(given: Any, value: Any) -> Any:
    """Return a percentage of a value as a number; anything else unchanged."""
    if not isinstance(given, str) or not given.strip().endswith("%"):
        return given
    share = percentage(given)
    return given if share is None else share * abs(as_number(value))


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
            remedy = f"Angles measure {' and '.join(MEASURED_BY_ANGLE)}."
            raise InputError(Fault(name, "is no tangent of an angle.", remedy))
        value, spread, low, high = friction_about(angle, uncertainty)
        return cls(name, low, high, measured=value, uncertainty=spread)

    def __post_init__(self) -> None:
        known = material_parameter(self.name)
        unit = known.unit if known else ""
        keys = {"minimum": "min", "maximum": "max", "measured": "measured"}
        _read_quantities(self, keys, unit)
        object.__setattr__(self, "uncertainty", _share(self.uncertainty, self.measured))
        _read_quantities(self, {"uncertainty": "uncertainty"}, unit)
        faults = list(_interval_faults(self)) or list(_measurement_faults(self))
        if faults:
            raise InputError(faults)
        _make_plain(self, "minimum", "maximum", *_MEASUREMENT)

    def to_json(self) -> dict[str, Any]:
        """Return plain data of the parameter, without a measurement that there is not."""
        data = asdict(self)
        return {k: v for k, v in data.items() if k not in _MEASUREMENT or v is not None}

    def off_measured(self, position: float) -> float:
        """Return the deviation of a position from the measured value, in uncertainties."""
        assert self.measured is not None
        assert self.uncertainty is not None
        return (self.from_unit(position) - self.measured) / self.uncertainty

    def off_measured_slope(self, position: float) -> float:
        """Return the slope of `off_measured`, per unit interval."""
        assert self.uncertainty is not None
        if self.scale == "log":
            rise = self.from_unit(position) * math.log(self.maximum / self.minimum)
        else:
            rise = self.maximum - self.minimum
        return rise / self.uncertainty

    def contains(self, value: float) -> bool:
        """Return True if a value is within the interval."""
        return self.minimum <= value <= self.maximum

    def holding(self, values: Sequence[float]) -> Parameter:
        """Return the parameter with its interval widened to hold some values."""
        low, high = min([self.minimum, *values]), max([self.maximum, *values])
        return replace(self, minimum=low, maximum=high)

    def to_unit(self, value: float) -> float:
        """Return the position of a value in the interval: 0 at the minimum, 1 at the maximum."""
        if self.scale == "log":
            return math.log(value / self.minimum) / math.log(self.maximum / self.minimum)
        return (value - self.minimum) / (self.maximum - self.minimum)

    def from_unit(self, position: float) -> float:
        """Return the value at a position: exactly a bound at 0 and 1, extrapolated outside."""
        if position in (0.0, 1.0):
            return self.maximum if position else self.minimum
        if self.scale == "log":
            return self.minimum * math.exp(position * math.log(self.maximum / self.minimum))
        return self.minimum + position * (self.maximum - self.minimum)


def _measurement_faults(parameter: Parameter) -> Sequence[Fault]:
    name, given = parameter.name, {key: getattr(parameter, key) for key in _MEASUREMENT}
    missing = [key for key, value in given.items() if value is None]
    if len(missing) == len(given):
        return []
    if missing:
        return [Fault(f"{name}.{missing[0]}", "is missing.", "Give both, or neither.")]
    value, spread = (as_number(number) for number in given.values())
    if not parameter.minimum <= value <= parameter.maximum:
        ends = f"{parameter.minimum:g} to {parameter.maximum:g}"
        shown = _shown(given["measured"])
        return [Fault(f"{name}.measured", f"is {shown}.", f"It must be in its interval, {ends}.")]
    if not 0 < spread < math.inf:
        shown = _shown(given["uncertainty"])
        return [Fault(f"{name}.uncertainty", f"is {shown}.", "It must be a number above 0.")]
    width = parameter.maximum - parameter.minimum
    if not SMALLEST_SHARE <= spread / width <= 1 / SMALLEST_SHARE:
        word, remedy = ("nothing", "Fix it") if spread < width else ("too much", "Leave it out")
        message = f"is {_shown(given['uncertainty'])}, {word} beside its interval of {width:g}."
        return [Fault(f"{name}.uncertainty", message, f"{remedy}, or check its unit.")]
    return []


def _interval_faults(parameter: Parameter) -> Sequence[Fault]:
    name, low, high = parameter.name, as_number(parameter.minimum), as_number(parameter.maximum)
    if not name or not isinstance(name, str):
        return [Fault("parameter", "has no name.", "Give it one.")]
    if parameter.scale not in ("linear", "log"):
        return [Fault(f"{name}.scale", f"is {parameter.scale!r}.", 'Use "linear" or "log".')]
    faults = [
        Fault(f"{name}.{key}", f"is {_shown(given)}, not a finite number.", "Give a finite number.")
        for key, value, given in (("min", low, parameter.minimum), ("max", high, parameter.maximum))
        if not math.isfinite(value)
    ]
    if faults:
        return faults
    faults = [
        Fault(f"{name}.{key}", f"is {value}.", NOT_COMPUTABLE)
        for key, value in (("min", low), ("max", high))
        if not is_computable(value)
    ]
    if faults:
        return faults
    if low >= high:
        word = "equal" if low == high else "swapped"
        return [
            Fault(name, f"bounds are {word} (min {low:g}, max {high:g}).", "min must be below max.")
        ]
    if parameter.scale == "log" and low <= 0:
        return [Fault(f"{name}.min", f"is {low:g} on a log scale.", "It must be above 0 there.")]
    if high - low < SMALLEST_SHARE * max(abs(low), abs(high)):
        words = f"bounds are almost equal (min {low!r}, max {high!r})."
        return [Fault(name, words, "Fix the parameter, or give a wider interval.")]
    return []


@dataclass(frozen=True)
class Target:
    """A measured value that the simulated response of the same name has to meet.

    Parameters
    ----------
    name : str
        Name of the response.
    value : float or str
        Measured value, of any sign: a number in SI units, angles in degrees, or a quantity such as
        ``"22 deg"``.
    uncertainty : float or str, optional
        Standard uncertainty of the measured value, same unit; ``"1 %"`` is a share of the value,
        unless that is zero.
    tolerance : float or str, optional
        Largest accepted deviation of the expected response, same unit; by default the uncertainty,
        or 2 % of the value if that is not given either. A value of zero needs one of them.
    weight : float
        Factor on this target's deviation in the misfit (equation 1 of the method has equal
        weights).
    unit : str
        SI unit, for display; by default that of the quantities.
    statistic : {"mean", "median"}
        Expected response: the mean over seeds, with jams and other outlying runs, or the median,
        which these do not move.

    Examples
    --------
    >>> Target("angle_of_repose", "22 deg", uncertainty="2 %").tolerance
    0.44
    >>> Target("dilatancy", "-0.1 mm", tolerance="0.2 mm").is_relative
    False
    """

    name: str
    value: float
    uncertainty: float | None = None
    # None until `__post_init__` computes the default: the attribute is always a float.
    tolerance: float = None  # type: ignore[assignment]
    weight: float = 1.0
    unit: str = ""
    statistic: Statistic = "mean"

    def __post_init__(self) -> None:
        _read_quantities(self, {"value": "value"})
        _require_shares(self)
        shares = {key: _share(getattr(self, key), self.value) for key in _TARGET_WIDTHS}
        for key, share in shares.items():
            object.__setattr__(self, key, share)
        _read_quantities(self, {key: key for key in _TARGET_WIDTHS})
        faults = list(_target_faults(self)) or self._faults_of_size()
        if faults:
            raise InputError(faults)
        if self.tolerance is None:
            object.__setattr__(self, "tolerance", self._usual_tolerance)
        _make_plain(self, "value", "uncertainty", "tolerance", "weight")

    def _faults_of_size(self) -> list[Fault]:
        return _faults_of_size(self)

    @property
    def _usual_tolerance(self) -> float:
        if self.uncertainty is not None:
            return self.uncertainty
        return DEFAULT_RELATIVE_TOLERANCE * abs(self.value)

    def to_json(self) -> dict[str, Any]:
        """Return plain data of the target, without a tolerance that equals the default.

        So the identity of a calibration does not depend on whether the default was given.
        """
        data = asdict(self)
        if self.statistic == "mean":
            del data["statistic"]
        return {**data, "tolerance": None} if self.tolerance == self._usual_tolerance else data

    @property
    def is_relative(self) -> bool:
        """Whether deviations relative to the value make sense.

        They do not if zero is within the tolerance: responses that meet the target may then have
        either sign, and be any multiple of the value.
        """
        return abs(self.value) > self.tolerance

    @property
    def misfit_unit(self) -> float:
        """Deviation that counts as 1 in the misfit, in the unit of the target.

        It is the absolute value where deviations are relative; elsewhere the value of which the
        tolerance would be 2 %, so that targets of both kinds have similar weights.
        """
        return abs(self.value) if self.is_relative else self.tolerance / DEFAULT_RELATIVE_TOLERANCE

    def misfit(self, response: float) -> float:
        """Return the deviation of a response from the target in units of `misfit_unit`.

        References
        ----------
        Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016), equation 1, for relative deviations.
        """
        return (response - self.value) / self.misfit_unit

    def relative_deviation(self, response: float) -> float | None:
        """Return the deviation of a response from the target as a share of the absolute value.

        None where that makes no sense, see `is_relative`.
        """
        return self.misfit(response) if self.is_relative else None

    def is_met_by(self, response: float) -> bool:
        """Return True if a response deviates from the target by at most its tolerance."""
        return abs(response - self.value) <= self.tolerance


#: Faults of a target whose value is zero: message and remedy.
NO_DEFAULT_TOLERANCE = (
    "is missing: 2 % of the value, the default, is nothing where the value is 0.",
    "Give a tolerance or an uncertainty in the unit of the response.",
)
SHARE_OF_ZERO = (
    "Give it in the unit of the response: the value is 0, and so is any percentage of it."
)


def _require_shares(target: Target) -> None:
    """Raise `InputError` if an uncertainty or a tolerance is a percentage of zero."""
    given = {key: getattr(target, key) for key in _TARGET_WIDTHS}
    faults = [
        Fault(f"{target.name}.{key}", f"is {_shown(text)}.", SHARE_OF_ZERO)
        for key, text in given.items()
        if target.value == 0 and isinstance(text, str) and percentage(text) is not None
    ]
    if faults:
        raise InputError(faults)


def _target_faults(target: Target) -> Sequence[Fault]:
    if not target.name or not isinstance(target.name, str):
        return [Fault("target", "has no name.", "Give it the name of its response.")]
    faults = []
    if target.statistic not in get_args(Statistic):
        faults.append(
            Fault(
                f"{target.name}.statistic",
                f"is {_shown(target.statistic)}.",
                f"Possible here: {', '.join(get_args(Statistic))}.",
            )
        )
    if not math.isfinite(as_number(target.value)):
        faults.append(
            Fault(f"{target.name}.value", f"is {_shown(target.value)}.", "It must be a number.")
        )
    elif target.value == 0 and target.tolerance is None and target.uncertainty is None:
        faults.append(Fault(f"{target.name}.tolerance", *NO_DEFAULT_TOLERANCE))
    for key in ("uncertainty", "tolerance", "weight"):
        given = getattr(target, key)
        left_out = given is None and key != "weight"
        if not left_out and not 0 < as_number(given) < math.inf:
            faults.append(
                Fault(
                    f"{target.name}.{key}", f"is {_shown(given)}.", "It must be a number above 0."
                )
            )
    return faults


def _faults_of_size(target: Target) -> list[Fault]:
    """Return the faults of numbers that are too large or too small, alone or beside others."""
    given = {key: getattr(target, key) for key in ("value", *_TARGET_WIDTHS)}
    sizes = {key: abs(float(number)) for key, number in given.items() if number is not None}
    faults = [
        Fault(f"{target.name}.{key}", f"is {given[key]}.", NOT_COMPUTABLE)
        for key, size in sizes.items()
        if not is_computable(size)
    ]
    if not 1 / LARGEST_WEIGHT <= target.weight <= LARGEST_WEIGHT:
        remedy = f"Give {1 / LARGEST_WEIGHT:g} to {LARGEST_WEIGHT:g}; 1 is usual."
        faults.append(Fault(f"{target.name}.weight", f"is {target.weight:g}.", remedy))
    return faults or [
        Fault(
            f"{target.name}.{key}",
            f"is {width:g}, and the {other} is {size:g}.",
            f"Give at least {SMALLEST_SHARE:g} times as much; no measurement is as exact.",
        )
        for key, width in sizes.items()
        for other, size in sizes.items()
        if key != "value" and width < SMALLEST_SHARE * size
    ]


@dataclass(frozen=True)
class ScopeOfTest:
    """One of several tests of a problem: its targets, the parameters it depends on, and its cost.

    Parameters
    ----------
    name : str
        Name of the test.
    targets : sequence of str
        Names of the targets that its runs yield.
    parameters : sequence of str
        Names of the free parameters that it depends on. Its metamodels have only these.
    seconds : float, optional
        Estimated wall time of a run, s; None if it is not known.
    repeats : int
        Runs with different seeds whose mean is one evaluation.

    Examples
    --------
    >>> ScopeOfTest("drop", ["drop.rebound"], ["restitution"], seconds=2.0).parameters
    ('restitution',)
    """

    name: str
    targets: Sequence[str]
    parameters: Sequence[str]
    seconds: float | None = None
    repeats: int = 1

    def __post_init__(self) -> None:
        if faults := count_faults({f"{self.name}.repeats": self.repeats}):
            raise InputError(faults)
        for key in ("targets", "parameters"):
            names = getattr(self, key)
            if isinstance(names, str) or not names:
                raise InputError(
                    Fault(f"{self.name}.{key}", f"are {names!r}.", "Give a list of names.")
                )
            object.__setattr__(self, key, tuple(names))
        if self.seconds is not None and not 0 < as_number(self.seconds) < math.inf:
            raise InputError(
                Fault(f"{self.name}.seconds", f"is {self.seconds!r}.", "It must be above 0.")
            )
        _make_plain(self, "seconds")


def _scope_faults(tests: Sequence[ScopeOfTest], parameters: Sequence[Parameter]) -> Sequence[Fault]:
    known = [parameter.name for parameter in parameters]
    faults = [
        Fault(
            f"{test.name}.parameters",
            f"name {name!r}, which is not a parameter of the problem.",
            f"There are: {', '.join(known)}.",
        )
        for test in tests
        for name in test.parameters
        if name not in known
    ]
    names = [test.name for test in tests]
    targets = [target for test in tests for target in test.targets]
    for word, found in (("test", names), ("target of a test", targets)):
        faults += [
            Fault(name, f"is given as a {word} more than once.", "Keep one of them.")
            for name in sorted({name for name in found if found.count(name) > 1})
        ]
    return faults


def _require_sequence(key: str, items: object, kind: type) -> None:
    if isinstance(items, Sequence) and all(isinstance(item, kind) for item in items):
        return
    raise InputError(
        Fault(key, f"are {_shown(items)}.", f"Give a list of {kind.__name__} objects.")
    )


@dataclass(frozen=True)
class Problem:
    """Free parameters, targets, and the Rayleigh time step, if it is known.

    Parameters
    ----------
    parameters : sequence of Parameter
        Free parameters.
    targets : sequence of Target
        Targets to meet.
    rayleigh : RayleighTimeStep, optional
        Rayleigh time step of the material; without it, time steps are not part of the problem.
    rayleigh_weight : float
        Weight of the Rayleigh criterion (equation 2) among the residuals. 0 by default: as a
        summand of the misfit it trades accuracy for speed.
    correlations : sequence of (str, str, float)
        Correlations of the errors of measured values: two targets and a coefficient between -1 and
        1. Pairs that are not named are not correlated. See `with_covariance`.
    tests : sequence of ScopeOfTest
        The tests, when there are several: then a proposal may be for some of them. Empty when
        every run yields all targets.
    curves : sequence of CurveTarget
        Measured curves to meet.

    Raises
    ------
    InputError
        No parameters, neither targets nor curves, a name given twice, a Rayleigh time step that
        lacks a value, or correlations that name no targets or contradict each other.

    Examples
    --------
    >>> problem = Problem([Parameter("friction", 0.1, 0.9)], [Target("angle", 30.0)])
    >>> problem.from_unit([0.5])
    {'friction': 0.5}
    """

    parameters: Sequence[Parameter]
    targets: Sequence[Target]
    rayleigh: RayleighTimeStep | None = None
    rayleigh_weight: float = 0.0
    correlations: Sequence[Correlation] = ()
    tests: Sequence[ScopeOfTest] = ()
    curves: Sequence[CurveTarget] = ()

    def __post_init__(self) -> None:
        kinds = {
            "parameters": Parameter,
            "targets": Target,
            "tests": ScopeOfTest,
            "curves": CurveTarget,
        }
        for key, kind in kinds.items():
            _require_sequence(key, getattr(self, key), kind)
            object.__setattr__(self, key, tuple(getattr(self, key)))
        faults = []
        named = {"parameter": [p.name for p in self.parameters], "target": self.responses}
        for words, names in named.items():
            if not names:
                faults.append(Fault(f"{words}s", "are empty.", f"Give at least one {words}."))
            faults += [
                Fault(name, f"is given as a {words} more than once.", "Keep one of them.")
                for name in sorted({name for name in names if list(names).count(name) > 1})
            ]
        if not 0 <= as_number(self.rayleigh_weight) <= LARGEST_WEIGHT:
            given = _shown(self.rayleigh_weight)
            remedy = f"It must be 0 or above, and at most {LARGEST_WEIGHT:g}."
            faults.append(Fault("rayleigh_weight", f"is {given}.", remedy))
        faults += _scope_faults(self.tests, self.parameters)
        if self.rayleigh is not None:
            faults += self.rayleigh.faults(self.intervals)
        if not faults:
            faults += self._read_correlations()
        if faults:
            raise InputError(faults)
        _make_plain(self, "rayleigh_weight")

    def _read_correlations(self) -> list[Fault]:
        given = self.correlations
        try:
            pairs = tuple((str(a), str(b), as_number(value)) for a, b, value in given)
        except (TypeError, ValueError):
            remedy = 'Give triples: [("first", "second", 0.8)].'
            return [Fault("correlations", f"are {_shown(given)}.", remedy)]
        object.__setattr__(self, "correlations", pairs)
        return correlation_faults([target.name for target in self.targets], pairs)

    @property
    def responses(self) -> tuple[str, ...]:
        """Names of all responses that were measured: those of the targets, then the curves."""
        return (*(t.name for t in self.targets), *(curve.name for curve in self.curves))

    @cached_property
    def correlation_matrix(self) -> NDArray[np.float64]:
        """Correlations of the errors of the measured values, shape (targets, targets)."""
        return correlation_matrix([target.name for target in self.targets], self.correlations)

    @cached_property
    def precision_matrix(self) -> NDArray[np.float64]:
        """Inverse of the correlation matrix."""
        return np.asarray(np.linalg.inv(self.correlation_matrix))

    @cached_property
    def decorrelation(self) -> NDArray[np.float64]:
        """Matrix that combines deviations into as many that are not correlated.

        The inverse of the Cholesky factor of the correlation matrix.
        """
        return np.asarray(np.linalg.inv(np.linalg.cholesky(self.correlation_matrix)))

    def is_met_by(self, responses: Sequence[float] | NDArray[np.float64]) -> bool:
        """Return True if responses, in the order of the targets, meet them.

        Each is within its tolerance. Correlated ones also go together: the mean square of their
        decorrelated deviations is at most one tolerance squared.
        """
        pairs = list(zip(self.targets, map(float, responses), strict=True))
        if not all(target.is_met_by(response) for target, response in pairs):
            return False
        off = np.array([(response - target.value) / target.tolerance for target, response in pairs])
        precision = self.precision_matrix
        return all(
            float(off[group] @ precision[np.ix_(group, group)] @ off[group]) <= len(group)
            for group in correlated_groups(self.correlation_matrix)
        )

    def with_covariance(self, covariance: ArrayLike) -> Problem:
        """Return the problem with a covariance of the errors of the measured values.

        Parameters
        ----------
        covariance : array_like, shape (targets, targets)
            In the order and the units of the targets. It replaces their uncertainties, and
            tolerances that were the default.

        Raises
        ------
        InputError
            The matrix has another shape, is not symmetric, or is not positive definite.

        Examples
        --------
        >>> targets = [Target("density", 1500.0), Target("angle", 30.0)]
        >>> problem = Problem([Parameter("friction", 0.1, 0.9)], targets)
        >>> problem.with_covariance([[225.0, 6.0], [6.0, 0.25]]).correlations
        (('density', 'angle', 0.8),)
        """
        names = [target.name for target in self.targets]
        errors, correlations = split_covariance(names, covariance)
        targets = [
            Target(**{**target.to_json(), "uncertainty": float(error)})
            for target, error in zip(self.targets, errors, strict=True)
        ]
        return replace(self, targets=targets, correlations=correlations)

    def with_targets(
        self, targets: Sequence[Target], curves: Sequence[CurveTarget] = ()
    ) -> Problem:
        """Return the problem with some targets and curves, and the correlations among these."""
        names = {target.name for target in targets}
        kept = [pair for pair in self.correlations if {pair[0], pair[1]} <= names]
        return replace(self, targets=tuple(targets), correlations=tuple(kept), curves=tuple(curves))

    @property
    def dimension(self) -> int:
        """Number of free parameters."""
        return len(self.parameters)

    @cached_property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Bounds by parameter name."""
        return {p.name: (p.minimum, p.maximum) for p in self.parameters}

    @cached_property
    def scopes(self) -> tuple[ScopeOfTest, ...]:
        """The tests; one of all targets and parameters when no tests are given."""
        if self.tests:
            return tuple(self.tests)
        return (ScopeOfTest("", self.responses, [parameter.name for parameter in self.parameters]),)

    def axes_of(self, scope: ScopeOfTest) -> list[int]:
        """Return the axes of the unit cube that a test depends on."""
        return [i for i, p in enumerate(self.parameters) if p.name in scope.parameters]

    def scope_of(self, target: str) -> ScopeOfTest:
        """Return the test that yields a target; all tests together when none names it."""
        found = [scope for scope in self.scopes if target in scope.targets]
        return found[0] if found else replace(self, tests=()).scopes[0]

    def holding(self, points: Sequence[Mapping[str, float]]) -> Problem:
        """Return the problem with its intervals widened to hold some parameter sets."""
        parameters = [p.holding([values[p.name] for values in points]) for p in self.parameters]
        return replace(self, parameters=parameters)

    def to_unit(self, values: Mapping[str, float]) -> NDArray[np.float64]:
        """Map parameter values to a point of the unit cube, shape (d,)."""
        return np.array([p.to_unit(values[p.name]) for p in self.parameters])

    def from_unit(self, point: ArrayLike) -> dict[str, float]:
        """Map a point of the unit cube, shape (d,), to parameter values."""
        positions = np.asarray(point, dtype=float)
        return {
            p.name: float(p.from_unit(float(position)))
            for p, position in zip(self.parameters, positions, strict=True)
        }

    @property
    def middle(self) -> dict[str, float]:
        """Values in the middle of all intervals, each on its scale."""
        return self.from_unit([0.5] * self.dimension)

    @cached_property
    def measured(self) -> tuple[Parameter, ...]:
        """Free parameters that have a measurement of their own."""
        return tuple(p for p in self.parameters if p.measured is not None)

    def off_measured(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return deviations of parameters from their own measurements, in standard uncertainties.

        Parameters
        ----------
        points : array_like, shape (m, d)
            Points of the unit cube.

        Returns
        -------
        ndarray, shape (m, number of measured parameters)
        """
        at = np.atleast_2d(np.asarray(points, dtype=float))
        off = np.empty((len(at), len(self.measured)))
        for column, (axis, parameter) in zip(off.T, self._measured_axes, strict=True):
            column[:] = [parameter.off_measured(float(u)) for u in at[:, axis]]
        return off

    def off_measured_slopes(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the slopes of `off_measured`, shape (m, measured parameters, d)."""
        at = np.atleast_2d(np.asarray(points, dtype=float))
        slopes = np.zeros((len(at), len(self.measured), self.dimension))
        for row, (axis, parameter) in enumerate(self._measured_axes):
            slopes[:, row, axis] = [parameter.off_measured_slope(float(u)) for u in at[:, axis]]
        return slopes

    @property
    def _measured_axes(self) -> list[tuple[int, Parameter]]:
        return [(axis, p) for axis, p in enumerate(self.parameters) if p.measured is not None]

    def rayleigh_time_step(self, values: Mapping[str, float]) -> float | None:
        """Return the Rayleigh time step at these parameter values, s; None if it is not known."""
        return None if self.rayleigh is None else self.rayleigh(values)

    def rayleigh_criterion(self, values: Mapping[str, float]) -> float:
        """Return the Rayleigh criterion (equation 2) at these values; 0 without a time step."""
        return 0.0 if self.rayleigh is None else self.rayleigh.criterion(values, self.intervals)
