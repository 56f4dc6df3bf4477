"""Metamodels that are a given function exactly, so that there are closed forms to compare with."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.special import ndtr

from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.prediction import LeaveOneOut, Prediction
from grainfit.problem import Parameter, Problem, Target

Function = Callable[[np.ndarray], np.ndarray]


class Given(Kriging):
    """A metamodel whose expected response is a function of the point."""

    def __init__(self, mean: Function, variance: Function | float = 0.0) -> None:
        self._mean = mean
        self._variance = variance if callable(variance) else lambda x: np.full(len(x), variance)

    def predict(self, points) -> Prediction:
        variance = self._variance(points)
        return Prediction(self._mean(points), variance, variance)

    def share_below(self, deviations) -> np.ndarray:
        return ndtr(deviations)

    def mean(self, points) -> np.ndarray:
        return self._mean(points)

    def gradients(self, points) -> np.ndarray:
        step = 1e-6 * np.eye(points.shape[1])
        slopes = [(self._mean(points + s) - self._mean(points - s)) / 2e-6 for s in step]
        return np.stack(slopes, axis=1)

    def to_plain(self, *, factors: bool = True) -> dict[str, Any]:
        points = np.array([[0.5]])
        return {"offset": 0.0, "scale": 1.0, "values": [0.0], "points": points.tolist()}

    def leave_one_out(self) -> LeaveOneOut:
        return LeaveOneOut(np.zeros(1), np.zeros(1), 1.0, 1.0)

    @property
    def n(self) -> int:
        return 100

    @property
    def variance_of_scatter(self) -> float:
        return 0.0


def unit_parameters(count: int) -> list[Parameter]:
    return [Parameter(f"x{number}", 0.0, 1.0) for number in range(count)]


def given(targets: Sequence[Target], models: Sequence[Given], dimension: int) -> Metamodels:
    return Metamodels(Problem(unit_parameters(dimension), targets), models)
