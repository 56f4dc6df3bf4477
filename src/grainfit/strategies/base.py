"""What a strategy is: the side of the conversation that asks for DEM runs.

The life of a strategy:

1. It is made with a problem, a seed and a budget. Everything it does follows from these and from
   what it is told, never from a clock: told the same, it asks the same. A calibration that was
   interrupted is therefore simply started again: `Strategy.replay` hands the strategy what it
   asked for before, and the runs that are known already are answered from the store.
   Runs that others made before it are handed over by `Strategy.warm_start`.
2. `Strategy.ask` is called whenever a worker is free. It returns the next proposal, or None: then
   either a run under way has to come back first, or the strategy has `finished`.
3. `Strategy.tell` hands it what came of a proposal, in any order; failed runs too.
4. Once it has finished, `Strategy.answer` is the parameter set it believes in.
5. The answer is verified with fresh seeds, outside the strategy. If it does not stand that, the
   strategy is told those runs as well, and `Strategy.resume_after_verification` asks whether it
   can do better: if so it is unfinished again and life goes on at 2.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from grainfit.errors import Fault, InputError
from grainfit.evaluation import Evaluation, Proposal, Stage
from grainfit.problem import Problem
from grainfit.strategies.answer import Answer

#: How often a verification that the answer does not stand may lead back to the search.
RECONSIDERATIONS = 2
_STAGE_CODES: Mapping[Stage, int] = {"design": 0, "optimisation": 1, "verification": 2}


def insertion_seed(seed: int, stage: Stage, number: int) -> int:
    """Insertion seed of the numbered run of a stage: the same for the same calibration seed."""
    state = np.random.SeedSequence([seed, _STAGE_CODES[stage], number]).generate_state(1)
    # Some generators, such as that of LAMMPS, take no seed above 900,000,000.
    return 1 + int(state[0]) % 899_999_999


def without_repeats(evaluations: Iterable[Evaluation]) -> list[Evaluation]:
    """Return evaluations without those of a run that is there already.

    A run that was learnt of and is asked for as well is one run: to count it twice would make its
    scatter look small.
    """
    seen: dict[tuple[float, ...], Evaluation] = {}
    for evaluation in evaluations:
        proposal = evaluation.proposal
        seen.setdefault((*proposal.parameters.values(), proposal.seed), evaluation)
    return list(seen.values())


class Strategy(ABC):
    """Asks for runs until it knows the answer.

    Parameters
    ----------
    problem : Problem
        What is calibrated.
    seed : int
        Decides the design and all insertion seeds.
    max_evaluations : int, optional
        Largest number of proposals.
    """

    #: Name in the calibration file.
    name: str

    def __init__(self, problem: Problem, seed: int, max_evaluations: int | None = None) -> None:
        self.problem = problem
        self.seed = seed
        self.max_evaluations = max_evaluations

    @property
    @abstractmethod
    def design_runs(self) -> int:
        """Proposals of the design, before anything is known."""

    @property
    @abstractmethod
    def finished(self) -> bool:
        """Whether there is nothing more to ask."""

    @property
    @abstractmethod
    def expected_left(self) -> int:
        """About how many proposals are still to come, for the time left."""

    @property
    @abstractmethod
    def notices(self) -> Sequence[str]:
        """What the user should know by now, oldest first."""

    @property
    @abstractmethod
    def definition(self) -> dict[str, Any]:
        """The options that decide what is asked, as plain data."""

    @property
    def current_problem(self) -> Problem:
        """The problem with the intervals that are searched, should they have been widened."""
        return self.problem

    def replay(self, proposals: Sequence[Proposal]) -> None:
        """Take up the thread of an earlier start.

        Called before the first `ask`, and again before the first one after each verification.
        By default nothing is done, which suits a strategy that asks for the same proposals again
        in whatever order runs come back. Any other one asks for these proposals again, in their
        order, before it goes on.

        Parameters
        ----------
        proposals : sequence of Proposal
            What was asked for then, in order.
        """

    @abstractmethod
    def warm_start(self, evaluations: Sequence[Evaluation]) -> None:
        """Take note of runs that were there before, made for whatever purpose.

        Called at most once, before anything else. They are no part of the budget.

        Parameters
        ----------
        evaluations : sequence of Evaluation
            Within the intervals of the problem.
        """

    @abstractmethod
    def ask(self) -> Proposal | None:
        """Return the next proposal, or None when there is none at this moment."""

    @abstractmethod
    def tell(self, evaluation: Evaluation) -> None:
        """Take note of what came of a proposal."""

    @abstractmethod
    def answer(self, parameters: Mapping[str, float] | None = None) -> Answer:
        """Return the best parameter set by expected response.

        Parameters
        ----------
        parameters : mapping of str to float, optional
            Those of an earlier start, which are then the answer whatever would be now.
        """

    @abstractmethod
    def resume_after_verification(self, affordable: int | None = None) -> bool:
        """Go on when the answer did not stand its verification; False when it cannot do better.

        Parameters
        ----------
        affordable : int, optional
            Largest number of further proposals that leaves room for another verification.
        """


def smallest_design(dimension: int, wanted: int | None = None) -> int:
    """Return the size of the design that is wanted, or else the smallest that is possible.

    Raises
    ------
    InputError
        What is wanted is too small to fit metamodels.
    """
    smallest = dimension + 3
    if wanted is not None and wanted < smallest:
        raise InputError(
            Fault(
                "design_runs",
                f"{wanted} runs are too few for metamodels of {dimension} parameters.",
                f"Give at least {smallest}.",
            )
        )
    return wanted or smallest


def design_size(dimension: int, wanted: int | None, usual: int, max_evaluations: int | None) -> int:
    """Return the size of a design within a budget.

    Parameters
    ----------
    dimension : int
        Number of free parameters.
    wanted : int, optional
        What the user wants.
    usual : int
        What the strategy would take.
    max_evaluations : int, optional
        The budget. A tight one keeps a third for the runs behind the design.

    Raises
    ------
    InputError
        What is wanted is too small for metamodels or too large for the budget.
    """
    smallest = smallest_design(dimension, wanted)
    if max_evaluations is None:
        return wanted or usual
    if max_evaluations < smallest:
        raise InputError(
            Fault(
                "max_evaluations",
                f"{max_evaluations} are too few for the design.",
                f"Allow at least {smallest}.",
            )
        )
    return wanted or min(usual, max(smallest, (2 * max_evaluations) // 3))
