"""Reasons for a verdict as data: each has a kind and its numbers, and says itself in words."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

from grainfit.formatting import (
    counted,
    duration,
    in_a_row,
    number,
    on_curve,
    plain_interval,
    plain_probability,
    rounded,
    unit_for_people,
    with_unit,
)
from grainfit.messages import Message
from grainfit.verdict import messages
from grainfit.verdict.out_of_reach import CurveMiss

#: Most seeds of outlying runs in one sentence.
_MOST_SEEDS = 5


class Reason:
    """Reason for a verdict: a frozen dataclass of its numbers, whose `str` is its message."""

    #: Name in result.json.
    kind: ClassVar[str]
    #: Whether the message gives the probability that every target is met.
    gives_probability: ClassVar[bool] = False

    def to_json(self) -> dict[str, Any]:
        """Return the kind and the numbers as plain data."""
        return {"kind": self.kind, **asdict(self)}  # type: ignore[call-overload]


@dataclass(frozen=True)
class Contradicted(Reason):
    """Fresh seeds at the answer contradict what all runs predict for a response."""

    target: str
    unit: str
    mean: float
    half_width: float
    runs: int
    expected: float
    kind = "contradicted"

    def __str__(self) -> str:
        unit = unit_for_people(self.unit)
        expected = with_unit(number(self.expected, 4), unit)
        if self.runs == 1:
            found = with_unit(number(self.mean, 4), unit)
            return messages.MISSED_BY_RUN(target=self.target, found=found, expected=expected)
        return messages.CONTRADICTED(
            target=self.target,
            runs=counted(self.runs, "fresh seed"),
            mean=rounded(self.mean, self.half_width),
            expected=expected,
        )


@dataclass(frozen=True)
class CurveContradicted(Reason):
    """Fresh seeds at the answer contradict the curve that all runs predict."""

    curve: str
    runs: int
    miss: CurveMiss
    kind = "curve contradicted"

    def __str__(self) -> str:
        return messages.CURVE_CONTRADICTED(
            curve=self.curve, runs=counted(self.runs, "fresh seed"), miss=self.miss
        )


@dataclass(frozen=True)
class NotTogether(Reason):
    """Correlated targets are met one by one, but not together."""

    targets: tuple[str, ...]
    kind = "not together"

    def __str__(self) -> str:
        return messages.NOT_TOGETHER(targets=in_a_row(self.targets))


@dataclass(frozen=True)
class OtherShape(Reason):
    """No simulated curve has the shape of the measured one."""

    curve: str
    probability: float
    kind = "other shape"

    def __str__(self) -> str:
        chance = plain_probability(self.probability)
        return messages.OTHER_SHAPE(curve=self.curve, probability=chance)


@dataclass(frozen=True)
class OutlyingRuns(Reason):
    """Some runs deviate from the others by more than scatter explains, at most by ``largest``.

    Of those whose parameters were run again with another seed, ``repeated``, some came out like
    that again: there the response is another. The rest are jams.
    """

    target: str
    unit: str
    runs: int
    seeds: tuple[int, ...]
    largest: float
    repeated: int = 0
    came_again: int = 0
    kind = "outlying runs"

    def __str__(self) -> str:
        seeds = ", ".join(map(str, self.seeds[:_MOST_SEEDS]))
        return messages.OUTLYING_RUNS(
            target=self.target,
            outlying=counted(len(self.seeds), "outlying run"),
            runs=self.runs,
            seeds=f"{seeds}, ..." if len(self.seeds) > _MOST_SEEDS else seeds,
            away=with_unit(number(abs(self.largest), 3), unit_for_people(self.unit)),
            side="above" if self.largest > 0 else "below",
            again=self._again(),
        )

    def _again(self) -> str:
        if not self.repeated:
            return ""
        return messages.RUN_AGAIN(repeated=self.repeated, came_again=self.came_again or "none")


@dataclass(frozen=True)
class ScatterChanges(Reason):
    """The scatter from run to run changes over the intervals."""

    target: str
    unit: str
    low: float
    high: float
    here: float
    kind = "scatter changes"

    def __str__(self) -> str:
        low, high, here = (number(one, 2) for one in (self.low, self.high, self.here))
        high = with_unit(high, unit_for_people(self.unit))
        return messages.SCATTER_CHANGES(target=self.target, low=low, high=high, here=here)


@dataclass(frozen=True)
class TwoStates(Reason):
    """The runs scatter about two values rather than one."""

    target: str
    kind = "two states"

    def __str__(self) -> str:
        return messages.TWO_STATES(target=self.target)


@dataclass(frozen=True)
class UselessScatter(Reason):
    """Single runs scatter by several times the tolerance; ``value`` is None for other deviations.

    Parameters
    ----------
    target, unit : str
        Name and unit of the target.
    scatter, tolerance : float
        Standard deviation of single runs, and largest accepted deviation.
    value : float, optional
        Measured value where deviations relative to it make sense.
    """

    target: str
    unit: str
    scatter: float
    tolerance: float
    value: float | None
    kind = "useless scatter"

    def __str__(self) -> str:
        return messages.USELESS_SCATTER(
            target=self.target,
            scatter=self._shown(self.scatter),
            tolerance=self._shown(self.tolerance),
            runs=math.ceil((self.scatter / self.tolerance) ** 2),
        )

    def _shown(self, deviation: float) -> str:
        if self.value is not None:
            return f"{number(100 * deviation / abs(self.value), 2)} %"
        return with_unit(number(deviation, 2), unit_for_people(self.unit))


@dataclass(frozen=True)
class OutliersDecide(Reason):
    """The verdict depends on whether outlying runs count."""

    with_all: float
    without: float
    kind = "outliers decide"
    gives_probability = True

    def __str__(self) -> str:
        return messages.OUTLIERS_DECIDE(
            with_all=plain_probability(self.with_all), without=plain_probability(self.without)
        )


@dataclass(frozen=True)
class FreshSeedsMissing(Reason):
    """There are fewer fresh seeds at the answer than demanded.

    Parameters
    ----------
    made, wanted : int
        Number of fresh seeds that gave every response, and the demanded one.
    failed, ended : int
        Number of failed runs at the answer, and of all; 0 where none was made.
    """

    made: int
    wanted: int
    failed: int
    ended: int
    kind = "fresh seeds missing"

    def __str__(self) -> str:
        if not self.failed:
            return messages.FRESH_SEEDS_NOT_MADE(made=self.made, wanted=self.wanted)
        return messages.FRESH_SEEDS_FAILED(
            made=self.made,
            wanted=self.wanted,
            failed=self.failed,
            ended=counted(self.ended, "run"),
        )


@dataclass(frozen=True)
class NoRecordThere(Reason):
    """A table has no row at the answer, so that no run there can be read.

    Parameters
    ----------
    test : str
        Name of the test; empty for the only one.
    record, there : str
        Place of the nearest row in the table, and its parameters with their units.
    """

    test: str
    record: str
    there: str
    kind = "no record there"

    def __str__(self) -> str:
        of_test = f" of {self.test}" if self.test else ""
        return messages.NO_RECORD_THERE(of_test=of_test, record=self.record, there=self.there)


@dataclass(frozen=True)
class RecordsRepeated(Reason):
    """Runs with fresh seeds have read rows of a table that other runs had read.

    Parameters
    ----------
    made, wanted : int
        Number of fresh seeds that read a row of their own, and the demanded one.
    """

    made: int
    wanted: int
    kind = "records repeated"

    def __str__(self) -> str:
        return messages.RECORDS_REPEATED(made=self.made, wanted=self.wanted)


@dataclass(frozen=True)
class Deterministic(Reason):
    """The model of a test gives the same for every seed: one run tells all that it has to tell.

    Parameters
    ----------
    test : str
        Name of the test; empty for the only one.
    """

    test: str
    kind = "deterministic"

    def __str__(self) -> str:
        return messages.DETERMINISTIC(of_test=f" of {self.test}" if self.test else "")


@dataclass(frozen=True)
class _InDoubt:
    """Responses that are in doubt for one reason, which its message says.

    Parameters
    ----------
    targets : tuple of str
        Their names.
    probability, confidence : float
        Probability that every target is met, and the demanded one.
    """

    targets: tuple[str, ...]
    probability: float
    confidence: float
    gives_probability: ClassVar[bool] = True
    message: ClassVar[Message]

    def __str__(self) -> str:
        return self.message(
            targets=in_a_row(self.targets),
            probability=plain_probability(self.probability),
            confidence=plain_probability(self.confidence),
        )


class DeterministicInDoubt(_InDoubt, Reason):
    """Responses of deterministic models of which too few parameter sets are known."""

    kind = "deterministic in doubt"
    message = messages.DETERMINISTIC_IN_DOUBT


class TooFewRuns(_InDoubt, Reason):
    """Responses of which too few runs are known to tell a trend from scatter."""

    kind = "too few runs"
    message = messages.TOO_FEW_RUNS


@dataclass(frozen=True)
class NoisyResponse:
    """Scatter of an evaluation, with the tolerance."""

    target: str
    scatter: float
    tolerance: float

    def __str__(self) -> str:
        scatter, tolerance = number(self.scatter, 2), number(self.tolerance, 2)
        return messages.NOISY_RESPONSE(target=self.target, scatter=scatter, tolerance=tolerance)


@dataclass(frozen=True)
class NoisyCurve:
    """Scatter of a curve in standard uncertainties, and the coordinate where it is largest."""

    curve: str
    ratio: float
    at: float
    coordinate: str
    coordinate_unit: str

    def __str__(self) -> str:
        place = on_curve(self.at, self.coordinate, self.coordinate_unit)
        return messages.NOISY_CURVE(curve=self.curve, ratio=number(self.ratio, 2), place=place)


@dataclass(frozen=True)
class AtEdge:
    """A response that is expected at the edge of its tolerance, in tolerances."""

    target: str
    deviation: float
    standard_error: float

    def __str__(self) -> str:
        return messages.AT_EDGE(
            target=self.target,
            deviation=number(self.deviation, 2),
            error=number(self.standard_error, 1),
        )


@dataclass(frozen=True)
class OnTheEdge(Reason):
    """The best that can be had lies on the edge of the tolerance, or beyond it.

    Parameters
    ----------
    probability, confidence : float
        Probability that every target is met, and the demanded one.
    responses : tuple of AtEdge
        Responses in doubt.
    is_beyond : bool
        Whether one of them is expected clearly beyond its tolerance.
    """

    probability: float
    confidence: float
    responses: tuple[AtEdge, ...]
    is_beyond: bool
    kind = "on the edge"
    gives_probability = True

    def __str__(self) -> str:
        return messages.ON_THE_EDGE(
            probability=plain_probability(self.probability),
            confidence=plain_probability(self.confidence),
            where="beyond" if self.is_beyond else "on",
            responses=", ".join(map(str, self.responses)),
        )


@dataclass(frozen=True)
class TooMuchScatter(Reason):
    """The runs scatter too much to tell whether every target is met.

    Parameters
    ----------
    probability, confidence : float
        Probability that every target is met, and the demanded one.
    runs_needed : int
        Successful runs at the answer that would make it certain enough.
    repeats : int
        Runs whose mean is one evaluation.
    failed, ended : int
        Number of failed runs and of all.
    is_verified : bool
        Whether these are runs at the answer, or of the search.
    responses, curves : tuple of NoisyResponse, tuple of NoisyCurve
        Scatter of what is in doubt.
    """

    probability: float
    confidence: float
    runs_needed: int
    repeats: int
    failed: int
    ended: int
    is_verified: bool
    responses: tuple[NoisyResponse, ...]
    curves: tuple[NoisyCurve, ...]
    kind = "too much scatter"
    gives_probability = True

    def __str__(self) -> str:
        a_curve = "A larger uncertainty of the measured points"
        return messages.TOO_MUCH_SCATTER(
            probability=plain_probability(self.probability),
            confidence=plain_probability(self.confidence),
            runs=self._runs(),
            one="one run" if self.repeats == 1 else f"one mean of {self.repeats} runs",
            scatter=", ".join(map(str, [*self.responses, *self.curves])),
            wider="A wider tolerance" if self.responses else a_curve,
        )

    def _runs(self) -> str:
        """Say how many runs would give the successful ones; failing runs count, too."""
        if not self.failed:
            return messages.RUNS_NEEDED(runs=counted(self.runs_needed, "more run"))
        ended = counted(self.ended, "run")
        where = "there" if self.is_verified else "in the search"
        if self.failed == self.ended:
            runs = counted(self.runs_needed, "more run")
            return messages.RUNS_NEEDED_ALL_FAIL(
                runs=runs, failed=self.failed, ended=ended, where=where
            )
        runs = counted(
            math.ceil(self.runs_needed * self.ended / (self.ended - self.failed)), "more run"
        )
        return messages.RUNS_NEEDED_OF_FAILING(
            runs=runs, failed=self.failed, ended=ended, where=where
        )


@dataclass(frozen=True)
class RealTest:
    """Test of which a smaller apparatus is simulated.

    Parameters
    ----------
    test : str
        Its name.
    particles, simulated : int
        Number of particles in the laboratory's apparatus, and in the one that is simulated.
    seconds : float, optional
        Estimated wall time of a run of the laboratory's, s.
    """

    test: str
    particles: int
    simulated: int
    seconds: float | None = None

    def __str__(self) -> str:
        return messages.REAL_TEST(
            test=self.test,
            particles=f"{self.particles:,}",
            simulated=f"{self.simulated:,}",
            time="a time that is not known"
            if self.seconds is None
            else f"about {duration(self.seconds)}",
        )


@dataclass(frozen=True)
class FullSizePending(Reason):
    """Smaller apparatus were simulated, and no run of the laboratory's was made.

    ``is_measured`` says whether a series of sizes at the answer led to the prediction.
    """

    tests: tuple[RealTest, ...]
    is_measured: bool = True
    kind = "full size pending"

    def __str__(self) -> str:
        pending = messages.FULL_SIZE_PENDING(tests=in_a_row(map(str, self.tests)))
        return pending if self.is_measured else f"{messages.NOT_MEASURED()} {pending}"


@dataclass(frozen=True)
class FullSizeMade(Reason):
    """A run of the laboratory's apparatus beside the prediction, with their 95 % intervals.

    That of the run is by the scatter of the smaller ones.
    """

    target: str
    unit: str
    found: float
    half_width: float
    predicted: float
    predicted_half_width: float
    kind = "full size"

    @property
    def agrees(self) -> bool:
        """Whether both agree within their intervals."""
        allowed = math.hypot(self.half_width, self.predicted_half_width)
        return abs(self.found - self.predicted) <= allowed

    def __str__(self) -> str:
        message = messages.FULL_SIZE_AGREES if self.agrees else messages.FULL_SIZE_DIFFERS
        unit = unit_for_people(self.unit)
        return message(
            target=self.target,
            found=with_unit(plain_interval(self.found, self.half_width), unit),
            predicted=with_unit(plain_interval(self.predicted, self.predicted_half_width), unit),
        )


@dataclass(frozen=True)
class FullSizeFailed(Reason):
    """A run of the laboratory's apparatus failed."""

    test: str
    why: str
    kind = "full size failed"

    def __str__(self) -> str:
        return messages.FULL_SIZE_FAILED(test=self.test, why=self.why)


#: Kinds of reasons by their names in result.json.
KINDS: dict[str, type[Reason]] = {one.kind: one for one in Reason.__subclasses__()}
