"""State of a running calibration, for progress displays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from grainfit.calibration.runs_to_come import RunsToCome
from grainfit.campaign.pending import ClusterJob, PendingRun
from grainfit.evaluation import Evaluation
from grainfit.one_line import OneLine


@dataclass(frozen=True)
class Progress(OneLine):
    """State of a running calibration.

    Parameters
    ----------
    stage : str
        ``design``, ``optimisation``, ``verification`` or ``hold-out``.
    done, running, failed : int
        Finished, running and failed runs: one test at one parameter set each.
    to_come : RunsToCome
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

    stage: str
    done: int
    running: int
    failed: int
    to_come: RunsToCome
    seconds_left: float | None
    best_deviation: float | None
    notices: tuple[str, ...]
    warm_start_runs: Mapping[str, int] = field(default_factory=dict)
    evaluations: Sequence[Evaluation] = ()
    best_expected_deviation: float | None = None
    pending: Sequence[PendingRun] = ()
    jobs: Sequence[ClusterJob] = ()

    @property
    def waiting(self) -> int:
        """Number of runs that wait for a worker, or for a job of a cluster."""
        submitted = sum(run.state == "submitted" for run in self.pending)
        return max(submitted - self.running, 0)

    @property
    def seconds_left_range(self) -> tuple[float, float] | None:
        """Range of the remaining time, s."""
        if self.seconds_left is None:
            return None
        each = self.seconds_left / max(self.to_come.about, 1)
        low, high = self.to_come.range
        return low * each, high * each
