"""The Kriging metamodels of all responses of a problem together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grainfit.campaign.evaluation import Evaluation
from grainfit.errors import RunFailedError
from grainfit.kriging import Kriging
from grainfit.misfit import expected_misfit, residuals
from grainfit.problem import Problem

Array = NDArray[np.float64]


class Metamodels:
    """One metamodel per target, in the order of the targets.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    evaluations : sequence of Evaluation
        What is known; for each response, the evaluations that yielded it are used.

    Raises
    ------
    RunFailedError
        Too few runs yielded a response to fit a metamodel.
    """

    def __init__(self, problem: Problem, evaluations: Sequence[Evaluation]) -> None:
        self.problem = problem
        self.models = [_fit(problem, evaluations, target.name) for target in problem.targets]

    def predict(self, points: ArrayLike) -> tuple[Array, Array]:
        """Expected responses and their variances at points of the unit cube.

        Parameters
        ----------
        points : array_like, shape (m, d)
            Points of the unit cube.

        Returns
        -------
        means, variances : ndarray, shape (m, number of targets)
            The variance is that of the expected response, not of a single run.
        """
        predictions = [model.predict(np.atleast_2d(points)) for model in self.models]
        return (
            np.column_stack([prediction.mean for prediction in predictions]),
            np.column_stack([prediction.variance_of_mean for prediction in predictions]),
        )

    def gradients(self, point: Array) -> Array:
        """Slopes of the expected responses, shape (number of targets, d), per unit interval."""
        return np.array([model.gradient(point) for model in self.models])

    def residuals(self, point: Array) -> Array:
        """Residuals of the expected responses at a point, see `grainfit.misfit.residuals`."""
        means, _ = self.predict(point)
        return residuals(self.problem, self.problem.from_unit(point), means[0])

    def expected_misfit(self, point: Array) -> float:
        """Expected sum of squared residuals at a point."""
        means, variances = self.predict(point)
        return expected_misfit(self.problem, self.problem.from_unit(point), means[0], variances[0])

    @property
    def noise(self) -> Array:
        """Standard deviations of the responses from seed to seed, shape (number of targets,)."""
        return np.array([model.noise_standard_deviation for model in self.models])


def _fit(problem: Problem, evaluations: Sequence[Evaluation], name: str) -> Kriging:
    known = [e for e in evaluations if name in e.responses]
    needed = problem.dimension + 2
    if len(known) < needed:
        reasons = sorted({reason for e in evaluations for reason in e.failures.values()})
        because = f" Failures: {'; '.join(reasons[:3])}." if reasons else ""
        raise RunFailedError(
            f"only {len(known)} of {len(evaluations)} runs gave the response {name!r}, and "
            f"{needed} are needed for its metamodel.{because}"
        )
    points = np.array([problem.to_unit(e.proposal.parameters) for e in known])
    return Kriging.fit(points, np.array([e.responses[name].value for e in known]))
