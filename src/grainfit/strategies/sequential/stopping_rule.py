"""Stopping rule of the sequential strategy."""

from __future__ import annotations

from dataclasses import dataclass

from grainfit.strategies.sequential.belief import Belief
from grainfit.verdict.options import VERDICT

#: Runs after the design before a target can be called out of reach.
_RUNS_TO_CONFIRM = 2
#: Smallest expected gain of the time step that justifies further runs.
_GAIN_WORTH_RUNS = 0.05
#: Without a budget, the search ends when all runs left would narrow the standard errors by less.
_NARROWING_WORTH_RUNS = 0.3
#: Most missing runs at the answer that are left to its verification: its fresh seeds go into the
#: metamodels, too, so that they confirm the answer and make it certain at once.
_LEFT_TO_VERIFICATION = 3
#: Last runs of the usual budget, per free parameter, that only a likely answer is worth.
_RUNS_OF_HOPE = 4


@dataclass(frozen=True)
class StoppingRule:
    """Decide from the runs known so far if a search can end.

    Parameters
    ----------
    confidence : float
        Probability that all expected responses are within their tolerances at which a search
        stops.
    demanded : float
        The same that the user demands; what does not even reach that is hopeless.
    runs_behind : int
        Runs that have followed the design.
    runs_left : int, optional
        Runs left; None when the user gave a budget. Then the search does not end at the noise
        floor before the budget is used.
    """

    confidence: float
    demanded: float
    runs_behind: int
    runs_left: int | None

    def is_decided(self, belief: Belief) -> bool:
        """Whether all that is wanted is known but for the verification, or no run could help."""
        if self.is_hopeless(belief):
            return True
        if not self.is_answered(belief):
            return False
        return belief.knowledge is None or not belief.knowledge.is_worth_runs

    def is_hopeless(self, belief: Belief) -> bool:
        """Whether no further run could decide the answer."""
        return self.is_out_of_reach(belief) or self._is_at_noise_floor(belief)

    def is_answered(self, belief: Belief) -> bool:
        """Whether the answer is known but for its verification."""
        return self._is_left_to_verification(belief) and belief.gain < _GAIN_WORTH_RUNS

    def is_out_of_reach(self, belief: Belief) -> bool:
        """Whether a target is out of reach of the intervals."""
        return self.runs_behind >= _RUNS_TO_CONFIRM and bool(belief.misses)

    def _is_left_to_verification(self, belief: Belief) -> bool:
        """Whether the verification of the answer can decide it.

        Runs with fresh seeds at the answer are needed in any case, and now tell the most.
        """
        if not (belief.is_proven and belief.is_likely):
            return False
        return belief.runs_needed(self.confidence) <= _LEFT_TO_VERIFICATION

    def _is_at_noise_floor(self, belief: Belief) -> bool:
        """Whether all further runs would neither decide the search nor add much information."""
        if self.runs_left is None:
            return False
        if self.runs_left <= _RUNS_OF_HOPE * belief.problem.dimension and not belief.is_likely:
            return True
        runs_left = self.runs_left + VERDICT.most_verification
        if belief.runs_needed(self.demanded) <= runs_left:
            return False
        if belief.is_at_edge and self.runs_behind >= VERDICT.enough_at_edge:
            return True
        return belief.narrowing(runs_left) < _NARROWING_WORTH_RUNS
