"""Stopping rule of the sequential strategy."""

from __future__ import annotations

from dataclasses import dataclass

from grainfit.metamodels.time_steps import EQUAL_TIME_STEPS
from grainfit.strategies.sequential.belief import Belief

#: An expected gain of the time step that is worth further runs.
_GAIN_WORTH_RUNS = 0.05
#: Without a budget, runs that narrow the standard errors by less than this in all are not made.
_NARROWING_WORTH_RUNS = 0.3
#: Runs at the answer that are still wanted when it is verified, after a warm start. Each one more
#: saves a run of the search, and costs some certainty (docs/decisions.md).
_LEFT_TO_VERIFICATION = 3
_LARGEST_TIME_STEP = (
    "Of the parameter sets that agree with the measurements, the one with the largest Rayleigh "
    "time step was taken:"
)


@dataclass(frozen=True)
class StoppingRule:
    """Decide whether a search can end, with the runs known so far.

    Parameters
    ----------
    confidence : float
        Demanded probability that all expected responses are within their tolerances.
    is_confirmed : bool
        Whether enough runs have followed the design to call a target out of reach.
    has_learnt : bool
        Whether a warm start has replaced the design.
    runs_left : int, optional
        Runs left; None when the user gave a budget. That is for using: only its end ends the
        search at the noise floor.
    """

    confidence: float
    is_confirmed: bool
    has_learnt: bool
    runs_left: int | None

    def is_decided(self, belief: Belief) -> bool:
        """Whether the answer is known, or no further run could help."""
        if self.is_out_of_reach(belief) or self._is_at_noise_floor(belief):
            return True
        if self._is_left_to_verification(belief):
            return True
        return belief.agrees and belief.is_proven and belief.gain < _GAIN_WORTH_RUNS

    def is_out_of_reach(self, belief: Belief) -> bool:
        """Whether a target is out of reach of the intervals."""
        return self.is_confirmed and bool(belief.misses)

    def final_notices(self, belief: Belief) -> list[str]:
        """Tell the user why the search has ended, where that is not plain."""
        if self.is_out_of_reach(belief):
            return [str(miss) for miss in belief.misses]
        if not belief.agrees and not self._is_left_to_verification(belief):
            return [belief.why_undecided(self.confidence)]
        if (gained := belief.time_step_gained) > EQUAL_TIME_STEPS:
            return [f"{_LARGEST_TIME_STEP} {gained:+.1%} against the closest one."]
        return []

    def _is_left_to_verification(self, belief: Belief) -> bool:
        """Whether a warm start tells so much that verifying the answer can decide it.

        Fresh seeds at the answer are needed in any case, and then tell the most.
        """
        return (
            self.has_learnt
            and belief.is_proven
            and belief.runs_needed(self.confidence) <= _LEFT_TO_VERIFICATION
        )

    def _is_at_noise_floor(self, belief: Belief) -> bool:
        """Whether all further runs could neither decide it nor teach much."""
        if belief.agrees or self.runs_left is None:
            return False
        needed = belief.runs_needed(self.confidence)
        return needed > self.runs_left and belief.narrowing(self.runs_left) < _NARROWING_WORTH_RUNS
