"""Options of the staged strategy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from grainfit.options.fields import option
from grainfit.options.kinds import Whole
from grainfit.strategies.base import Strategy

if TYPE_CHECKING:
    from grainfit.problem import Problem


@dataclass(frozen=True)
class StagedOptions(Strategy):
    """Options of the staged strategy, see `Staged`."""

    design_runs: int | None = option(
        Whole(2),
        "Runs of the initial Latin hypercube.",
        default_text="13 d for d free parameters",
        example="20",
    )

    def fewest_evaluations(self, problem: Problem) -> int:
        """Return the smallest size of the design."""
        from grainfit.strategies.budget import smallest_design

        return smallest_design(problem.dimension, self.design_runs)
