"""Staged strategy: its options, and the search that they start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from grainfit.strategies.base import Search
from grainfit.strategies.staged.options import StagedOptions

if TYPE_CHECKING:
    from grainfit.problem import Problem


@dataclass(frozen=True)
class Staged(StagedOptions):
    """Three steps: a Latin hypercube, a fit on Kriging metamodels, the same fit on the DEM.

    Parameters
    ----------
    design_runs : int, optional
        Size of the Latin hypercube; 13 per free parameter by default.

    References
    ----------
    Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016).

    Examples
    --------
    >>> Staged(design_runs=20)
    Staged(design_runs=20)
    """

    name: ClassVar[str] = "staged"
    uses_rayleigh_weight: ClassVar[bool] = True

    def start(self, problem: Problem, seed: int, max_evaluations: int | None = None) -> Search:
        """Start a search; without a budget its last step has at most 10 runs per free parameter.

        Parameters
        ----------
        problem, seed, max_evaluations : object
            As in `Strategy.start`.
        """
        from grainfit.strategies.staged.search import StagedSearch

        return StagedSearch(self, problem, seed, max_evaluations)
