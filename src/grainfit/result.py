"""Result of a calibration."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from math import isfinite, sqrt
from pathlib import Path
from statistics import fmean
from typing import Any, Literal

from grainfit.errors import StoreError
from grainfit.evaluation import Response
from grainfit.files import LARGEST_RESULT, read_within, write_atomically
from grainfit.formatting import (
    counted,
    deviation_off,
    ends,
    in_a_row,
    number,
    on_curve,
    plain_ends,
    plain_interval,
    plain_probability,
    unit_for_people,
    with_unit,
)
from grainfit.materials.card import Determination
from grainfit.tables import TextTable, as_html, as_text

#: Half the width of a 95 % interval in standard errors.
_NORMAL_QUANTILE = 1.96
Status = Literal["calibrated", "undecided", "out_of_tolerance", "unreachable", "interrupted"]
Verdict = Literal["met", "in doubt", "missed"]
Bound = Literal["min", "max"]
#: From this percentage on, the ends of an interval are given instead.
_LARGEST_PERCENTAGE = 50.0
#: The status in words.
STATUS_WORDS: Mapping[Status, str] = {
    "calibrated": "calibrated: every target is met within its tolerance",
    "undecided": "undecided: the runs do not tell whether every target is met",
    "out_of_tolerance": "out of tolerance: no parameter set was found that meets every target",
    "unreachable": "out of reach within the given intervals",
    "interrupted": "interrupted: start it again to continue",
}
#: Names of version 0.1.0 that have changed.
_RENAMED = {
    "agreement": "probability_all_met",
    "std_error": "standard_error",
    "verified_std_error": "verified_standard_error",
    "learnt_from": "warm_start_runs",
}


@dataclass(frozen=True)
class ResponseResult:
    """A response at the answer, compared with its target.

    Parameters
    ----------
    target, tolerance : float
        Measured value and largest accepted deviation.
    unit : str
        Unit of all these numbers.
    predicted, standard_error : float
        Expected response by the metamodel, and its standard error.
    verified_mean, verified_standard_error : float, optional
        Mean of the verification runs (fresh seeds at, or very near, the answer) and its standard
        error: an independent check of the expected response.
    verified_interval : float, optional
        Half of the 95 % confidence interval of that mean.
    deviation_percent : float, optional
        Deviation of the expected response from the target, over its absolute value. None where that
        makes no sense: zero is within the tolerance.
    verdict : {"met", "in doubt", "missed"}
        ``met`` when the expected response is within its tolerance with the demanded probability
        and the fresh seeds do not contradict it; ``missed`` when it is outside with that
        probability.
    probability : float, optional
        Probability, by all runs, that the expected response is within its tolerance. None in
        results of version 0.1.0.
    verified_values : tuple of float
        Responses of the verification runs; those of runs very near the answer are carried over to
        it by the metamodel.
    verified_seeds : tuple of int
        Their seeds.
    """

    target: float
    tolerance: float
    unit: str
    predicted: float
    standard_error: float
    verified_mean: float | None
    verified_standard_error: float | None
    verified_interval: float | None
    deviation_percent: float | None
    verdict: Verdict
    probability: float | None = None
    verified_values: tuple[float, ...] = ()
    verified_seeds: tuple[int, ...] = ()

    def deviation_in_words(self, unit: str) -> str:
        """Return the deviation with its sign: in percent, or in a unit as it is to be shown."""
        return deviation_off(
            self.deviation_percent, self.predicted - self.target, self.tolerance, unit
        )

    @property
    def expected(self) -> tuple[float, float]:
        """Expected response, by all runs, and half of its 95 % interval."""
        if self.probability is None and self.verified_mean is not None and self.verified_interval:
            # Version 0.1.0 predicted it without the verification runs, and gave their mean.
            return self.verified_mean, self.verified_interval
        return self.predicted, _NORMAL_QUANTILE * self.standard_error


@dataclass(frozen=True)
class CurveResult:
    """A curve at the answer, compared with the measured one.

    Parameters
    ----------
    coordinate, coordinate_unit, unit : str
        Name and unit of the coordinate, and unit of the values.
    coordinates, measured, uncertainties : tuple of float
        Measured points, with standard uncertainties.
    expected, standard_errors : tuple of float
        Expected curve at these points by the metamodels, and its standard errors.
    components : int
        Number of principal components in which simulated curves differ.
    deviation : float
        Root mean square deviation of the expected curve, in standard uncertainties.
    probability : float
        Probability, by all runs, that the component in doubt most is within its tolerance.
    shape_probability : float
        Probability of the part of the measured curve that no simulated curve has, if its errors are
        as stated.
    verdict : {"met", "in doubt", "missed"}
        As of a response; ``missed`` also when no simulated curve has the measured shape.
    verified_runs : int
        Number of fresh seeds at, or very near, the answer.
    verified_mean, verified_standard_errors : tuple of float
        Mean curve of at least two fresh seeds at the measured points, carried over to the answer,
        and its standard errors; empty for fewer.
    """

    coordinate: str
    coordinate_unit: str
    unit: str
    coordinates: tuple[float, ...]
    measured: tuple[float, ...]
    uncertainties: tuple[float, ...]
    expected: tuple[float, ...]
    standard_errors: tuple[float, ...]
    components: int
    deviation: float
    probability: float
    shape_probability: float
    verdict: Verdict
    verified_runs: int = 0
    verified_mean: tuple[float, ...] = ()
    verified_standard_errors: tuple[float, ...] = ()

    @property
    def verified_deviations(self) -> list[float]:
        """Deviations of the mean of the fresh seeds, in standard uncertainties; may be empty."""
        return [
            (mean - self.measured[i]) / self.uncertainties[i]
            for i, mean in enumerate(self.verified_mean)
        ]

    @property
    def fresh(self) -> str:
        """Deviation of the mean of the fresh seeds from the measured curve; "" for fewer than two.

        Examples
        --------
        >>> CurveResult("x", "", "", (1.0, 2.0), (3.0, 4.0), (0.1, 0.1), (3.0, 4.0), (0.0, 0.0),
        ...             1, 0.0, 1.0, 1.0, "met", 2, (3.1, 4.0), (0.02, 0.05)).fresh
        '0.71 σ off the measured curve (root mean square), most at x = 1, by 1 ± 0.2 σ'
        """
        off = [abs(deviation) for deviation in self.verified_deviations]
        if not off:
            return ""
        worst = off.index(max(off))
        error = self.verified_standard_errors[worst] / self.uncertainties[worst]
        place = on_curve(self.coordinates[worst], self.coordinate, self.coordinate_unit)
        return (
            f"{number(sqrt(fmean(one**2 for one in off)), 2)} σ off the measured curve (root mean "
            f"square), most at {place}, by {number(off[worst], 2)} ± {number(error, 2)} σ"
        )


@dataclass(frozen=True)
class ParameterInterval:
    """95 % interval of a parameter, which holds the answer, and a word for its width.

    Parameters
    ----------
    low, high : float
        Ends, SI; see `grainfit.analysis.intervals.parameter_intervals`.
    determination : {"determined", "narrowed", "not determined"}
        Whether the runs determine the parameter: at most a quarter of its interval fits; more; or
        more than nine tenths.
    """

    low: float
    high: float
    determination: Determination

    def percentage(self, value: float) -> str:
        """Return the percentage about a value that covers the interval; "" if it is large."""
        if not value:
            return ""
        percent = 100.0 * max(self.high - value, value - self.low) / abs(value)
        return f"±{number(percent, 2)} %" if percent <= _LARGEST_PERCENTAGE else ""

    def in_words(self, value: float, unit: str = "") -> str:
        """Return how well the runs determine the parameter.

        Examples
        --------
        >>> ParameterInterval(0.47, 0.82, "narrowed").in_words(0.6)
        'only narrowed, 0.47 to 0.82'
        """
        between = with_unit(ends(self.low, self.high), unit_for_people(unit))
        if self.determination == "narrowed":
            return f"only narrowed, {between}"
        share = self.percentage(value) if self.determination == "determined" else ""
        return f"determined to {share}" if share else f"{self.determination}, {between}"


@dataclass(frozen=True)
class YieldLocus:
    """A line through shear stress over normal stress.

    Parameters
    ----------
    normal_stresses : tuple of float
        Pa.
    shear_stresses : tuple of Response
        Shear stresses at these, Pa.
    cohesion : Response
        Shear stress without normal stress, by the line, Pa.
    internal_friction_angle : Response
        Slope of the line, degrees.
    """

    normal_stresses: tuple[float, ...]
    shear_stresses: tuple[Response, ...]
    cohesion: Response
    internal_friction_angle: Response

    def __str__(self) -> str:
        cohesion, angle = (
            plain_interval(found.value, found.standard_error)
            for found in (self.cohesion, self.internal_friction_angle)
        )
        return f"cohesion {cohesion} Pa, {angle}°"


@dataclass(frozen=True)
class YieldLocusResult:
    """Yield locus of several shear tests on one material.

    Parameters
    ----------
    tests : tuple of str
        Names of the tests.
    measured : YieldLocus
        By the targets.
    expected : YieldLocus, optional
        By the responses expected at the answer; None without an answer.
    """

    tests: tuple[str, ...]
    measured: YieldLocus
    expected: YieldLocus | None = None

    def __str__(self) -> str:
        expected = f"; expected at the answer {self.expected}" if self.expected else ""
        return (
            f"Yield locus ({', '.join(self.tests)}): measured {self.measured}{expected} "
            "(± standard error)."
        )


@dataclass(frozen=True)
class RunCounts:
    """Numbers of DEM runs of a calibration.

    ``reused`` of the ``total`` were known before this start (from an interrupted start or another
    calibration) and were not simulated again; ``failed`` of them gave no responses. In addition,
    there was a warm start from ``warm_start_runs`` earlier runs of other calibrations.
    """

    design: int = 0
    optimisation: int = 0
    verification: int = 0
    failed: int = 0
    reused: int = 0
    total: int = 0
    warm_start_runs: int = 0

    def __str__(self) -> str:
        earlier = self.warm_start_runs
        warm = f", warm start from {counted(earlier, 'earlier run')}" if earlier else ""
        return (
            f"{self.total} = {self.design} design + {self.optimisation} optimisation + "
            f"{self.verification} verification; {self.failed} failed, {self.reused} reused{warm}"
        )


@dataclass(frozen=True)
class RunSummary:
    """One parameter set that was simulated."""

    stage: str
    parameters: Mapping[str, float]
    seed: int
    responses: Mapping[str, float]
    failures: Mapping[str, str]
    runs: Mapping[str, str]


@dataclass(frozen=True)
class Result:
    """Result of a calibration.

    Parameters
    ----------
    status : {"calibrated", "undecided", "out_of_tolerance", "unreachable", "interrupted"}
        ``calibrated``: with the demanded probability (0.95 by default), every expected response is
        within its tolerance by all runs, and fresh seeds at the answer do not contradict it.
        ``out_of_tolerance``: with that probability, some expected response is not, at the best
        parameter set found. ``unreachable``: the same for every parameter set within the intervals.
        ``undecided``: the runs establish neither.
    parameters : mapping of str to float
        The calibrated values, SI. Empty when interrupted before there was an answer.
    responses : mapping of str to ResponseResult
        By name of the target.
    runs : RunCounts
        Numbers of DEM runs.
    rayleigh_time_step : float, optional
        Rayleigh time step of the calibrated material, s.
    rayleigh_time_step_before : float, optional
        Rayleigh time step in the middle of the intervals, s.
    rayleigh_time_step_limits : pair of float, optional
        Smallest and largest Rayleigh time step within the intervals, s.
    wall_seconds : float
        Duration of this start, s.
    utilisation : float
        Share of the workers' time spent on simulations, in this start, from 0 to 1.
    probability_all_met : float, optional
        Probability, by the metamodels of all runs including the verification, that all expected
        responses are within their tolerances.
    name, identity, strategy, seed, version : str, str, str, int, str
        Name of the calibration, and all that is needed to repeat it.
    units : mapping of str to str
        Units of the parameters.
    out_of_reach : sequence of OutOfReach
        Targets that cannot be met within the intervals.
    metamodels : mapping of str to MetamodelQuality
        Quality of the metamodels, by name of the target.
    notices : sequence of str
        Notices for the user.
    history : sequence of RunSummary
        Every parameter set that was simulated, in order.
    intervals : mapping of str to ParameterInterval
        95 % intervals of the parameters, given all runs. Empty when these are too few, when no
        parameter set agrees with the measurements, or in a file of an older version.
    curves : mapping of str to CurveResult
        By name of the measured curve.
    yield_loci : sequence of YieldLocusResult
        One for each material that was sheared at two or more normal stresses.
    """

    status: Status
    parameters: Mapping[str, float]
    responses: Mapping[str, ResponseResult]
    runs: RunCounts
    rayleigh_time_step: float | None
    rayleigh_time_step_before: float | None
    rayleigh_time_step_limits: tuple[float, float] | None
    wall_seconds: float
    utilisation: float
    probability_all_met: float | None
    name: str
    identity: str
    strategy: str
    seed: int
    version: str
    units: Mapping[str, str] = field(default_factory=dict)
    out_of_reach: tuple[OutOfReach, ...] = ()
    metamodels: Mapping[str, MetamodelQuality] = field(default_factory=dict)
    notices: tuple[str, ...] = ()
    history: tuple[RunSummary, ...] = ()
    intervals: Mapping[str, ParameterInterval] = field(default_factory=dict)
    curves: Mapping[str, CurveResult] = field(default_factory=dict)
    yield_loci: tuple[YieldLocusResult, ...] = ()

    @property
    def headline(self) -> str:
        """Name and status in words."""
        words = STATUS_WORDS[self.status]
        return f"{self.name}: {words}" if self.name else words

    def parameter_table(self) -> TextTable:
        """Return the calibrated values with their intervals, and how well they are determined."""
        rows = (self._parameter_cells(name, value) for name, value in self.parameters.items())
        header = ("parameter", "value", "95 % interval", "")
        return TextTable(header, tuple(rows), "" if self.intervals else self._why_no_intervals)

    def _parameter_cells(self, name: str, value: float) -> tuple[str, ...]:
        shown, found = _with_unit(value, self.units.get(name, "")), self.intervals.get(name)
        if found is None:
            return (name, shown, "-", "")
        return (name, shown, plain_ends(found.low, found.high), found.determination)

    @property
    def _why_no_intervals(self) -> str:
        if self.status == "unreachable":
            return "No intervals: no parameter set agrees with the measurements."
        return "No intervals: there are too few runs, or an older version wrote the result."

    def response_table(self) -> TextTable:
        """Return each response: target, expected value, deviation and verdict."""
        rows = (_response_cells(name, found) for name, found in self.responses.items())
        caption = "± tolerance of the target, 95 % confidence of the expected response"
        return TextTable(("response", "target", "expected", "deviation", ""), tuple(rows), caption)

    def curve_table(self) -> TextTable:
        """Return each curve: measured points, components, deviation and verdict."""
        rows = (
            (
                name,
                f"{counted(len(found.measured), 'point')}",
                counted(found.components, "component"),
                f"{found.deviation:.2f} σ",
                found.verdict,
            )
            for name, found in self.curves.items()
        )
        caption = (
            "root mean square deviation of the expected curve, in standard uncertainties σ of the "
            "measured points"
        )
        return TextTable(("curve", "measured", "simulated", "deviation", ""), tuple(rows), caption)

    def tables(self) -> list[TextTable]:
        """Return the tables of parameters, responses and curves, without empty ones."""
        tables = [self.parameter_table()]
        if self.responses or not self.curves:
            tables.append(self.response_table())
        return [*tables, self.curve_table()] if self.curves else tables

    def fresh_seeds(self) -> str:
        """Return the means of the verification runs in one sentence; "" without any."""
        means = [
            f"{name} {plain_interval(found.verified_mean, found.verified_interval)} "
            f"{found.unit}".rstrip()
            for name, found in self.responses.items()
            if found.verified_mean is not None and found.verified_interval is not None
        ]
        means += [f"{name} {found.fresh}" for name, found in self.curves.items() if found.fresh]
        if not means:
            return ""
        counts = [len(found.verified_values) for found in self.responses.values()]
        counts += [found.verified_runs for found in self.curves.values()]
        fewest, most = min(counts), max(counts)
        seeds = counted(most, "fresh seed") if most else "fresh seeds"
        if fewest < most:
            # Each of several tests is verified by itself.
            seeds = f"{fewest} to {seeds}"
        return f"Mean of {seeds} at the answer: {', '.join(means)}."

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the sentences and tables that `print` and a notebook show."""
        parts: list[str | TextTable] = [self.headline, *self.notices]
        if self.parameters:
            parts += self.tables()
            parts += map(str, self.yield_loci)
        if check := self.fresh_seeds():
            parts.append(check)
        if self.probability_all_met is not None:
            chance = plain_probability(self.probability_all_met)
            parts.append(f"Probability that every target is met, by all runs: {chance}.")
        return (*parts, f"DEM runs: {self.runs}.")

    def __str__(self) -> str:
        return as_text(self.summary())

    def _repr_html_(self) -> str:
        return as_html(self.summary())

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data."""
        return asdict(self)

    def to_json(self, path: str | Path) -> None:
        """Write the result to a JSON file atomically."""
        write_atomically(
            Path(path),
            json.dumps(self.to_dict(), indent=2, ensure_ascii=False, allow_nan=False) + "\n",
        )

    @classmethod
    def from_json(cls, path: str | Path) -> Result:
        """Read a result that `to_json` wrote.

        Raises
        ------
        StoreError
            There is no such file, or its content is not a result: it was edited, or written by
            another version of grainfit.

        Examples
        --------
        >>> Result.from_json("beads.grainfit/result.json")  # doctest: +SKIP
        """
        try:
            return _read(read_within(Path(path), LARGEST_RESULT))
        except OSError as error:
            raise StoreError(f"{str(path)!r} cannot be read: {error.strerror}.") from error
        except (ValueError, RecursionError) as error:
            raise StoreError(damaged_result(path, str(error))) from error


def _response_cells(name: str, response: ResponseResult) -> tuple[str, ...]:
    expected, half_width = response.expected
    return (
        name,
        f"{response.target:.5g} ± {response.tolerance:.3g} {response.unit}".rstrip(),
        plain_interval(expected, half_width),
        response.deviation_in_words(response.unit),
        response.verdict,
    )


def _with_unit(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}".rstrip() if isfinite(value) else "-"


def damaged_result(path: str | Path, why: str) -> str:
    """Return the message for a result that can no longer be read."""
    return (
        f"{str(path)!r} is damaged: {why}. Start the calibration again: the file is written again, "
        "and no finished run is repeated."
    )


def _read(text: bytes) -> Result:
    from pydantic import TypeAdapter, ValidationError

    data = json.loads(text, parse_float=_finite, parse_int=_finite, parse_constant=_finite)
    current = json.dumps(_in_current_names(json.loads(text))) if _is_old(data) else text
    try:
        return TypeAdapter(Result).validate_json(current, strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"]))
        raise ValueError(f"{place or 'it'}: {first['msg']}") from error


def _is_old(data: Any) -> bool:
    return isinstance(data, dict) and "agreement" in data


def _in_current_names(data: dict[str, Any]) -> dict[str, Any]:
    renamed = _with_current_keys(data)
    if isinstance(counts := data.get("runs"), dict):
        renamed["runs"] = _with_current_keys(counts)
    if isinstance(responses := data.get("responses"), dict):
        renamed["responses"] = {
            name: _with_verdict(_with_current_keys(found)) if isinstance(found, dict) else found
            for name, found in responses.items()
        }
    return renamed


def _with_verdict(response: dict[str, Any]) -> dict[str, Any]:
    """Return a response of version 0.1.0 with the verdict that its flag stands for.

    It was also false for what was not verified, and for what the verification runs alone met.
    """
    within = response.pop("within_tolerance", None)
    if not isinstance(within, bool):
        return response
    missed = abs(_deviation(response)) > 1.0
    return {"verdict": "met" if within else "missed" if missed else "in doubt", **response}


def _deviation(response: dict[str, Any]) -> float:
    """Return the deviation of the verification runs in tolerances; 0 where it is not known."""
    try:
        return float((response["verified_mean"] - response["target"]) / response["tolerance"])
    except (KeyError, TypeError, ZeroDivisionError):
        return 0.0


def _with_current_keys(data: dict[str, Any]) -> dict[str, Any]:
    return {_RENAMED.get(key, key): value for key, value in data.items()}


def _finite(text: str) -> float:
    # A whole number may also be larger than any floating-point number.
    if not isfinite(value := float(text)):
        raise ValueError(f"{text[:20]} is not a finite number")
    return value


@dataclass(frozen=True)
class MetamodelQuality:
    """Quality of a metamodel, by leave-one-out.

    Parameters
    ----------
    q2 : float or None
        Share of the variance of the responses that is predicted; 1 is perfect. None when the
        responses are all equal.
    coverage : float
        Share of the runs inside their 95 % interval.
    noise : float
        Estimated standard deviation of the response from seed to seed.
    warnings : tuple of str
        Reasons not to trust it, in words; empty when there are none.
    noise_range : pair of float, optional
        Smallest and largest scatter at the runs, where it changes over the intervals.
    has_two_states : bool
        Whether the runs scatter about two values rather than one.
    part : str
        The part of a curve that it is about, in words; empty for a response.
    """

    q2: float | None
    coverage: float
    noise: float
    warnings: tuple[str, ...] = ()
    noise_range: tuple[float, float] | None = None
    has_two_states: bool = False
    part: str = ""


@dataclass(frozen=True)
class CurveMiss:
    """Deviation of an expected curve from a measured one, or from another expected one.

    Parameters
    ----------
    coordinate, coordinate_unit : str
        Name and unit of the coordinate.
    deviation : float
        Root mean square deviation, in standard uncertainties of the measured points.
    points : tuple of (float, float, float)
        Points that deviate most, the worst one first: coordinate, the value that it should have,
        and the one that it has.
    has_other_shape : bool
        Whether no simulated curve has the shape of the measured one.
    """

    coordinate: str
    coordinate_unit: str
    deviation: float
    points: tuple[tuple[float, float, float], ...]
    has_other_shape: bool = False

    def __str__(self) -> str:
        unit = unit_for_people(self.coordinate_unit)
        worst = [
            f"{with_unit(number(place), unit)} ({number(found, 3)} instead of {number(wanted, 3)})"
            for place, wanted, found in self.points
        ]
        return (
            f"deviates by {number(self.deviation, 2)} standard uncertainties of the measured "
            f"points (root mean square), most at {self.coordinate or 'coordinate'} = "
            f"{in_a_row(worst)}"
        )


@dataclass(frozen=True)
class OutOfReach:
    """A target that cannot be met within the intervals.

    Parameters
    ----------
    target : str
        Name of the target.
    value : float
        Its value; of a curve at the point that deviates most, as the next two.
    nearest, standard_error : float
        Nearest expected response within the intervals, and its standard error.
    jointly : bool
        The target could be met alone, but not together with the others.
    parameter, bound, bound_value : str, {"min", "max"}, float, optional
        The bound that is in the way.
    suggestion : float, optional
        A bound that should be enough, by linear extrapolation; None when there is none.
    is_relative : bool
        Whether deviations relative to the value make sense.
    curve : CurveMiss, optional
        Of a target that is a curve.
    """

    target: str
    value: float
    nearest: float
    standard_error: float
    jointly: bool = False
    parameter: str | None = None
    bound: Bound | None = None
    bound_value: float | None = None
    suggestion: float | None = None
    is_relative: bool = True
    curve: CurveMiss | None = None

    @property
    def shortfall_percent(self) -> float | None:
        """Deviation of the nearest response, in percent of the target; None if that is no use."""
        if not self.is_relative or not self.value:
            return None
        return 100 * (self.nearest - self.value) / abs(self.value)

    def __str__(self) -> str:
        together = " together with the other targets" if self.jointly else ""
        words = f"{self._missed(together)}."
        if self.curve is not None and self.curve.has_other_shape:
            # Beyond any bound, curves of these shapes are to be expected.
            return f"{words} No simulated curve has the shape of the measured one."
        if self.parameter is None:
            return f"{words} No single bound is in the way: free another parameter."
        words += f" The bound in the way is {self.parameter}.{self.bound} = {self.bound_value:g}"
        if self.suggestion is None:
            return f"{words}, and no possible value beyond it is enough: free another parameter."
        return f"{words}; try {self.suggestion:g}."

    def _missed(self, together: str) -> str:
        if self.curve is not None:
            return (
                f"{self.target} is out of reach{together}: the nearest curve that the metamodels "
                f"expect within the intervals {self.curve}"
            )
        share = "" if self.shortfall_percent is None else f" ({self.shortfall_percent:+.1f} %)"
        nearest = plain_interval(self.nearest, _NORMAL_QUANTILE * self.standard_error)
        return (
            f"{self.target} = {self.value:g} is out of reach{together}: the nearest that the "
            f"metamodels expect within the intervals is {nearest}{share}"
        )
