"""Strategy and Search: the options of a calibration method, and the state of one search.

A `Strategy` is a frozen object that holds options only: it can be compared, printed, and used for
any number of calibrations. `Strategy.start` gives a `Search`, which holds the state of one
calibration. The caller drives it:

.. code-block:: python

    search = Sequential().start(problem, seed=1)
    while not search.finished:
        proposal = search.ask()
        search.tell(proposal, simulate(proposal.parameters, proposal.seed))
    search.answer().parameters

`grainfit.calibrate` does the same with many runs at a time, restarts and verification. A search
goes through these calls:

1. `Search.warm_start`, at most once and first: runs of other calibrations that it may use.
2. `Search.replay`: the proposals of an earlier start of the same calibration, so that an
   interrupted calibration continues instead of beginning again. When the search asks for a run
   that is already known, the search gets its outcome at once.
3. `Search.ask` whenever a worker is free. It returns the next proposal, or None: then either the
   search has `finished`, or a pending run has to be told first.
4. `Search.tell` for every proposal whose run has ended, in any order: responses, or why it failed.
5. `Search.answer` once it has `finished`; earlier it returns the best answer so far.
6. The caller verifies the answer with fresh seeds, and tells the search these runs as well. If
   they do not confirm the answer, `Search.resume_after_verification` returns True if the search
   can do better. Then it is no longer finished, and 2 to 6 are repeated.

A search is deterministic: its proposals follow from problem, options, seed, budget and the
outcomes told so far, never from a clock or from chance. This makes 2 possible, and
`grainfit.testing.strategy_contract` tests it.

To write a custom strategy: declare its options as fields of a frozen dataclass that inherits from
`Strategy`, return a custom `Search` from `start`, and implement the abstract methods of `Search`:
`ask`, `note`, `answer`, `finished` and `expected_left`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar

from grainfit.errors import InputError
from grainfit.evaluation import Evaluation, Outcome, Proposal
from grainfit.one_line import OneLine
from grainfit.options.fields import option_keys, read_options
from grainfit.strategies import messages
from grainfit.verdict.looks import confidence_after
from grainfit.verdict.options import VERDICT

if TYPE_CHECKING:
    # Every command line reads the options, and must not wait for numerical packages to load.
    from grainfit.problem import Problem
    from grainfit.strategies.answer import Answer


@dataclass(frozen=True)
class Strategy(OneLine, ABC):
    """Options of a calibration method.

    Subclasses are frozen dataclasses whose fields are declared with `grainfit.options.fields`.
    File keys, JSON Schema, help and checks follow from these declarations.

    Raises
    ------
    InputError
        Some options have values that are not accepted; it lists them all.
    """

    #: Name in the calibration file.
    name: ClassVar[str]
    #: Whether the search takes `Problem.rayleigh_weight` into account.
    uses_rayleigh_weight: ClassVar[bool] = False
    #: Whether the search runs the relatives of tests, see `Problem.relatives`.
    uses_relatives: ClassVar[bool] = False

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
            Largest number of proposals; with several tests, of as many runs as proposals for all
            of them have.

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
            raise InputError(messages.FOREIGN_WEIGHT.fault("rayleigh_weight", strategy=self.name))

    def check_relatives(self, key: str) -> None:
        """Raise InputError when relatives are given, by an option, that the search does not run."""
        if key and not self.uses_relatives:
            raise InputError(messages.FOREIGN_RELATIVES.fault(key, strategy=self.name))


class Search(ABC, OneLine):
    """State of one search, which proposes runs until the answer is known.

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

    #: Smallest probability of an answer at which fresh seeds are worth their runs.
    verify_from: ClassVar[float] = VERDICT.verify_from
    #: Whether runs outside the intervals may be told to it: its answer is never one of them.
    learns_beyond_intervals: ClassVar[bool] = False
    #: Scatter of single evaluations in tolerances that is expected before any run, as recorded;
    #: of the order of the tolerance where nothing is known.
    expected_scatter: float = 1.0

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
    def runs_of_design(self) -> int:
        """Number of runs of these proposals: one in every test unless overridden."""
        return self.design_runs * len(self.problem.scopes)

    @property
    def spared_by_design(self) -> float:
        """Runs of tests that these proposals spare, as those of relatives cost a part of one."""
        return 0.0

    @property
    @abstractmethod
    def finished(self) -> bool:
        """Whether there is nothing more to ask."""

    @property
    @abstractmethod
    def expected_left(self) -> int:
        """Estimated number of runs still needed; a budget may end the search before."""

    @property
    def limit(self) -> int | None:
        """Largest number of proposals, None if there is none; the budget unless overridden."""
        return self.max_evaluations

    @property
    def confidence(self) -> float:
        """Demanded probability that every target is met; 0.95 unless overridden."""
        return VERDICT.confidence

    @property
    def confidence_to_stop(self) -> float:
        """Probability at which a search stops: more than demanded, see `confidence_after`."""
        return confidence_after(self.looks, self.confidence)

    @property
    def looks(self) -> int:
        """How often it has looked at its answer to see if it can stop; 0 unless overridden."""
        return 0

    @property
    def notices(self) -> Sequence[str]:
        """Sentences for the user, oldest first; none unless overridden."""
        return ()

    @property
    def definition(self) -> dict[str, Any]:
        """Options that determine the proposals, as plain data: part of the calibration's identity.

        All options of the strategy unless overridden. A search whose proposals depend on the
        budget adds ``max_evaluations``.
        """
        return asdict(self.strategy)

    @property
    def current_problem(self) -> Problem:
        """Problem with the intervals searched now, which may have been widened."""
        return self.problem

    def replay(self, proposals: Sequence[Proposal]) -> None:
        """Repeat the proposals of an earlier start of the same calibration.

        Called before the first `ask`, and again before the first one after each verification.
        Does nothing unless overridden. That suits a search whose proposals do not depend on the
        order in which runs end. Any other search proposes these again, in their order, before it
        continues.

        Parameters
        ----------
        proposals : sequence of Proposal
            The earlier proposals, in order.
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

    def learn_from_near(self, evaluations: Sequence[Evaluation], tests: Sequence[str]) -> None:
        """Use runs of near problems, on which no verdict rests; ignored unless overridden.

        Called at most once, before `warm_start`, and only where the strategy `uses_relatives`.

        Parameters
        ----------
        evaluations : sequence of Evaluation
            With the responses of a relative of a test, see `grainfit.problem.Relative`.
        tests : sequence of str
            Names of these tests.
        """

    @abstractmethod
    def ask(self) -> Proposal | None:
        """Return the next proposal, or None when there is none at this moment."""

    def tell(self, proposal: Proposal, outcome: Outcome) -> None:
        """Tell the outcome of a proposal.

        Parameters
        ----------
        proposal : Proposal
            As `ask` returned it, or the proposal of a run from elsewhere.
        outcome : mapping of str to float, Response or Curve, RunFailedError, or Evaluation
            The responses by name, the reason why the run failed, or an evaluation of a campaign.

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
        problem = self.problem
        relatives = [(problem.relative_of(name), name) for name in problem.responses]
        names = [*problem.responses, *(one.response_name(name) for one, name in relatives if one)]
        if isinstance(outcome, Mapping) and not any(name in outcome for name in names):
            given = ", ".join(map(repr, outcome)) or "nothing"
            known = ", ".join(names)
            raise InputError(
                messages.NO_TARGET_IN_OUTCOME.fault("outcome", given=given, targets=known)
            )
        self.note(evaluation)

    @abstractmethod
    def note(self, evaluation: Evaluation) -> None:
        """Record a run, proposed by this search or not; `tell` calls it."""

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

        Returns False when the search cannot do better, which is the default.

        Parameters
        ----------
        affordable : int, optional
            Largest number of further proposals that leaves room for another verification.
        """
        return False
