"""Responses expected at the answer after a number of runs, by metamodels of these runs alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grainfit.evaluation import Evaluation
from grainfit.metamodels.metamodels import Metamodels, can_be_fitted
from grainfit.one_thread import one_thread
from grainfit.work_folder.saved_calibration import SavedCalibration

#: Number of fits, and most runs of a fit: its time grows with the cube of the number of runs.
_FITS = 8
_MOST_FITTED = 120
#: Smallest value of that limit, from which the runs of a warm start are subtracted.
_FEWEST_FITTED = 20


@dataclass(frozen=True)
class Expectation:
    """Expected responses at the answer after a number of runs.

    Attributes
    ----------
    runs : int
        Number of runs.
    means, standard_errors : ndarray, shape (number of targets,)
        Expected responses and their standard errors.
    """

    runs: int
    means: NDArray[np.float64]
    standard_errors: NDArray[np.float64]


def checkpoints(saved: SavedCalibration) -> list[int]:
    """Return the numbers of runs after which metamodels are fitted; none without an answer."""
    most = min(len(saved.evaluations), max(_MOST_FITTED - len(saved.warm_start), _FEWEST_FITTED))
    has_answer = saved.result is not None and bool(saved.result.parameters)
    if not has_answer or not most or not can_be_fitted(saved.problem, _known_after(saved, most)):
        return []
    least = next(n for n in range(most + 1) if can_be_fitted(saved.problem, _known_after(saved, n)))
    return sorted({round(float(n)) for n in np.geomspace(max(least, 1), most, _FITS)})


def expectations_at_answer(saved: SavedCalibration) -> list[Expectation]:
    """Return the responses expected at the answer after each of the `checkpoints`."""
    with one_thread():
        return [_expectation(saved, count) for count in checkpoints(saved)]


def _expectation(saved: SavedCalibration, count: int) -> Expectation:
    assert saved.result is not None, "there are no checkpoints without an answer"
    metamodels = Metamodels.fit(saved.problem, _known_after(saved, count))
    means, variances = metamodels.predict(saved.problem.to_unit(saved.result.parameters))
    return Expectation(count, means[0], np.sqrt(variances[0]))


def _known_after(saved: SavedCalibration, count: int) -> Sequence[Evaluation]:
    """Return the first runs of the calibration, and all runs of its warm start."""
    return replace(saved, evaluations=saved.evaluations[:count]).known
