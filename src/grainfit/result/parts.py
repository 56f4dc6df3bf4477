"""Parts of the result of a calibration: responses, curves, parameters, yield loci, runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from statistics import fmean

from grainfit.evaluation import Response
from grainfit.formatting import (
    counted,
    deviation_off,
    ends,
    number,
    on_curve,
    plain_interval,
    unit_for_people,
    with_unit,
)
from grainfit.materials.card import Determination
from grainfit.one_line import OneLine
from grainfit.student import NORMAL_QUANTILE
from grainfit.verdict.rule import Verdict

#: From this percentage on, the ends of an interval are given instead.
_LARGEST_PERCENTAGE = 50.0


@dataclass(frozen=True)
class ResponseResult(OneLine):
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
        Mean of the verification runs (fresh seeds at the answer) and its standard
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
        Responses of the verification runs.
    verified_seeds : tuple of int
        Their seeds.
    jams_not_excluded : float, optional
        Largest share of jammed runs that as many runs without a jam do not exclude, with a
        confidence of 95 %: ``1 - 0.05 ** (1 / n)``. None where a run jammed.
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
    jams_not_excluded: float | None = None

    def deviation_in_words(self, unit: str) -> str:
        """Return the deviation with its sign: in percent, or in a unit as it is to be shown."""
        return deviation_off(
            self.deviation_percent, self.predicted - self.target, self.tolerance, unit
        )

    @property
    def is_off(self) -> bool:
        """Whether the predicted response is beyond its tolerance."""
        return abs(self.predicted - self.target) > self.tolerance

    @property
    def expected(self) -> tuple[float, float]:
        """Expected response, by all runs, and half of its 95 % interval."""
        if self.probability is None and self.verified_mean is not None and self.verified_interval:
            # Version 0.1.0 predicted it without the verification runs, and gave their mean.
            return self.verified_mean, self.verified_interval
        return self.predicted, NORMAL_QUANTILE * self.standard_error


@dataclass(frozen=True)
class CurveResult(OneLine):
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
        Number of fresh seeds at the answer.
    verified_mean, verified_standard_errors : tuple of float
        Mean curve of at least two fresh seeds at the measured points, and its standard errors;
        empty for fewer.
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
class ParameterInterval(OneLine):
    """95 % interval of a parameter, which holds the answer, and a word for its width.

    Parameters
    ----------
    low, high : float
        Ends, SI; see `grainfit.analysis.intervals.parameter_intervals`.
    determination : {"determined", "determined, but biased", "narrowed", "not determined"}
        Whether the runs determine the parameter: at most a quarter of its interval fits, and
        nothing is known that biases it; the same with a known bias; more; or more than nine tenths.
    bias : str
        Reason why the value is biased, as far as one is known.
    """

    low: float
    high: float
    determination: Determination
    bias: str = ""

    @property
    def is_determined(self) -> bool:
        """Whether the runs determine the parameter, biased or not."""
        return self.determination in ("determined", "determined, but biased")

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
        >>> soft = "soft particles raise bulk_density by about 14 %"
        >>> ParameterInterval(0.59, 0.61, "determined, but biased", soft).in_words(0.6)
        'determined to ±1.7 %, but biased: soft particles raise bulk_density by about 14 %'
        """
        between = with_unit(ends(self.low, self.high), unit_for_people(unit))
        if self.determination == "narrowed":
            return f"only narrowed, {between}{self._but_biased}"
        if not self.is_determined:
            return f"{self.determination}, {between}"
        share = self.percentage(value)
        words = f"determined to {share}" if share else f"determined, {between}"
        return f"{words}{self._but_biased}"

    @property
    def _but_biased(self) -> str:
        return f", but biased: {self.bias}" if self.bias else ""


@dataclass(frozen=True)
class YieldLocus(OneLine):
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
class YieldLocusResult(OneLine):
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
    calibration), or came from a process that shares the store, and were not simulated here;
    ``failed`` of them gave no responses. In addition,
    there was a warm start from ``warm_start_runs`` earlier runs of other calibrations. With smaller
    apparatus for real ones, those of all searches count, and ``sizes`` are those that compare
    sizes, or are at full size.
    """

    design: int = 0
    optimisation: int = 0
    verification: int = 0
    failed: int = 0
    reused: int = 0
    total: int = 0
    warm_start_runs: int = 0
    sizes: int = 0

    def __str__(self) -> str:
        earlier = self.warm_start_runs
        sizes = f" + {self.sizes} of other sizes" if self.sizes else ""
        warm = f", warm start from {counted(earlier, 'earlier run')}" if earlier else ""
        return (
            f"{self.total} = {self.design} design + {self.optimisation} optimisation + "
            f"{self.verification} verification{sizes}; {self.failed} failed, "
            f"{self.reused} reused{warm}"
        )


@dataclass(frozen=True)
class RunSummary(OneLine):
    """One parameter set that was simulated."""

    stage: str
    parameters: Mapping[str, float]
    seed: int
    responses: Mapping[str, float]
    failures: Mapping[str, str]
    runs: Mapping[str, str]


@dataclass(frozen=True)
class MetamodelQuality(OneLine):
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
