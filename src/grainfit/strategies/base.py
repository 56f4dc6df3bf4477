"""Strategy and Search: the options of a method of calibration, and one search under way.

A `Strategy` is a frozen object that holds options only: it can be compared, printed, and used for
any number of calibrations. `Strategy.start` gives a `Search`, which holds the state of one
calibration and is driven from outside:

.. code-block:: python

    search = Sequential().start(problem, seed=1)
    while not search.finished:
        proposal = search.ask()
        search.tell(proposal, simulate(proposal.parameters, proposal.seed))
    search.answer().parameters

`grainfit.calibrate` does the same with many runs at a time, restarts and verification. A search
goes through these calls:

1. `Search.warm_start`, at most once and first: runs of other calibrations that it may use.
2. `Search.replay`: the proposals that an earlier start of the same calibration has made, so that
   an interrupted calibration continues instead of beginning again. The runs that are known are
   told when they are asked for.
3. `Search.ask` whenever a worker is free. It returns the next proposal, or None: then either the
   search has `finished`, or a pending run has to be told first.
4. `Search.tell` for every proposal whose run has ended, in any order: responses, or why it failed.
5. `Search.answer` once it has `finished`; earlier it is the best answer so far.
6. The answer is verified with fresh seeds, by the caller. The search is told these runs as well.
   If they do not confirm the answer, `Search.resume_after_verification` asks whether it can do
   better. If so it is no longer finished, and 2 to 6 are repeated.

All that a search does follows from problem, options, seed, budget, and from what it was told;
nothing follows from a clock or from chance: told the same, it asks the same. That is what makes 2
possible, and what `grainfit.testing.strategy_contract` tests.

To write a strategy of your own: declare its options as fields of a frozen dataclass that inherits
from `Strategy`, return a search of your own from `start`, and implement the abstract methods of
`Search`: `ask`, `note`, `answer`, `finished` and `expected_left`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar

from grainfit.errors import Fault, InputError
from grainfit.evaluation import Evaluation, Outcome, Proposal
from grainfit.options.fields import option_keys, read_options

if TYPE_CHECKING:
    # Options are looked at by every command line, which must not wait for numerical packages.
    from grainfit.problem import Problem
    from grainfit.strategies.answer import Answer

#: How often a verification that does not confirm the answer may lead back to the search.
RESUMPTIONS = 2


@dataclass(frozen=True)
class Strategy(ABC):
    """Options of a method of calibration.

    Subclasses are frozen dataclasses whose fields are declared with `grainfit.options.fields`.
    File keys, JSON Schema, help and checks follow from these declarations.

    Raises
    ------
    InputError
        Every option whose value is not accepted.
    """

    #: Name in the calibration file.
    name: ClassVar[str]
    #: Whether the search takes `Problem.rayleigh_weight` into account.
    uses_rayleigh_weight: ClassVar[bool] = False

    def __post_init__(self) -> None:
        given = {known.name: getattr(self, known.name) for known in fields(self)}
        values = read_options(option_keys(type(self)), given)
        for known in fields(self):
            # None stands for the default.
            value = values.get(known.name, given[known.name])
            object.__setattr__(self, known.name, known.default if value is None else value)

    @abstractmethod
    def start(self, problem: Problem, seed: int, max_evaluations: int | None = None) -> Search:
        """Start a search.

        Parameters
        ----------
        problem : Problem
            Free parameters and targets.
        seed : int
            Decides the design and all insertion seeds.
        max_evaluations : int, optional
            Largest number of proposals.

        Raises
        ------
        InputError
            Options, problem and budget do not fit together.
        """

    def fewest_evaluations(self, problem: Problem) -> int:  # noqa: ARG002
        """Return the smallest budget of proposals with which a search can be started."""
        return 1

    def check_rayleigh_weight(self, weight: float) -> None:
        """Raise InputError when a weight is given that the search would not take into account."""
        if weight > 0 and not self.uses_rayleigh_weight:
            raise InputError(
                Fault(
                    "rayleigh_weight",
                    f"has no meaning for the {self.name} strategy.",
                    'Leave it out, or use a strategy that takes it into account, such as "staged".',
                )
            )


class Search(ABC):
    """State of one search: it proposes runs until the answer is known.

    Parameters
    ----------
    strategy : Strategy
        Its options.
    problem : Problem
        Free parameters and targets.
    seed : int
        Decides the design and all insertion seeds.
    max_evaluations : int, optional
        Largest number of proposals.
    """

    def __init__(
        self, strategy: Strategy, problem: Problem, seed: int, max_evaluations: int | None = None
    ) -> None:
        self.strategy = strategy
        self.problem = problem
        self.seed = seed
        self.max_evaluations = max_evaluations

    @property
    def name(self) -> str:
        """Name of the strategy."""
        return self.strategy.name

    @property
    def design_runs(self) -> int:
        """Number of proposals that do not depend on any response; 0 unless overridden."""
        return 0

    @property
    @abstractmethod
    def finished(self) -> bool:
        """Whether there is nothing more to ask."""

    @property
    @abstractmethod
    def expected_left(self) -> int:
        """Estimate of the number of proposals that are not told yet, for the time left."""

    @property
    def notices(self) -> Sequence[str]:
        """Sentences for the user, oldest first; none unless overridden."""
        return ()

    @property
    def definition(self) -> dict[str, Any]:
        """Options that decide what is asked, as plain data: part of the calibration's identity.

        All options of the strategy unless overridden. A search whose proposals depend on the
        budget adds ``max_evaluations``.
        """
        return asdict(self.strategy)

    @property
    def current_problem(self) -> Problem:
        """The problem with the intervals that are searched, which may have been widened."""
        return self.problem

    def replay(self, proposals: Sequence[Proposal]) -> None:
        """Repeat the proposals of an earlier start of the same calibration.

        Called before the first `ask`, and again before the first one after each verification.
        Nothing is done unless overridden, which suits a search that makes the same proposals
        again in whatever order runs are told. Any other one proposes these again, in their order,
        before it continues.

        Parameters
        ----------
        proposals : sequence of Proposal
            The proposals of then, in order.
        """

    def warm_start(self, evaluations: Sequence[Evaluation]) -> None:
        """Use runs of other calibrations; each is noted unless overridden.

        Called at most once, before anything else. They are no part of the budget.

        Parameters
        ----------
        evaluations : sequence of Evaluation
            Within the intervals of the problem.
        """
        for evaluation in evaluations:
            self.note(evaluation)

    @abstractmethod
    def ask(self) -> Proposal | None:
        """Return the next proposal, or None when there is none at this moment."""

    def tell(self, proposal: Proposal, outcome: Outcome) -> None:
        """Tell the outcome of a proposal.

        Parameters
        ----------
        proposal : Proposal
            As `ask` returned it, or of a run that was made for another reason.
        outcome : mapping of str to float or Response, RunFailedError, or Evaluation
            The responses by name; or why the run failed; or an evaluation of a campaign.

        Raises
        ------
        InputError
            The outcome is none of these, names no target, or has a value that is not finite.

        Examples
        --------
        >>> from grainfit import Parameter, Problem, RunFailedError, Sequential, Target
        >>> problem = Problem([Parameter("friction", 0.1, 0.9)], [Target("angle", 30.0)])
        >>> search = Sequential().start(problem, seed=1)
        >>> search.tell(search.ask(), {"angle": 31.2})
        >>> search.tell(search.ask(), RunFailedError("the particles flew away"))
        """
        evaluation = Evaluation.of(proposal, outcome)
        names = [target.name for target in self.problem.targets]
        if isinstance(outcome, Mapping) and not any(name in outcome for name in names):
            given = ", ".join(map(repr, outcome)) or "nothing"
            raise InputError(
                Fault(
                    "outcome",
                    f"has {given}, which is no target.",
                    f"The targets are: {', '.join(names)}.",
                )
            )
        self.note(evaluation)

    @abstractmethod
    def note(self, evaluation: Evaluation) -> None:
        """Take note of a run, proposed by this search or not; `tell` calls it."""

    @abstractmethod
    def answer(self, parameters: Mapping[str, float] | None = None) -> Answer:
        """Return the best parameter set by expected responses.

        Parameters
        ----------
        parameters : mapping of str to float, optional
            Parameter set to describe instead, such as the answer of an earlier start.

        Raises
        ------
        RunFailedError
            Too few runs have succeeded.
        """

    def resume_after_verification(self, affordable: int | None = None) -> bool:  # noqa: ARG002
        """Continue after a verification that did not confirm the answer.

        Returns False when the search cannot do better, which is so unless overridden.

        Parameters
        ----------
        affordable : int, optional
            Largest number of further proposals that leaves room for another verification.
        """
        return False
