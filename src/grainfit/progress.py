"""What is told to whoever shows the progress of a calibration."""

from __future__ import annotations

from dataclasses import dataclass


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
    """

    stage: str
    done: int
    running: int
    failed: int
    left: int
    seconds_left: float | None
    best_deviation: float | None
    notices: tuple[str, ...]
