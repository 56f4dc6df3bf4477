"""What is told to whoever shows the progress of a calibration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Progress:
    """Where a calibration stands, for whoever shows it.

    Parameters
    ----------
    stage : str
        ``design``, ``optimisation`` or ``verification``.
    done, running, failed : int
        Parameter sets finished, runs under way, and parameter sets with a failed run.
    left : int
        About how many parameter sets are still to come.
    seconds_left : float, optional
        About how long that takes.
    best_deviation : float, optional
        Largest relative deviation from a target in the best run so far.
    notices : tuple of str
        What the user should know by now.
    warm_start_runs : mapping of str to int
        Number of runs that were made before it and that it learns from, by where they came from;
        the empty text stands for the work folder itself.
    """

    stage: str
    done: int
    running: int
    failed: int
    left: int
    seconds_left: float | None
    best_deviation: float | None
    notices: tuple[str, ...]
    warm_start_runs: Mapping[str, int] = field(default_factory=dict)
