"""Predictions of tests that took no part in the calibration, beside what was measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from grainfit.formatting import (
    counted,
    plain_ends,
    plain_interval,
    plain_probability,
    rounded,
    unit_for_people,
    with_unit,
)
from grainfit.one_line import OneLine
from grainfit.student import NORMAL_QUANTILE
from grainfit.verdict import messages
from grainfit.verdict.holdout import HoldoutVerdict

#: ``pending`` before the first run and after a process that died; ``failed`` without enough runs.
HoldoutState = Literal["simulated", "pending", "interrupted", "not calibrated", "failed"]
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
        interval, prior = (
            with_unit(plain_ends(*ends), unit) for ends in (self.interval, self.prior)
        )
        if self.measured is None or self.verdict is None:
            predicted = with_unit(rounded(self.predicted, self.standard_error), unit)
            return messages.HOLDOUT_EXPECTED(
                name=name, predicted=predicted, interval=interval, prior=prior
            )
        half = NORMAL_QUANTILE * (self.uncertainty or 0.0)
        said = {
            "name": name,
            "measured": with_unit(plain_interval(self.measured, half), unit),
            "interval": interval,
        }
        if self.verdict == "does not tell":
            return messages.HOLDOUT_TELLS_NOTHING(**said, prior=prior)
        probability = plain_probability(self.probability or 0.0)
        if self.verdict == "predicts":
            return messages.HOLDOUT_PREDICTS(**said, probability=probability, prior=prior)
        return messages.HOLDOUT_REFUTED(**said, probability=probability)


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
        Reason where it failed.
    """

    test: str
    state: HoldoutState
    responses: Mapping[str, HoldoutResponse] = field(default_factory=dict)
    registration: Registration | None = None
    basis: Basis = "posterior"
    runs: int = 0
    failed: int = 0
    why: str = ""

    def sentences(self) -> Iterator[str]:
        """Yield what is to be said of it, a sentence for each response first."""
        match self.state:
            case "pending":
                yield messages.HOLDOUT_PENDING(test=self.test)
            case "interrupted":
                yield messages.HOLDOUT_INTERRUPTED(test=self.test)
            case "not calibrated":
                yield messages.HOLDOUT_NOT_CALIBRATED(test=self.test)
            case "failed":
                yield messages.HOLDOUT_FAILED(test=self.test, why=self.why)
        for name, found in self.responses.items():
            yield found.in_words(f"{self.test}.{name}")
        if self.responses and self.basis == "intervals":
            yield messages.HOLDOUT_OF_INTERVALS(test=self.test)
        if self.responses and self.basis == "values":
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
