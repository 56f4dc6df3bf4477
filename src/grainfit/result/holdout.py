"""Predictions of tests that took no part in the calibration, beside what was measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from grainfit.formatting import (
    counted,
    ends,
    interval,
    on_curve,
    plain_probability,
    rounded,
    unit_for_people,
    with_unit,
)
from grainfit.one_line import OneLine
from grainfit.result import messages as of_file
from grainfit.student import NORMAL_QUANTILE
from grainfit.verdict import messages
from grainfit.verdict.holdout import HoldoutVerdict

#: ``pending`` before the first run and after a process that died; ``failed`` without enough runs.
HoldoutState = Literal["simulated", "pending", "interrupted", "not calibrated", "failed"]
#: Stage in which hold-outs are simulated: the calibration has its verdict.
HOLDOUT_STAGE = "hold-out"
#: What the interval of a prediction rests on, see `HoldoutResult`.
Basis = Literal["posterior", "intervals", "values"]


@dataclass(frozen=True)
class Registration(OneLine):
    """Record that the targets of a hold-out were fixed, and when.

    Parameters
    ----------
    date : str
        When they were registered, ISO 8601 in UTC.
    runs : int
        Runs of the work folder that were finished then; 0 before the first one.
    targets_hash : str
        SHA-256 of the targets.
    file_hash : str
        SHA-256 of the calibration file; empty when started from Python.
    changed : str
        When other targets were registered last, ISO 8601 in UTC; empty if never.
    """

    date: str
    runs: int
    targets_hash: str
    file_hash: str = ""
    changed: str = ""


@dataclass(frozen=True)
class HoldoutResponse(OneLine):
    """A response that took no part in the fit: what is expected, and what was measured.

    Parameters
    ----------
    unit : str
        Unit of all these numbers.
    predicted, standard_error : float
        Expected response, the mean over seeds, and its standard error by the uncertainty of the
        parameters and of the runs.
    interval : pair of float
        95 % interval of a measurement: that of the response, with the uncertainty of the measured
        value where there is one.
    prior : pair of float
        95 % interval of the expected response over the intervals of the parameters.
    at_answer, over_posterior, over_prior : tuple of float
        Responses of the runs.
    measured, uncertainty : float, optional
        Measured value and its standard uncertainty.
    probability : float, optional
        Probability of a measured value as far from the prediction, if this is right.
    verdict : {"predicts", "does not predict", "does not tell"}, optional
        None without a measured value.
    """

    unit: str
    predicted: float
    standard_error: float
    interval: tuple[float, float]
    prior: tuple[float, float]
    at_answer: tuple[float, ...] = ()
    over_posterior: tuple[float, ...] = ()
    over_prior: tuple[float, ...] = ()
    measured: float | None = None
    uncertainty: float | None = None
    probability: float | None = None
    verdict: HoldoutVerdict | None = None

    def in_words(self, name: str) -> str:
        """Return prediction, measured value and verdict in a sentence."""
        unit = unit_for_people(self.unit)
        within, prior = (with_unit(ends(*pair), unit) for pair in (self.interval, self.prior))
        if self.measured is None or self.verdict is None:
            predicted = with_unit(rounded(self.predicted, self.standard_error), unit)
            return messages.HOLDOUT_EXPECTED(
                name=name, predicted=predicted, interval=within, prior=prior
            )
        half = NORMAL_QUANTILE * (self.uncertainty or 0.0)
        said = {
            "name": name,
            "measured": with_unit(interval(self.measured, half), unit),
            "interval": within,
        }
        if self.verdict == "does not tell":
            return messages.HOLDOUT_TELLS_NOTHING(**said, prior=prior)
        probability = plain_probability(self.probability or 0.0)
        if self.verdict == "predicts":
            return messages.HOLDOUT_PREDICTS(**said, probability=probability, prior=prior)
        return messages.HOLDOUT_REFUTED(**said, probability=probability)


@dataclass(frozen=True)
class HoldoutCurve(OneLine):
    """A curve that took no part in the fit: what is expected, and what was measured.

    All tuples have one entry for each measured point. A band is as many standard deviations wide
    everywhere, so that 95 % of the curves lie within it wholly.

    Parameters
    ----------
    coordinate, coordinate_unit, unit : str
        Name and unit of the coordinate, and unit of the values.
    coordinates : tuple of float
        Measured coordinates.
    predicted, standard_errors : tuple of float
        Expected curve, the mean over seeds, and its standard errors by the uncertainty of the
        parameters and of the runs.
    low, high : tuple of float
        Band of the curves as they could have been measured.
    prior_low, prior_high : tuple of float
        Band of the expected curves over the intervals of the parameters.
    at_answer : tuple of tuple of float
        Curves of the runs at the answer.
    measured, uncertainties : tuple of float
        Measured values and their standard uncertainties.
    probability : float
        Probability of a measured curve whose farthest point is as far from the prediction, in
        standard deviations, if this is right.
    verdict : {"predicts", "does not predict", "does not tell"}
        As of a response.
    """

    coordinate: str
    coordinate_unit: str
    unit: str
    coordinates: tuple[float, ...]
    predicted: tuple[float, ...]
    standard_errors: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    prior_low: tuple[float, ...]
    prior_high: tuple[float, ...]
    at_answer: tuple[tuple[float, ...], ...]
    measured: tuple[float, ...]
    uncertainties: tuple[float, ...]
    probability: float
    verdict: HoldoutVerdict

    @property
    def share_of_prior(self) -> float:
        """Mean width of the band, over that before the calibration."""
        before = sum(self.prior_high) - sum(self.prior_low)
        return (sum(self.high) - sum(self.low)) / before

    @property
    def deviations(self) -> tuple[float, ...]:
        """Deviations of the measured points from the middle of the band, over half its width."""
        band = zip(self.low, self.high, strict=True)
        return tuple(
            (2 * value - low - high) / (high - low)
            for value, (low, high) in zip(self.measured, band, strict=True)
        )

    @property
    def farthest(self) -> int:
        """Position of the measured point that deviates most."""
        off = [abs(one) for one in self.deviations]
        return off.index(max(off))

    def in_words(self, name: str) -> str:
        """Return prediction, farthest measured point and verdict in sentences."""
        at, unit = self.farthest, unit_for_people(self.unit)
        half = NORMAL_QUANTILE * self.uncertainties[at]
        said = {
            "name": name,
            "points": counted(len(self.measured), "point"),
            "place": on_curve(self.coordinates[at], self.coordinate, self.coordinate_unit),
            "measured": with_unit(interval(self.measured[at], half), unit),
            "interval": with_unit(ends(self.low[at], self.high[at]), unit),
        }
        share = f"{self.share_of_prior:.2g}"
        if self.verdict == "does not tell":
            return messages.HOLDOUT_CURVE_TELLS_NOTHING(**said, share=share)
        said["probability"] = plain_probability(self.probability)
        if self.verdict == "predicts":
            return messages.HOLDOUT_CURVE_PREDICTED(**said, share=share)
        outside = sum(abs(one) > 1 for one in self.deviations)
        return messages.HOLDOUT_CURVE_REFUTED(**said, outside=outside)


@dataclass(frozen=True)
class HoldoutResult(OneLine):
    """Prediction of a test that took no part in the calibration.

    Parameters
    ----------
    test : str
        Name of the test.
    state : {"simulated", "pending", "interrupted", "not calibrated", "failed"}
        Whether it was simulated, and else why not.
    responses : mapping of str to HoldoutResponse
        By name of the response; empty unless it was simulated.
    registration : Registration, optional
        When its targets were registered; None without targets.
    basis : {"posterior", "intervals", "values"}
        What the interval rests on: parameter sets that agree with the fitted tests, intervals of
        the parameters as if they were independent, or values as if they were exact.
    runs, failed : int
        Number of its runs, and of those that failed.
    why : str
        Reason where it failed, or why some of its runs did.
    curves : mapping of str to HoldoutCurve
        By name of the measured curve.
    """

    test: str
    state: HoldoutState
    responses: Mapping[str, HoldoutResponse] = field(default_factory=dict)
    registration: Registration | None = None
    basis: Basis = "posterior"
    runs: int = 0
    failed: int = 0
    why: str = ""
    curves: Mapping[str, HoldoutCurve] = field(default_factory=dict)

    @property
    def predictions(self) -> dict[str, HoldoutResponse | HoldoutCurve]:
        """All that was predicted, numbers first."""
        return {**self.responses, **self.curves}

    @property
    def is_refuted(self) -> bool:
        """Whether a measured value or curve is not predicted."""
        return any(found.verdict == "does not predict" for found in self.predictions.values())

    def sentences(self) -> Iterator[str]:
        """Yield what is to be said of it, each prediction first."""
        match self.state:
            case "pending":
                yield messages.HOLDOUT_PENDING(test=self.test)
            case "interrupted":
                yield messages.HOLDOUT_INTERRUPTED(test=self.test)
            case "not calibrated":
                yield messages.HOLDOUT_NOT_CALIBRATED(test=self.test)
            case "failed":
                yield messages.HOLDOUT_FAILED(test=self.test, why=self.why)
        for name, found in self.predictions.items():
            yield found.in_words(f"{self.test}.{name}")
        if self.predictions and self.failed:
            said = {"failed": self.failed, "runs": counted(self.runs, "run")}
            yield messages.HOLDOUT_SOME_FAILED(test=self.test, why=self.why, **said)
        if self.predictions and self.basis == "intervals":
            yield messages.HOLDOUT_OF_INTERVALS(test=self.test)
        if self.predictions and self.basis == "values":
            yield messages.HOLDOUT_OF_VALUES(test=self.test)
        yield from self._about_registration()

    def _about_registration(self) -> Iterator[str]:
        known = self.registration
        if known is not None and known.runs:
            runs = counted(known.runs, "run")
            yield messages.HOLDOUT_LATE(test=self.test, date=known.date, runs=runs)
        if known is not None and known.changed:
            yield messages.HOLDOUT_CHANGED(test=self.test, changed=known.changed, date=known.date)

    def __str__(self) -> str:
        return " ".join(self.sentences())


def holdouts_in_short(holdouts: Sequence[HoldoutResult]) -> str:
    """Return in one sentence how hold-outs ended, what is not predicted first; "" if none did.

    Parameters
    ----------
    holdouts : sequence of HoldoutResult
        The hold-outs. Those that are compared with nothing, or were not to be simulated, are left
        out.
    """
    verdicts = [
        (f"{one.test}.{name}", found.verdict)
        for one in holdouts
        for name, found in one.predictions.items()
    ]
    words = messages.HOLDOUT_WORDS.items()
    found = [f"{name} {said}" for key, said in words for name, own in verdicts if own == key]
    states = messages.HOLDOUT_STATES
    found += [f"{one.test}: {states[one.state]}" for one in holdouts if one.state in states]
    return messages.HOLDOUTS_IN_SHORT(found="; ".join(found)) if found else ""


def runs_of_holdouts(holdouts: Sequence[HoldoutResult]) -> str:
    """Return the number of runs of hold-outs, and of those that failed, in words; "" if none.

    Parameters
    ----------
    holdouts : sequence of HoldoutResult
        The hold-outs.
    """
    runs, failed = sum(one.runs for one in holdouts), sum(one.failed for one in holdouts)
    return of_file.HOLDOUT_RUNS(runs=counted(runs, "run"), failed=failed) if runs else ""
