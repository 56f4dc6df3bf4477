"""Runs with fresh seeds that are no evidence of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from grainfit.evaluation import Evaluation


@dataclass(frozen=True)
class Repetitions:
    """Runs with fresh seeds that are no evidence of their own.

    Parameters
    ----------
    stale : mapping of int to tuple of str
        Responses that verify nothing, by the seed of their proposal. Their run has read a record
        that an earlier run has read, or that belongs elsewhere; or its model is deterministic, and
        another run has the same parameters.
    deterministic : tuple of str
        Tests whose model gives the same for every seed; "" stands for all tests together.
    """

    stale: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    deterministic: tuple[str, ...] = ()

    def is_known(self, evaluation: Evaluation) -> bool:
        """Return whether an evaluation repeats what other ones gave."""
        names = {*evaluation.responses, *evaluation.curves}
        stale = self.stale.get(evaluation.proposal.seed, ())
        return bool(names) and names.issubset(stale)
