"""State of a running calibration, for progress displays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil, floor

from grainfit.campaign.pending import ClusterJob, PendingRun
from grainfit.evaluation import Evaluation
from grainfit.one_line import one_line

#: Factor to both sides of the estimated remaining runs (`benchmarks/verdicts.py`).
UNCERTAINTY_OF_LEFT = 1.6


@dataclass(frozen=True)
class Progress:
    """State of a running calibration.

    Parameters
    ----------
    stage : str
        ``design``, ``optimisation`` or ``verification``.
    done, running, failed : int
        Finished, running and failed runs: one test at one parameter set each.
    left : int
        Estimated number of remaining runs, verification included.
    seconds_left : float, optional
        Estimated remaining time, s.
    best_deviation : float, optional
        Largest relative deviation from a target in the best run so far; None if deviations from a
        target are not relative, and after the design of several tests.
    notices : tuple of str
        Notices for the user.
    warm_start_runs : mapping of str to int
        Number of earlier runs used for the warm start, by their source; the empty text is the work
        folder itself.
    evaluations : sequence of Evaluation
        All evaluations so far, in the order in which they ended.
    best_expected_deviation : float, optional
        Largest relative deviation of an expected response from its target at the present answer;
        None during the design, and if deviations from a target are not relative.
    pending : sequence of PendingRun
        Runs that have not ended.
    jobs : sequence of ClusterJob
        Jobs of a cluster in which they execute.
    """

    __repr__ = one_line

    stage: str
    done: int
    running: int
    failed: int
    left: int
    seconds_left: float | None
    best_deviation: float | None
    notices: tuple[str, ...]
    warm_start_runs: Mapping[str, int] = field(default_factory=dict)
    evaluations: Sequence[Evaluation] = ()
    best_expected_deviation: float | None = None
    pending: Sequence[PendingRun] = ()
    jobs: Sequence[ClusterJob] = ()

    @property
    def left_range(self) -> tuple[int, int]:
        """Range of the number of remaining runs, see `UNCERTAINTY_OF_LEFT`."""
        return floor(self.left / UNCERTAINTY_OF_LEFT), ceil(self.left * UNCERTAINTY_OF_LEFT)

    @property
    def seconds_left_range(self) -> tuple[float, float] | None:
        """Range of the remaining time, s."""
        if self.seconds_left is None:
            return None
        return self.seconds_left / UNCERTAINTY_OF_LEFT, self.seconds_left * UNCERTAINTY_OF_LEFT
