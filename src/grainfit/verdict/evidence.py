"""Numbers that the rule reads: what all runs predict at an answer, and what fresh seeds gave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from grainfit.verdict.out_of_reach import CurveMiss, OutOfReach
from grainfit.verdict.reasons import NoisyCurve, NoRecordThere, OutlyingRuns


@dataclass(frozen=True)
class Verified:
    """Mean of a response over the verification runs.

    Parameters
    ----------
    mean, standard_error : float
        Over the runs.
    half_width : float
        Half of the 95 % confidence interval of the mean (Student's t); 0 for a single run of a
        deterministic model.
    runs : int
        Number of runs.
    """

    mean: float
    standard_error: float
    half_width: float
    runs: int


@dataclass(frozen=True)
class Expected:
    """Response that metamodels expect.

    Parameters
    ----------
    mean, standard_error : float
        The expectation and its standard error.
    """

    mean: float
    standard_error: float


@dataclass(frozen=True)
class Scatter:
    """Standard deviation between runs that differ in their seed only, by these runs alone.

    Parameters
    ----------
    standard_deviation : float
        Pooled over all parameter sets that were run more than once.
    freedom : int
        Its degrees of freedom.
    """

    standard_deviation: float
    freedom: int


@dataclass(frozen=True)
class TargetEvidence:
    """Prediction at the answer for a target, or for a component of a curve.

    Parameters
    ----------
    name, unit : str
        Name and unit of the target.
    value, tolerance : float
        Measured value and largest accepted deviation.
    is_relative : bool
        Whether deviations relative to the value make sense.
    expected, standard_error : float
        Expected response by all runs, and its standard error.
    probability : float
        Probability that the expected response is within its tolerance.
    noise : float, optional
        Standard deviation of an evaluation at the answer; None where it is not known.
    fresh : Verified, optional
        Mean of at least two fresh seeds; of a deterministic model, the response itself.
    others : Expected, optional
        What the runs without the fresh seeds lead to expect; None where they are too few.
    repeated : Scatter, optional
        Scatter of runs with equal parameters; None where there are none.
    fresh_seeds : int
        Number of fresh seeds that gave the response.
    test : str
        Name of its test.
    repeats : int
        Runs with different seeds whose mean is one evaluation.
    noise_range : pair of float, optional
        Smallest and largest noise at the runs, where it changes over the intervals.
    has_two_states : bool
        Whether the runs scatter about two values rather than one.
    outlying : OutlyingRuns, optional
        Outlying runs, if there are any.
    curve : str
        Curve of which it is a component; empty for a response.
    is_deterministic : bool
        Whether the model gives the same for every seed.
    has_trend : bool
        Whether the runs are enough to tell a trend from chance; if not, ``noise`` may be one.
    """

    name: str
    unit: str
    value: float
    tolerance: float
    is_relative: bool
    expected: float
    standard_error: float
    probability: float
    noise: float | None
    fresh: Verified | None = None
    others: Expected | None = None
    repeated: Scatter | None = None
    fresh_seeds: int = 0
    test: str = ""
    repeats: int = 1
    noise_range: tuple[float, float] | None = None
    has_two_states: bool = False
    outlying: OutlyingRuns | None = None
    curve: str = ""
    is_deterministic: bool = False
    has_trend: bool = True

    @property
    def is_off(self) -> bool:
        """Whether the expected response is beyond its tolerance."""
        return abs(self.expected - self.value) > self.tolerance

    @property
    def known_noise(self) -> float | None:
        """Standard deviation of an evaluation; None where it may as well be a trend."""
        if self.has_trend:
            return self.noise
        return None if self.repeated is None else self.repeated.standard_deviation


@dataclass(frozen=True)
class CurveEvidence:
    """Prediction at the answer for a measured curve, whose components are targets.

    Parameters
    ----------
    name : str
        Name of the curve.
    has_other_shape : bool
        Whether no simulated curve has the measured shape.
    shape_probability : float
        Probability of the rest that no simulated curve has, if the errors are as stated.
    noise : NoisyCurve, optional
        Scatter of an evaluation, at the measured points.
    fresh_miss : CurveMiss, optional
        Deviation of the mean of the fresh seeds from the expected curve.
    """

    name: str
    has_other_shape: bool
    shape_probability: float
    noise: NoisyCurve | None = None
    fresh_miss: CurveMiss | None = None


@dataclass(frozen=True)
class Evidence:
    """All numbers on which the verdict on an answer rests.

    Parameters
    ----------
    targets : sequence of TargetEvidence
        Responses and components of curves, in the order of the targets.
    curves : sequence of CurveEvidence
        Measured curves.
    out_of_reach : sequence of OutOfReach
        Targets that no parameter set within the intervals meets.
    probability_all_met, probability_without_outliers : float
        Probability that every expected response is within its tolerance, by all runs and by those
        that are no outliers.
    confidence : float
        Probability from which a target counts as met.
    fewest_fresh : int
        Number of fresh seeds without which no answer is calibrated.
    runs_needed : int
        Estimated number of further evaluations at the answer that would make it certain enough.
    failed, ended : int
        Number of failed runs and of all: those at the answer, or of the search without any.
    is_verified : bool
        Whether these are runs at the answer.
    correlated : sequence of str
        Targets with correlated errors.
    tests : mapping of str to sequence of str
        Targets by name of the test.
    has_several_tests : bool
        Whether tests are simulated one by one.
    no_record : sequence of NoRecordThere
        Tests whose runs are read from a table that has none at the answer.
    repeats_records : bool
        Whether runs at the answer have read rows that were read before.
    deterministic : sequence of str
        Tests, as in ``tests``, whose model gives the same for every seed: one run tells all.
    """

    targets: Sequence[TargetEvidence]
    curves: Sequence[CurveEvidence]
    out_of_reach: Sequence[OutOfReach]
    probability_all_met: float
    probability_without_outliers: float
    confidence: float
    fewest_fresh: int
    runs_needed: int
    failed: int
    ended: int
    is_verified: bool
    correlated: Sequence[str]
    tests: Mapping[str, Sequence[str]]
    has_several_tests: bool
    no_record: Sequence[NoRecordThere] = ()
    repeats_records: bool = False
    deterministic: Sequence[str] = ()

    @property
    def fresh_seeds(self) -> int:
        """Number of fresh seeds that gave every response."""
        return min((one.fresh_seeds for one in self.targets), default=0)
