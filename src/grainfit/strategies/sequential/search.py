"""Search of the sequential strategy: every run goes where it is expected to improve the answer.

After a small Latin hypercube, metamodels of all responses are fitted again whenever a run has
ended, and `next_run` chooses the next run with the pending ones taken into account. The search ends
when `stopping` finds it decided: the answer agrees with all measurements with the demanded
probability, or no parameter set can. When a half-width of the 95 % intervals is wanted, the answer
is followed by runs that narrow them (`parameter_knowledge`, `variance_reduction`).

The next proposal depends only on the known and the pending runs, not on their order. So an
interrupted calibration needs only its history to continue.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from functools import cached_property
from typing import Any

import numpy as np

from grainfit.arrays import Array
from grainfit.evaluation import Evaluation, Proposal, Stage
from grainfit.formatting import in_a_row, number
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.metamodels.metamodels import Metamodels, can_be_fitted
from grainfit.metamodels.predictor import RUNS_PER_COEFFICIENT, runs_for_trend
from grainfit.metamodels.time_steps import EQUAL_TIME_STEPS
from grainfit.metamodels.unit_cube import spread_subset
from grainfit.problem import Problem, Relative, TestScope
from grainfit.problem.test_scope import cost_of_relatives
from grainfit.strategies import messages
from grainfit.strategies.answer import Answer, make_answer
from grainfit.strategies.base import Search
from grainfit.strategies.budget import design_size, runs_with_scatter
from grainfit.strategies.distinct_runs import distinct_runs
from grainfit.strategies.out_of_reach import widened, widenings
from grainfit.strategies.run_costs import RunCosts
from grainfit.strategies.seeds import insertion_seed
from grainfit.strategies.sequential.belief import LIKELY, Belief
from grainfit.strategies.sequential.next_run import (
    NextRun,
    next_run,
    pending_is_enough,
    space_filling_point,
)
from grainfit.strategies.sequential.options import SequentialOptions
from grainfit.strategies.sequential.parameter_knowledge import ParameterKnowledge
from grainfit.strategies.sequential.stopping_rule import StoppingRule
from grainfit.strategies.sequential.variance_reduction import most_narrowing_run
from grainfit.verdict.options import VERDICT

#: Fewest runs of the design with two parameters or tests, or more.
_SMALL_DESIGN = 5
#: Most runs after the design per free parameter, if the user gives no budget.
RUNS_PER_PARAMETER = 20
#: Runs of a relative in the design: they may cost as much as two runs of its test, and are at least
#: as many as the test would have without it, at most four times as many.
_COST_OF_RELATIVE, _MOST_OF_RELATIVE = 2.0, 4
#: Usual designs that a search may be guided by relatives, before its own runs decide.
_GUIDED = 2
_TRIES_OF_A_MACHINE = 3
#: Runs that usually follow the design where the scatter is small, verification included.
_USUAL_AFTER_DESIGN = 5
#: Runs that usually narrow the intervals to a wanted half-width after the answer is known.
_USUAL_TO_NARROW = 12
#: Share of the runs so far that usually follow them in a search that takes longer than usual
#: (`benchmarks/forecasts.py`).
_LONGER_THAN_USUAL = 0.2
_MOST_WIDENINGS = 4
#: Runs that the expected scatter counts as, beside the measured one.
_RUNS_OF_EXPECTED = 5


def usual_design(dimension: int, tests: int = 1) -> int:
    """Return the usual number of runs of the design for some free parameters and tests.

    One more than a linear trend has coefficients; what else is needed, the search finds sooner than
    a design. With one or two parameters, two more; with one and several tests three: four runs do
    not tell a trend from scatter.
    """
    fewest = _SMALL_DESIGN if tests > 1 else min(dimension + 3, _SMALL_DESIGN)
    return max(dimension + 2, fewest)


class SequentialSearch(Search):
    """Search that proposes one run at a time.

    Parameters
    ----------
    strategy : SequentialOptions
        Size of the design, preference, and demanded probability.
    problem : Problem
        Free parameters and targets.
    seed : int
        Decides the design and all insertion seeds.
    max_evaluations : int, optional
        Largest number of proposals; by default the design and 20 per free parameter.

    Raises
    ------
    InputError
        The design is too small to fit metamodels, or larger than the budget.
    """

    learns_beyond_intervals = True
    verify_from = LIKELY

    def __init__(
        self,
        strategy: SequentialOptions,
        problem: Problem,
        seed: int,
        max_evaluations: int | None = None,
    ) -> None:
        super().__init__(strategy, problem, seed, max_evaluations)
        self._options = strategy
        usual = usual_design(problem.dimension, len(problem.scopes))
        self._design_size = design_size(
            problem.dimension, strategy.design_runs, usual, max_evaluations
        )
        self._design_sizes = {
            scope.name: strategy.design_runs or min(self._design_size, self._usual_of(scope, usual))
            for scope in problem.scopes
        }
        for relative in problem.relatives:
            self._make_room_for(relative)
        self._usual_design = strategy.design_runs or usual
        self._allowed = max_evaluations or (
            self._design_size + RUNS_PER_PARAMETER * problem.dimension
        )
        self._asked: list[Proposal] = []
        self._indices: dict[int, int] = {}
        self._told: dict[int, Evaluation] = {}
        self._others: list[Evaluation] = []
        self._to_repeat: deque[Proposal] = deque()
        self._resumptions = 0
        self._latest: tuple[tuple[int, int], Belief] | None = None
        self._notices: list[str] = []
        self._has_ended = False

    def _usual_of(self, scope: TestScope, usual: int) -> int:
        """Return the usual design of a test: that of the problem if all parameters are its own."""
        dimension = len(scope.parameters)
        return usual if dimension == self.problem.dimension else usual_design(dimension)

    def _make_room_for(self, relative: Relative) -> None:
        """Choose the design of a relative and of its test.

        The relative shows how responses change, its test a difference that changes less.
        """
        test = self.problem.scope_of_test(relative.of)
        usual_runs = self._design_sizes[relative.of]
        if relative.cost is not None:
            affordable = int(_COST_OF_RELATIVE / relative.cost)
            most = _MOST_OF_RELATIVE * usual_runs
            self._design_sizes[relative.name] = max(usual_runs, min(affordable, most))
        if self._options.design_runs is None:
            self._design_sizes[relative.of] = min(usual_runs, len(test.parameters) + 1)
        self._design_size = max(self._design_sizes.values())

    @property
    def definition(self) -> dict[str, Any]:
        """All options; the budget only limits the number of proposals."""
        options = asdict(self._options) | {"design_runs": self._usual_design}
        if self._options.wanted_half_width is None:
            # So calibrations without this option keep the identity that they had before it.
            del options["wanted_half_width"]
        return options

    @property
    def design_runs(self) -> int:
        """Size of the Latin hypercube."""
        return self._design_size

    @property
    def runs_of_design(self) -> int:
        """Runs of the design: tests that depend on few parameters need fewer."""
        return sum(self._design_sizes.values())

    @property
    def spared_by_design(self) -> float:
        """Runs of tests that the design spares, as those of relatives cost a part of one."""
        relatives = [one for one in self.problem.relatives if one.cost is not None]
        return sum((1 - (one.cost or 0.0)) * self._design_sizes[one.name] for one in relatives)

    @property
    def confidence(self) -> float:
        """Demanded probability that every target is met, an option."""
        return self._options.confidence

    @property
    def looks(self) -> int:
        """Runs of the search after the design: it looks after each."""
        return max(0, self._sets_told - self._sets_of_design)

    @property
    def _sets_of_design(self) -> int:
        if not self.problem.relatives:
            return self._design_size
        return max(self._design_sizes[scope.name] for scope in self.problem.scopes)

    @property
    def notices(self) -> Sequence[str]:
        """Widened intervals, what the preference has gained, how closely parameters are known."""
        wanted = self._options.wanted_half_width is not None
        if not self._has_ended and not (wanted and self.finished):
            return tuple(self._notices)
        return (*self._notices, *self._final_notices)

    @property
    def _final_notices(self) -> Sequence[str]:
        """What is known of the answer now, verification included; so it is not kept."""
        belief = self._belief
        if belief is None or self._rule.is_out_of_reach(belief):
            return ()
        found = []
        if (gained := belief.time_step_gained) > EQUAL_TIME_STEPS:
            found.append(messages.LARGEST_TIME_STEP(gained=gained))
        if belief.knowledge is not None:
            found.append(
                about_half_widths(
                    belief.knowledge,
                    is_answered=self._rule.is_answered(belief),
                    is_budget_used=self._budget_is_used,
                )
            )
        return found

    @property
    def current_problem(self) -> Problem:
        """Problem with the intervals searched now."""
        return self.problem if self._belief is None else self._belief.problem

    @property
    def known(self) -> list[Evaluation]:
        """All evaluations, in the order of their proposals, those of a warm start last."""
        told = [self._told[index] for index in sorted(self._told)]
        return distinct_runs(told + self._others)

    @property
    def finished(self) -> bool:
        """Whether the search is decided, or the budget is used."""
        if self._to_repeat or not self._design_is_told:
            return False
        used = self._budget_is_used and not self._pending
        if not used and self._to_run_again():
            return False
        if used or (self._belief is not None and self._rule.is_decided(self._belief)):
            self._has_ended = True
            return True
        return False

    @property
    def expected_left(self) -> int:
        """Pending runs, or those that the answer still needs, with those of its verification."""
        runs = self._expected_sets * len(self.problem.scopes)
        if self._design_is_told:
            return runs
        spared = self._design_size * len(self.problem.scopes) - self.runs_of_design
        return max(self._sets(self._pending_proposals), runs - spared)

    @property
    def _expected_sets(self) -> int:
        """The same in parameter sets that are simulated in every test."""
        told, pending = self._sets_told, self._sets(self._pending_proposals)
        done = told + self._sets(evaluation.proposal for evaluation in self._others)
        usual_to_narrow = 0 if self._options.wanted_half_width is None else _USUAL_TO_NARROW
        if not self._design_is_told or self._belief is None:
            usual = self._usual_runs(self.expected_scatter)
            return max(pending, usual + usual_to_narrow - told)
        belief = self._belief
        usual = self._usual_runs(self._likely_scatter(belief.scatter, done)) - done
        # A search that has taken longer than usual is not about to end.
        usual = max(usual, math.ceil(_LONGER_THAN_USUAL * told))
        needed = min(belief.runs_needed(self.confidence_to_stop), usual)
        if not belief.is_likely:
            needed = max(needed, _USUAL_AFTER_DESIGN)
        if knowledge := self._knowledge_to_narrow(belief):
            usual_to_narrow = knowledge.runs_needed
        return max(pending, needed + usual_to_narrow)

    def _usual_runs(self, scatter: float) -> int:
        """Return the usual number of parameter sets in all, with a scatter in tolerances."""
        by_scatter = runs_with_scatter(scatter, self.problem.dimension)
        return max(self._design_size + _USUAL_AFTER_DESIGN, by_scatter)

    def _likely_scatter(self, measured: float, runs: int) -> float:
        """Return the scatter in tolerances: few runs measure it badly, so the expected one counts.

        Parameters
        ----------
        measured : float
            That of the runs so far.
        runs : int
            Their number.
        """
        # Metamodels of fewer runs have a constant trend: they take slopes for scatter.
        freedom = max(runs - RUNS_PER_COEFFICIENT * (self.problem.dimension + 1), 0)
        squares = _RUNS_OF_EXPECTED * self.expected_scatter**2 + freedom * measured**2
        return math.sqrt(squares / (_RUNS_OF_EXPECTED + freedom))

    @property
    def limit(self) -> int:
        """The budget, or the design and 20 runs per free parameter."""
        return self._allowed

    def learn_from_near(self, evaluations: Sequence[Evaluation], tests: Sequence[str]) -> None:
        """Use runs of near problems as relatives of tests, of which no more are run."""
        relatives = [Relative(test, None) for test in tests]
        self.problem = replace(self.problem, relatives=(*self.problem.relatives, *relatives))
        for relative in relatives:
            self._make_room_for(relative)
        self._others += evaluations

    def warm_start(self, evaluations: Sequence[Evaluation]) -> None:
        """Use runs of other calibrations instead of a part of the design."""
        self._others += evaluations
        for scope in self.problem.scopes:
            names = set(scope.targets).intersection(self.problem.responses)
            places = {
                tuple(evaluation.proposal.parameters[name] for name in scope.parameters)
                for evaluation in evaluations
                if names <= evaluation.response_names
            }
            left = self._design_sizes[scope.name] - len(places)
            self._design_sizes[scope.name] = max(0, left)
        for relative in self.problem.relative_scopes:
            known = [e for e in evaluations if e.proposal.asks_for(relative.name)]
            left = self._design_sizes[relative.name] - len(known)
            self._design_sizes[relative.name] = max(0, left)
        self._design_size = max(self._design_sizes.values())

    def replay(self, proposals: Sequence[Proposal]) -> None:
        """Repeat these proposals before any new one."""
        self._to_repeat.extend(proposals)

    def ask(self) -> Proposal | None:
        """Return the next proposal, or None when a pending run has to be told first."""
        if self._to_repeat:
            return self._note_asked(self._to_repeat.popleft())
        if self._budget_is_used:
            return None
        if (number := len(self._asked)) < self._design_size:
            values = self.problem.from_unit(self._design[number])
            return self._propose(values, "design", self._tests_of_design[number])
        if again := self._failed_by_machine():
            return self._propose(again.parameters, again.stage, again.tests)
        if again := self._to_run_again():
            return self._propose(again.parameters, "optimisation", again.tests)
        if self.finished:
            return None
        self._has_ended = False
        if self._belief is None:
            return None if self._pending else self._propose_space_filling()
        if starving := self._tests_without_trend():
            return self._propose_space_filling(starving)
        return self._propose_most_useful(self._belief)

    def note(self, evaluation: Evaluation) -> None:
        """Record a run, proposed by this search or not."""
        index = self._indices.get(evaluation.proposal.seed)
        if index is not None and self._asked[index] == evaluation.proposal:
            self._told[index] = evaluation
        else:
            self._others.append(evaluation)

    def answer(self, parameters: Mapping[str, float] | None = None) -> Answer:
        """Return the best parameter set by expected responses."""
        belief = self._belief
        if belief is None:
            # Says what is missing.
            Metamodels.fit(self.problem, self.known)
            raise AssertionError("metamodels that can be fitted make a belief")
        misses = belief.misses if self._rule.is_out_of_reach(belief) else ()
        chosen = parameters or belief.problem.from_unit(belief.answer)
        return make_answer(
            self._judging(belief, chosen),
            chosen,
            misses,
            spread=False,
            confidence=self.confidence,
            costs=RunCosts(belief.problem, self.known),
        )

    def _judging(self, belief: Belief, parameters: Mapping[str, float]) -> Metamodels:
        """Return the metamodels that judge an answer.

        Once it has fresh seeds, those of the runs of the tests alone: no verdict rests on
        relatives.
        """
        if not self.problem.relatives or not any(
            e.proposal.stage == "verification" and e.proposal.parameters == parameters
            for e in self.known
        ):
            return belief.metamodels
        own = replace(self.problem, parameters=belief.problem.parameters, relatives=())
        return Metamodels.fit(own, self.known)

    def resume_after_verification(self, affordable: int | None = None) -> bool:
        """Continue with the verification runs added, if doubt and budget are left."""
        if affordable is not None:
            self._allowed = min(self._allowed, self._sets(self._asked) + max(0, affordable))
        possible = (
            self._belief is not None
            and (affordable is None or affordable >= 0)
            and not self._rule.is_out_of_reach(self._belief)
            and self._resumptions < VERDICT.resumptions
        )
        self._resumptions += possible
        return possible

    # Known runs ------------------------------------------------------------------------------

    @cached_property
    def _design(self) -> Array:
        return maximin_latin_hypercube(self._design_size, self.problem.dimension, self.seed)

    @cached_property
    def _tests_of_design(self) -> list[tuple[str, ...] | None]:
        """Tests of each run of the design: those with few parameters need a part of it."""
        sizes, points = self._design_sizes, self._design
        chosen = {
            scope.name: spread_subset(points[:, self.problem.axes_of(scope)], sizes[scope.name])
            for scope in (*self.problem.scopes, *self.problem.relative_scopes)
        }
        return [
            self._some([name for name, numbers in chosen.items() if number in numbers])
            for number in range(len(points))
        ]

    def _some(self, tests: Sequence[str]) -> tuple[str, ...] | None:
        """Return the tests of a proposal, None for all of them."""
        is_all = len(tests) == len(self.problem.scopes) and not self.problem.relative_scopes
        return None if is_all else tuple(tests)

    def _sets(self, proposals: Iterable[Proposal]) -> int:
        """Number of parameter sets that take as many runs as some proposals, rounded up.

        Runs of relatives do not count.
        """
        scopes = self.problem.scopes
        runs = sum(s.repeats for p in proposals for s in scopes if p.asks_for(s.name))
        return -(-runs // sum(scope.repeats for scope in scopes))

    @property
    def _sets_told(self) -> int:
        return self._sets(self._asked[index] for index in self._told)

    @property
    def _pending(self) -> int:
        return len(self._asked) - len(self._told)

    @property
    def _budget_is_used(self) -> bool:
        tests = [test for one in self._asked for test in one.tests or ()]
        spent = cost_of_relatives(self.problem.relatives, tests)
        return self._sets(self._asked) + spent >= self._allowed

    @property
    def _design_is_told(self) -> bool:
        return all(index in self._told for index in range(self._design_size))

    @property
    def _told_after_design(self) -> int:
        """Runs of the tests after a design: of twice the usual size where relatives chose them.

        Runs about an answer that a relative has misplaced show little of the rest.
        """
        if self.problem.relatives:
            return self._sets_told - _GUIDED * self._usual_design
        return len(self._told) - self._design_size

    @property
    def _rule(self) -> StoppingRule:
        has_budget = self.max_evaluations is not None
        return StoppingRule(
            confidence=self.confidence_to_stop,
            demanded=self.confidence,
            runs_behind=self._told_after_design,
            runs_left=None if has_budget else self._allowed - self._sets_told,
        )

    @property
    def _belief(self) -> Belief | None:
        """Belief from the runs so far; None when they are too few for metamodels."""
        state = (len(self._told), len(self._others))
        if self._latest is None or self._latest[0] != state:
            known = self.known
            if not can_be_fitted(self._problem_to_believe, known):
                return None
            self._latest = (state, self._form_belief(known))
        return self._latest[1]

    def _form_belief(self, known: Sequence[Evaluation]) -> Belief:
        problem = self._problem_to_believe
        belief = self._belief_in(problem, known)
        for _ in range(_MOST_WIDENINGS if self._options.extend_intervals else 0):
            if not self._rule.is_out_of_reach(belief):
                break
            wider = widened(problem, belief.misses)
            if wider == problem:
                break
            problem, belief = wider, self._belief_in(wider, known)
        self._note(widenings(self.problem, problem))
        return belief

    @property
    def _problem_to_believe(self) -> Problem:
        """The problem, after many runs without what is known beforehand of its relatives.

        What has not led to the answer by then leads away from it.
        """
        if self._sets_told < _GUIDED * self._usual_design:
            return self.problem
        made = [one for one in self.problem.relatives if one.cost is not None]
        return replace(self.problem, relatives=made)

    def _belief_in(self, problem: Problem, known: Sequence[Evaluation]) -> Belief:
        return Belief(problem, known, self.seed, self._options, self.confidence_to_stop)

    def _note(self, notices: Iterable[str]) -> None:
        self._notices += [notice for notice in notices if notice not in self._notices]

    # Proposals -------------------------------------------------------------------------------

    def _propose(
        self, parameters: Mapping[str, float], stage: Stage, tests: tuple[str, ...] | None = None
    ) -> Proposal:
        number = len(self._asked) + 1
        seed = insertion_seed(self.seed, stage, number)
        return self._note_asked(Proposal(dict(parameters), seed, stage, tests))

    def _note_asked(self, proposal: Proposal) -> Proposal:
        self._indices[proposal.seed] = len(self._asked)
        self._asked.append(proposal)
        return proposal

    def _failed_by_machine(self) -> Proposal | None:
        """Proposal to try again: its run failed by the machine, not by its parameters."""
        for index in sorted(self._told):
            evaluation = self._told[index]
            if not evaluation.failed_by_machine:
                continue
            again = self._failed_part(evaluation)
            tries = [
                number
                for number, asked in enumerate(self._asked)
                if asked.parameters == again.parameters
                and (again.tests is None or all(map(asked.asks_for, again.tests)))
            ]
            if tries[-1] == index and len(tries) < _TRIES_OF_A_MACHINE:
                return again
        return None

    def _to_run_again(self) -> Proposal | None:
        """Proposal of a run that does not belong to the others, to see if it comes again.

        What another seed gives again belongs to its place; the rest are jams.
        """
        belief = self._belief
        suspects = belief.metamodels.suspects(belief.answer) if belief else []
        if belief is None or not suspects:
            return None
        by_seed = {evaluation.proposal.seed: evaluation.proposal for evaluation in self.known}
        for target, seed in suspects:
            outlying, scope = by_seed[seed], belief.problem.scope_of(target.name)
            asked = [
                one
                for one in self._asked
                if one.parameters == outlying.parameters
                and one.seed != seed
                and one.asks_for(scope.name)
            ]
            inside = all(p.contains(outlying.parameters[p.name]) for p in self.problem.parameters)
            if inside and not asked:
                return replace(outlying, tests=self._some([scope.name]))
        return None

    def _failed_part(self, evaluation: Evaluation) -> Proposal:
        """Return the proposal of the tests whose run failed."""
        proposal = evaluation.proposal
        if not self.problem.tests:
            return proposal
        asked = [s.name for s in self.problem.scopes if proposal.asks_for(s.name)]
        failed = [name for name in asked if evaluation.failed_in(name)]
        return replace(proposal, tests=self._some(failed))

    def _random(self) -> np.random.Generator:
        return np.random.default_rng([self.seed, len(self._asked)])

    def _propose_space_filling(self, tests: Sequence[str] | None = None) -> Proposal:
        tried = np.array([self.problem.to_unit(p.parameters) for p in self._asked])
        point = space_filling_point(self.problem, self.known, tried, self._random())
        values = self.problem.from_unit(point)
        asked = self._tests_without_metamodel() if tests is None else self._some(tests)
        return self._propose(values, "optimisation", asked)

    def _tests_without_trend(self) -> list[str]:
        """Return the tests, of several with one parameter, that have too few runs for a trend.

        After a small design or a failed run, such a test takes its trend for a hopeless scatter,
        and would never be run again. One whose runs keep failing, or read one row, is given up.
        """
        scopes = self.problem.scopes
        if self.problem.dimension > 1 or len(scopes) == 1:
            return []
        needed, lacking = runs_for_trend(self.problem.dimension), []
        for scope in scopes:
            own = [e for e in self.known if e.proposal.asks_for(scope.name)]
            failed = sum(e.failed_in(scope.name) for e in own)
            pending = sum(p.asks_for(scope.name) for p in self._pending_proposals)
            asked = sum(p.asks_for(scope.name) for p in self._asked)
            if len(own) - failed + pending < needed and asked < 2 * needed:
                lacking.append(scope.name)
        return lacking

    def _tests_without_metamodel(self) -> tuple[str, ...] | None:
        if not self.problem.tests:
            return None
        lacking = [
            scope.name
            for scope in self.problem.scopes
            for names in [set(scope.targets).intersection(self.problem.responses)]
            if not can_be_fitted(self._problem_to_believe, self.known, names)
        ]
        return self._some(lacking)

    def _propose_most_useful(self, belief: Belief) -> Proposal | None:
        pending = self._pending_proposals
        points = [belief.problem.to_unit(proposal.parameters) for proposal in pending]
        yields = [belief.metamodels.yielded_by(proposal.tests) for proposal in pending]
        at = np.array(points).reshape(-1, belief.problem.dimension)
        conditioned = belief.metamodels.condition_on_pending(at, np.array(yields))
        for relative in belief.problem.relative_scopes:
            asked = [proposal.asks_for(relative.name) for proposal in pending]
            told = np.outer(asked, conditioned.told_by(relative.name))
            conditioned = conditioned.condition_on_pending_relatives(at, told)
        chosen = self._chosen(belief, conditioned, len(pending))
        if chosen is None:
            return None
        values = belief.problem.from_unit(chosen.point)
        return self._propose(values, "optimisation", self._some([chosen.scope.name]))

    def _chosen(self, belief: Belief, conditioned: Metamodels, pending: int) -> NextRun | None:
        """Choose the next run; None where the pending ones will probably be enough."""
        costs = RunCosts(belief.problem, self.known)
        if knowledge := self._knowledge_to_narrow(belief):
            if pending and not knowledge.is_worth_runs_after(conditioned):
                return None
            return most_narrowing_run(
                conditioned, knowledge, belief.feasibility, costs, self._random()
            )
        if pending and pending_is_enough(belief, conditioned, pending, self.confidence_to_stop):
            return None
        return next_run(belief, conditioned, costs, self._random())

    def _knowledge_to_narrow(self, belief: Belief) -> ParameterKnowledge | None:
        """Knowledge of the parameters, once the answer is known and if it is to be narrowed."""
        if self._options.wanted_half_width is None or not self._rule.is_answered(belief):
            return None
        return belief.knowledge

    @property
    def _pending_proposals(self) -> list[Proposal]:
        return [p for index, p in enumerate(self._asked) if index not in self._told]


def about_half_widths(
    knowledge: ParameterKnowledge, *, is_answered: bool, is_budget_used: bool
) -> str:
    """Return the sentences for the end of a search.

    Parameters
    ----------
    knowledge : ParameterKnowledge
        By all runs.
    is_answered : bool
        Whether the answer itself was known before the search ended.
    is_budget_used : bool
        Whether no more runs were allowed.
    """
    wanted = f"±{_percent(knowledge.wanted)}"
    widths, missed = knowledge.half_widths, knowledge.too_wide
    if not missed:
        return messages.HALF_WIDTHS_REACHED(reached=_listed(widths), wanted=wanted)
    reached = _listed(widths, missed)
    sentences = [messages.HALF_WIDTHS_MISSED(reached=reached, wanted=wanted)]
    if not is_answered:
        return " ".join([*sentences, messages.NO_RUNS_BEFORE_ANSWER()])
    best = _listed(knowledge.at_best, missed)
    if knowledge.is_worth_runs and is_budget_used:
        return " ".join([*sentences, messages.MORE_RUNS_NARROW(best=best)])
    # The verification may have changed a little what is worth runs.
    if not knowledge.is_worth_runs:
        sentences.append(messages.MEASUREMENTS_LIMIT())
    return " ".join([*sentences, messages.MORE_MEASUREMENTS_NARROW(best=best)])


def _listed(half_widths: Mapping[str, float], names: Iterable[str] | None = None) -> str:
    chosen = half_widths if names is None else names
    return in_a_row(f"±{_percent(half_widths[name])} for {name}" for name in chosen)


def _percent(share: float) -> str:
    # A larger share says nothing more than that the parameter is open.
    return "100 % or more" if share >= 1.0 else f"{number(100 * share, 2)} %"
