"""Options of the sequential strategy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, get_args

from grainfit.options.fields import option
from grainfit.options.kinds import Choice, Flag, Quantity, Share, Whole
from grainfit.strategies.base import Strategy
from grainfit.verdict.options import VERDICT

if TYPE_CHECKING:
    from grainfit.problem import Problem

Preference = Literal["time_step", "accuracy"]


@dataclass(frozen=True)
class SequentialOptions(Strategy):
    """Options of the sequential strategy, see `Sequential`."""

    uses_relatives: ClassVar[bool] = True

    design_runs: int | None = option(
        Whole(2),
        "Runs of the initial Latin hypercube.",
        default_text="d + 2 for d free parameters, at least 5; 4 for one parameter and one test",
        example="12",
    )
    prefer: Preference = option(
        Choice(get_args(Preference)),
        "Of all parameter sets that agree with the measurements, take the one with the largest "
        'Rayleigh time step ("time_step"; differences below 5 % do not count, the closer set is '
        'taken), or the closest one ("accuracy").',
        default="time_step",
        default_text='"time_step"',
        example='"accuracy"',
    )
    extend_intervals: bool = option(
        Flag(),
        "Move a bound that keeps a target out of reach, within physical limits, and continue; the "
        "result names it.",
        default=False,
        default_text="false",
        example="true",
    )
    confidence: float = option(
        Quantity("", lowest=0.5, highest=1.0),
        "Demanded probability that all expected responses are within their tolerances.",
        default=VERDICT.confidence,
        example="0.99",
    )
    wanted_half_width: float | None = option(
        Share(),
        "Wanted half of the 95 % interval of every free parameter, a share of its value. Once the "
        "answer agrees, the search goes on until all are that narrow, until more runs would hardly "
        "narrow them, or to the end of the budget.",
        default_text="none: the search ends when the answer agrees",
        example='"25 %"',
    )

    def fewest_evaluations(self, problem: Problem) -> int:
        """Return the smallest size of the design."""
        from grainfit.strategies.budget import smallest_design

        return smallest_design(problem.dimension, self.design_runs)
