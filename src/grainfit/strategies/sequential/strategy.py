"""Sequential strategy: its options, and the search that they start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from grainfit.strategies.base import Search
from grainfit.strategies.sequential.options import SequentialOptions

if TYPE_CHECKING:
    from grainfit.problem import Problem


@dataclass(frozen=True)
class Sequential(SequentialOptions):
    """Propose one run at a time, each where it is expected to improve the answer most.

    Parameters
    ----------
    design_runs : int, optional
        Size of the Latin hypercube; by default d + 2, at least 5; 4 for one parameter and one
        test.
    prefer : {"time_step", "accuracy"}
        Of all parameter sets that agree with the measurements, take the one with the largest
        Rayleigh time step, or the closest one.
    extend_intervals : bool
        Move a bound that keeps a target out of reach, within physical limits, and continue.
    confidence : float
        Demanded probability that all expected responses are within their tolerances.
    wanted_half_width : float or str, optional
        Wanted half of the 95 % interval of every free parameter, a share of its value such as
        ``"25 %"``. Once the answer agrees, the search goes on until all are that narrow, until
        more runs would hardly narrow them, or to the end of the budget.

    Examples
    --------
    >>> Sequential(prefer="accuracy").prefer
    'accuracy'
    >>> Sequential(wanted_half_width="25 %").wanted_half_width
    0.25
    """

    name: ClassVar[str] = "sequential"

    def start(self, problem: Problem, seed: int, max_evaluations: int | None = None) -> Search:
        """Start a search; without a budget: the design and at most 20 runs per free parameter.

        Parameters
        ----------
        problem, seed, max_evaluations : object
            As in `Strategy.start`.
        """
        from grainfit.strategies.sequential.search import SequentialSearch

        return SequentialSearch(self, problem, seed, max_evaluations)
