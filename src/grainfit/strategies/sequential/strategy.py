"""The sequential strategy: every run goes where it is expected to improve the answer most.

After a small Latin hypercube, metamodels of all responses are fitted anew whenever a run has come
back, and the next run is chosen by `KnowledgeGradient`, with the runs under way counted in. It
ends when it is decided: the answer agrees with all measurements with the demanded probability, or
no parameter set can.

What it asks follows from what is known and what is under way alone, not from the way there. So
the history of an interrupted calibration is all that it takes to go on.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial.distance import cdist

from grainfit.evaluation import Evaluation, Proposal, Stage
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.metamodels.metamodels import Metamodels, can_be_fitted
from grainfit.metamodels.time_steps import EQUAL_TIME_STEPS
from grainfit.metamodels.unit_cube import points_about, shrinking_search, spread_points
from grainfit.problem import Problem
from grainfit.strategies.answer import Answer, make_answer
from grainfit.strategies.base import (
    RECONSIDERATIONS,
    Strategy,
    design_size,
    insertion_seed,
    without_repeats,
)
from grainfit.strategies.out_of_reach import widened, widenings
from grainfit.strategies.sequential.feasibility import FeasibilityModel
from grainfit.strategies.sequential.knowledge_gradient import KnowledgeGradient
from grainfit.strategies.sequential.options import (
    DESIGN_RUNS,
    RUNS_PER_PARAMETER,
    Array,
    SequentialOptions,
)
from grainfit.strategies.sequential.state import SearchState

#: Runs behind the design before a target can be called out of reach.
_RUNS_TO_CONFIRM = 2
#: Runs under way that leave so much of the accepted doubt may well be enough: it is cheaper to wait
#: for them than to make one too many.
_SMALL_DOUBT = 1.2
#: An expected gain of the time step that is worth further runs.
_GAIN_WORTH_RUNS = 0.05
#: Without a budget, runs that narrow the standard errors by less than this in all are not made.
_NARROWING_WORTH_RUNS = 0.3
_LARGEST_TIME_STEP = (
    "Of the parameter sets that agree with the measurements, the one with the largest Rayleigh "
    "time step was taken:"
)
#: Runs at the answer that are still wanted when it is verified, where runs of others were learnt
#: from. Each one more saves a run of the search, and costs some certainty (docs/decisions.md).
_LEFT_TO_VERIFICATION = 3
_TRIES_OF_A_MACHINE = 3
_MOST_WIDENINGS = 4
#: Where nothing improves the answer, the next run goes where least is known.
_TIE = 1e-6
_GLOBAL_CANDIDATES = 96
_NEAR_CANDIDATES = 32
_SPACE_FILLING_CANDIDATES = 512


class Sequential(Strategy):
    """Calibrate run by run.

    Parameters
    ----------
    problem : Problem
        What is calibrated.
    seed : int
        Decides the design and all insertion seeds.
    max_evaluations : int, optional
        Largest number of proposals; by default the design and 20 per free parameter.
    options : SequentialOptions
        Size of the design, what is preferred, when it is decided.

    Raises
    ------
    InputError
        The design is too small to fit metamodels, or larger than the budget.
    """

    name = "sequential"

    def __init__(
        self,
        problem: Problem,
        seed: int,
        max_evaluations: int | None = None,
        options: SequentialOptions | None = None,
    ) -> None:
        super().__init__(problem, seed, max_evaluations)
        self.options = options or SequentialOptions()
        usual = max(problem.dimension + 3, math.ceil(DESIGN_RUNS * (problem.dimension + 1)))
        self._whole_design = self._design_size = design_size(
            problem.dimension, self.options.design_runs, usual, max_evaluations
        )
        self._usual_design = self.options.design_runs or usual
        self._allowed = max_evaluations or (
            self._design_size + RUNS_PER_PARAMETER * problem.dimension
        )
        self._asked: list[Proposal] = []
        self._indices: dict[int, int] = {}
        self._told: dict[int, Evaluation] = {}
        self._others: list[Evaluation] = []
        self._has_learnt = False
        self._remembered: deque[Proposal] = deque()
        self._reconsidered = 0
        self._latest: tuple[tuple[int, int], SearchState] | None = None
        self._notices: list[str] = []

    @property
    def definition(self) -> dict[str, Any]:
        """All options; the budget only decides how far it goes."""
        return asdict(self.options) | {"design_runs": self._usual_design}

    @property
    def design_runs(self) -> int:
        """Size of the Latin hypercube."""
        return self._design_size

    @property
    def notices(self) -> Sequence[str]:
        """What the user should know by now."""
        return tuple(self._notices)

    @property
    def current_problem(self) -> Problem:
        """The problem with the intervals that are searched."""
        return self.problem if self._view is None else self._view.problem

    @property
    def known(self) -> list[Evaluation]:
        """All that has come back, in the order in which it was asked for."""
        told = [self._told[index] for index in sorted(self._told)]
        return without_repeats(told + self._others)

    @property
    def finished(self) -> bool:
        """Whether it is decided, or the budget is used."""
        if self._remembered or not self._design_is_told:
            return False
        if self._budget_is_used and len(self._told) == len(self._asked):
            self._note_end(self._view)
            return True
        if self._view is None or not self._is_decided(self._view):
            return False
        self._note_end(self._view)
        return True

    @property
    def expected_left(self) -> int:
        """About how many proposals are still to come."""
        under_way = len(self._asked) - len(self._told)
        if not self._design_is_told or self._view is None:
            usual = self._design_size + 2 * (self.problem.dimension + 2)
            return max(under_way, min(self._allowed, usual) - len(self._told))
        if self._is_decided(self._view):
            return under_way
        needed = self._view.runs_needed(self.options.confidence)
        return max(under_way, min(self._allowed - len(self._told), needed))

    def warm_start(self, evaluations: Sequence[Evaluation]) -> None:
        """Take these runs for part of the design."""
        self._others += evaluations
        names = {target.name for target in self.problem.targets}
        places = {
            tuple(evaluation.proposal.parameters.values())
            for evaluation in evaluations
            if names <= evaluation.responses.keys()
        }
        self._design_size = max(0, self._whole_design - len(places))
        self._has_learnt = self._design_size == 0

    def replay(self, proposals: Sequence[Proposal]) -> None:
        """Ask for these again before anything else."""
        self._remembered.extend(proposals)

    def ask(self) -> Proposal | None:
        """Return the next proposal, or None when a run has to come back first."""
        if self._remembered:
            return self._note_asked(self._remembered.popleft())
        if self._budget_is_used:
            return None
        if len(self._asked) < self._design_size:
            return self._propose(self.problem.from_unit(self._design[len(self._asked)]), "design")
        if again := self._failed_by_machine():
            return self._propose(again.parameters, again.stage)
        if self.finished:
            return None
        view, waiting = self._view, len(self._asked) - len(self._told)
        if view is None:
            return None if waiting else self._fill_in()
        ahead = view.metamodels.condition_on_pending(self._under_way(view.problem))
        if waiting and self._is_enough(view, ahead, waiting):
            return None
        point = self._next_point(view, ahead)
        return self._propose(view.problem.from_unit(point), "optimisation")

    def tell(self, evaluation: Evaluation) -> None:
        """Take note of what came of a proposal, or of a run that somebody else asked for."""
        index = self._indices.get(evaluation.proposal.seed)
        if index is not None and self._asked[index] == evaluation.proposal:
            self._told[index] = evaluation
        else:
            self._others.append(evaluation)

    def answer(self, parameters: Mapping[str, float] | None = None) -> Answer:
        """Return the parameter set that is chosen by expected responses."""
        view = self._view
        if view is None:
            # Says what is missing.
            Metamodels.fit(self.problem, self.known)
            raise AssertionError("metamodels that can be fitted make a view")
        misses = view.misses if self._is_out_of_reach(view) else ()
        chosen = parameters or view.problem.from_unit(view.answer)
        closest = view.search.closest[0]
        return make_answer(view.metamodels, chosen, misses, closest, spread=False)

    def resume_after_verification(self, affordable: int | None = None) -> bool:
        """Go on with the verification runs known, if there is any doubt and budget left."""
        if affordable is not None:
            self._allowed = min(self._allowed, len(self._asked) + max(0, affordable))
        view = self._view
        possible = (
            view is not None
            and (affordable is None or affordable >= 0)
            and not self._is_out_of_reach(view)
            and self._reconsidered < RECONSIDERATIONS
        )
        self._reconsidered += possible
        return possible

    # What is known ---------------------------------------------------------------------------

    @cached_property
    def _design(self) -> Array:
        return maximin_latin_hypercube(self._design_size, self.problem.dimension, self.seed)

    @property
    def _budget_is_used(self) -> bool:
        return len(self._asked) >= self._allowed

    @property
    def _design_is_told(self) -> bool:
        return all(index in self._told for index in range(self._design_size))

    @property
    def _view(self) -> SearchState | None:
        """What is known by now; None when it is too little for metamodels."""
        state = (len(self._told), len(self._others))
        if self._latest is None or self._latest[0] != state:
            known = self.known
            if not can_be_fitted(self.problem, known):
                return None
            self._latest = (state, self._look(known))
        return self._latest[1]

    def _look(self, known: Sequence[Evaluation]) -> SearchState:
        problem, view = self.problem, SearchState(self.problem, known, self.seed, self.options)
        for _ in range(_MOST_WIDENINGS if self.options.extend_intervals else 0):
            if not self._is_out_of_reach(view):
                break
            wider = widened(problem, view.misses)
            if wider == problem:
                break
            problem, view = wider, SearchState(wider, known, self.seed, self.options)
        self._note(widenings(self.problem, problem))
        return view

    # When it is decided ----------------------------------------------------------------------

    def _is_decided(self, view: SearchState) -> bool:
        if self._is_out_of_reach(view) or self._is_at_noise_floor(view):
            return True
        if self._is_left_to_verification(view):
            return True
        return view.agrees and view.is_proven and view.gain < _GAIN_WORTH_RUNS

    def _is_left_to_verification(self, view: SearchState) -> bool:
        """Whether runs of others tell so much that verifying the answer can decide it.

        Fresh seeds at the answer are needed in any case, and then tell the most.
        """
        return (
            self._has_learnt
            and view.is_proven
            and view.runs_needed(self.options.confidence) <= _LEFT_TO_VERIFICATION
        )

    def _is_out_of_reach(self, view: SearchState) -> bool:
        return len(self._told) >= self._design_size + _RUNS_TO_CONFIRM and bool(view.misses)

    def _is_at_noise_floor(self, view: SearchState) -> bool:
        """Whether all further runs could neither decide it nor teach much.

        A budget that the user has given is for using: then only its end ends the search.
        """
        if view.agrees or self.max_evaluations is not None:
            return False
        left = self._allowed - len(self._told)
        needed = view.runs_needed(self.options.confidence)
        return needed > left and view.narrowing(left) < _NARROWING_WORTH_RUNS

    def _note_end(self, view: SearchState | None) -> None:
        if view is None:
            return
        if self._is_out_of_reach(view):
            self._note(str(miss) for miss in view.misses)
        elif not view.agrees and not self._is_left_to_verification(view):
            self._note([view.why_undecided(self.options.confidence)])
        elif (gained := view.time_step_gained) > EQUAL_TIME_STEPS:
            self._note([f"{_LARGEST_TIME_STEP} {gained:+.1%} against the closest one."])

    def _note(self, notices: Iterable[str]) -> None:
        self._notices += [notice for notice in notices if notice not in self._notices]

    # What is asked next ----------------------------------------------------------------------

    def _propose(self, parameters: Mapping[str, float], stage: Stage) -> Proposal:
        number = len(self._asked) + 1
        seed = insertion_seed(self.seed, stage, number)
        return self._note_asked(Proposal(dict(parameters), seed, stage))

    def _note_asked(self, proposal: Proposal) -> Proposal:
        self._indices[proposal.seed] = len(self._asked)
        self._asked.append(proposal)
        return proposal

    def _under_way(self, problem: Problem) -> Array:
        points = [
            problem.to_unit(proposal.parameters)
            for index, proposal in enumerate(self._asked)
            if index not in self._told
        ]
        return np.array(points).reshape(-1, problem.dimension)

    def _failed_by_machine(self) -> Proposal | None:
        """A proposal that is worth another try: nothing is known against its parameters."""
        for index in sorted(self._told):
            proposal = self._told[index].proposal
            if not self._told[index].failed_by_machine:
                continue
            tries = [i for i, p in enumerate(self._asked) if p.parameters == proposal.parameters]
            if tries[-1] == index and len(tries) < _TRIES_OF_A_MACHINE:
                return proposal
        return None

    def _is_enough(self, view: SearchState, ahead: Metamodels, waiting: int) -> bool:
        """Whether the runs under way will probably decide what is to be decided next."""
        confidence = self.options.confidence
        if not view.agrees:
            doubt = 1.0 - float(ahead.probability_all_met(view.answer)[0])
            return doubt <= _SMALL_DOUBT * (1.0 - confidence)
        if not view.is_proven:
            return True
        return waiting >= view.metamodels.runs_needed(view.gain_point, confidence)

    def _next_point(self, view: SearchState, ahead: Metamodels) -> Array:
        if not view.agrees:
            return self._most_improving_point(view, ahead)
        return view.gain_point if view.is_proven else view.answer

    def _most_improving_point(self, view: SearchState, ahead: Metamodels) -> Array:
        random = np.random.default_rng([self.seed, len(self._asked)])
        search = view.search
        possible = search.candidates
        improvement = KnowledgeGradient(ahead, possible, view.handicaps(possible))

        def lack(points: Array) -> Array:
            unknown = ahead.deviations(points)[1].sum(axis=1)
            success = view.feasibility.success_probability(points)
            return np.asarray(-(improvement(points) + _TIE * unknown) * success**2)

        near = points_about(search.closest[:1], _NEAR_CANDIDATES, 0.25, random)
        everywhere = spread_points(_GLOBAL_CANDIDATES, view.problem.dimension, random)
        starts = np.vstack([possible, near, everywhere])
        points, _ = shrinking_search(lack, starts, random, rounds=2, width=0.08)
        return np.asarray(points[0])

    def _fill_in(self) -> Proposal:
        """A point far from all others, where runs may succeed: too few have for metamodels."""
        random = np.random.default_rng([self.seed, len(self._asked)])
        points = spread_points(_SPACE_FILLING_CANDIDATES, self.problem.dimension, random)
        tried = np.array([self.problem.to_unit(p.parameters) for p in self._asked])
        likely = FeasibilityModel(self.problem, self.known).success_probability(points)
        best = points[np.argmax(cdist(points, tried).min(axis=1) * likely)]
        return self._propose(self.problem.from_unit(best), "optimisation")
