"""The material card: values of a calibrated material, how sure they are, and their origin"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from grainfit.materials.sizes import ParticleSizes
from grainfit.one_line import OneLine
from grainfit.verdict.messages import STATUS_WORDS

Origin = Literal["calibrated", "not calibrated", "measured", "given"]
Determination = Literal["determined", "determined, but biased", "narrowed", "not determined"]
_NOT_ENDED = "it was started again and has not come to its end"


@dataclass(frozen=True)
class CardParameter(OneLine):
    """A parameter of the material.

    Parameters
    ----------
    name, symbol, unit, description : str
        As in the calibration file; symbol and description are empty for one of the user's own.
    value : float
        SI.
    origin : {"calibrated", "not calibrated", "measured", "given"}
        Given, or free; if free, whether the calibration met its targets, or whether the parameter
        was free about a measurement of its own.
    interval : pair of float, optional
        95 % credible interval, which holds the value.
    determination : {"determined", "determined, but biased", "narrowed", "not determined"}, optional
        Whether the runs determine it; None without an interval.
    bias : str
        Reason why the value is biased, as far as one is known.
    """

    name: str
    symbol: str
    unit: str
    description: str
    value: float
    origin: Origin
    interval: tuple[float, float] | None = None
    determination: Determination | None = None
    bias: str = ""


@dataclass(frozen=True)
class CardResponse(OneLine):
    """Response of the material in a bulk test, against the measured value.

    Parameters
    ----------
    name, unit : str
        Of the target.
    target, tolerance : float
        Measured value and largest accepted deviation.
    expected : float
        Expected response by all runs.
    interval : pair of float
        95 % interval of the expected value.
    deviation_percent : float, optional
        Of the expected value from the target; None where that makes no sense: zero is within the
        tolerance.
    verdict : {"met", "in doubt", "missed"}
        Whether the expected value is within its tolerance with the demanded probability, outside
        with that probability, or neither.
    verified_mean : float, optional
        Mean of the runs with fresh seeds at the answer, an independent check.
    """

    name: str
    unit: str
    target: float
    tolerance: float
    expected: float
    interval: tuple[float, float]
    deviation_percent: float | None
    verdict: Literal["met", "in doubt", "missed"]
    verified_mean: float | None


@dataclass(frozen=True)
class Program:
    """Program of the runs: ``lammps``, ``liggghts``, or the kind of the user's own model."""

    name: str
    version: str


@dataclass(frozen=True)
class MaterialCard:
    """A calibrated material: its values, their uncertainty and their origin.

    Parameters
    ----------
    name : str
        Name of the calibration.
    status : str
        ``calibrated``, or another end of the calibration.
    parameters : tuple of CardParameter
        The free ones and those that were given, those of `grainfit.contact_models.registry` first.
    responses : tuple of CardResponse
        In the order of the targets.
    sizes : ParticleSizes, optional
        Of the particles, as far as they are known.
    gravity : float
        In the tests, m/s^2.
    rayleigh_time_step, recommended_time_step : float, optional
        s.
    time_step_fraction : float
        Recommended time step over the Rayleigh time step: that of the tests.
    programs : tuple of Program
        Solvers of the calibration.
    runs, failed_runs : int
        Number of DEM runs of the calibration, and of those that gave no responses.
    date : str
        End of the last run, ISO 8601 in UTC; empty when that is not known.
    calibration_file, identity, version : str
        Name of the calibration file (empty when it was started from Python), identity of the
        calibration, and version of grainfit.
    notices : tuple of str
        What the user should know.
    contact_models : tuple of str
        Contact models of the runs; empty for those of a model of the user's own.
    apparatus : tuple of str
        Apparatus of every bulk test, in a laboratory's words: what was given, and what is assumed.
    earlier_runs : int
        Number of further DEM runs, of earlier calibrations, that it began with.
    """

    name: str
    status: str
    parameters: tuple[CardParameter, ...]
    responses: tuple[CardResponse, ...]
    sizes: ParticleSizes | None
    gravity: float
    rayleigh_time_step: float | None
    recommended_time_step: float | None
    time_step_fraction: float
    programs: tuple[Program, ...]
    runs: int
    failed_runs: int
    date: str
    calibration_file: str
    identity: str
    version: str
    notices: tuple[str, ...]
    contact_models: tuple[str, ...] = ()
    apparatus: tuple[str, ...] = ()
    earlier_runs: int = 0

    @property
    def runs_in_words(self) -> str:
        """Numbers of the DEM runs."""
        earlier = f" + {self.earlier_runs} of earlier calibrations" if self.earlier_runs else ""
        failed = f", {self.failed_runs} failed" if self.failed_runs else ""
        return f"{self.runs}{earlier}{failed}"

    @property
    def calibrated(self) -> bool:
        """Whether every target is met and verified."""
        return self.status == "calibrated"

    @property
    def verdict(self) -> str:
        """End of the calibration in words, with the targets that are not met."""
        words = STATUS_WORDS.get(self.status, _NOT_ENDED)
        words = words if self.calibrated else f"NOT CALIBRATED: {words}"
        missed = [
            f"{response.name}, which is in doubt"
            if response.verdict == "in doubt"
            else response.name
            for response in self.responses
            if response.verdict != "met"
        ]
        return f"{words} (not met: {', '.join(missed)})" if missed else words

    @property
    def values(self) -> dict[str, float]:
        """Values of all parameters by name, SI."""
        return {parameter.name: parameter.value for parameter in self.parameters}
