"""Tests that could be measured: their responses, with slopes and accuracies."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.solvers.base import Solver
from grainfit.which_test.knowledge import Knowledge

#: Returns the accuracy of a response of a test, by their names; None if it is not measured.
AccuracyOf = Callable[[str, str, ResponseInfo], Accuracy | None]
#: Runs whose mean scatters as the expected response at the end of a calibration does.
RUNS = 5


@dataclass(frozen=True)
class CandidateResponse:
    """A response that a laboratory can measure.

    Parameters
    ----------
    name : str
        Name of the response, with that of its test.
    value : float
        Expected value, in its unit.
    accuracy : Accuracy
        Of its measurement.
    slopes : mapping of str to float
        d ln y / d ln p by name of the parameter; 0 for those that are not named.
    scatter : float
        Relative standard deviation from run to run; a calibration averages it over `RUNS` runs.
    slope_variance : float
        Relative variance that the uncertainty of the slopes adds.
    unit : str
        Its unit.
    """

    name: str
    value: float
    accuracy: Accuracy
    slopes: Mapping[str, float]
    scatter: float
    slope_variance: float = 0.0
    unit: str = ""

    @property
    def short_name(self) -> str:
        """Name of the response without that of its test."""
        return self.name.rpartition(".")[2]

    def variance(self, coarser: float = 1.0) -> float:
        """Return the relative variance between measured and simulated response.

        ``coarser`` is a factor on the accuracy of the measurement.
        """
        uncertainty = coarser * self.accuracy.of(self.value) / abs(self.value)
        return uncertainty**2 + self.scatter**2 / RUNS + self.slope_variance

    def signal_to_noise(self, before: Knowledge) -> float:
        """Return by how much it varies over what is known of the parameters, over its error."""
        return math.sqrt(before.variance_along(self.slopes) / self.variance())


@dataclass(frozen=True)
class Candidate:
    """A test that could be measured.

    Parameters
    ----------
    name : str
        Its type, or its name in the file.
    seconds : float
        Estimated wall time of a run, s.
    responses : tuple of CandidateResponse
        What it measures, and how that depends on the parameters.
    """

    name: str
    seconds: float
    responses: tuple[CandidateResponse, ...]

    def by_signal(self, before: Knowledge) -> list[CandidateResponse]:
        """Return the responses by signal-to-noise ratio, the most telling one first."""
        return sorted(self.responses, key=lambda response: -response.signal_to_noise(before))

    def independent(self, before: Knowledge) -> list[CandidateResponse]:
        """Return the most telling response of each unit.

        Angles of one surface say nearly the same, and slopes are not known well enough to make use
        of their differences.
        """
        return list({r.unit: r for r in reversed(self.by_signal(before))}.values())


def knowledge_after(
    before: Knowledge, tests: Sequence[Candidate], coarser: float = 1.0
) -> Knowledge:
    """Return what is known after tests whose accuracies are coarser by a factor."""
    responses = [response for test in tests for response in test.independent(before)]
    errors = np.diag([response.variance(coarser) for response in responses])
    return before.after([response.slopes for response in responses], errors)


def names_of(tests: Sequence[Candidate]) -> str:
    """Return the names of tests that are measured together."""
    return " + ".join(test.name for test in tests)


def seconds_of(solver: Solver, point: Mapping[str, float]) -> float:
    """Return the estimated wall time of a run, s; 0 if it is unknown."""
    cost = solver.estimate_cost(point)
    return 0.0 if cost is None else cost.wall_seconds
