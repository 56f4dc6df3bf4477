# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of strategies, as tests to inherit.

Write a test class for a custom strategy, in a file that pytest finds::

    from grainfit.testing.strategy_contract import StrategyContract

    class TestMyStrategy(StrategyContract):
        @pytest.fixture
        def strategy(self):
            return MyStrategy()

and pytest runs all tests below. They calibrate a heap of grains modelled by two formulas and some
noise, so that a calibration takes a second.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import FrozenInstanceError, asdict, fields, replace
from functools import cache
from typing import Any, Protocol

import numpy as np
import pytest

from grainfit.errors import InputError, RunFailedError
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.options.fields import option_keys
from grainfit.problem import Parameter, Problem, Target
from grainfit.strategies.base import Search, Strategy
from grainfit.strategies.seeds import insertion_seed

#: More proposals than any strategy may need without a budget.
MOST_PROPOSALS = 120
#: Scatter of the responses from seed to seed, as recorded heaps show it.
NOISE = {"bulk_density": 3.7, "angle": 0.8}

#: Makes the evaluation of a proposal.
Simulate = Callable[[Proposal], Evaluation]


class Make(Protocol):
    """Starts a search of the strategy under test."""

    def __call__(
        self, problem: Problem, seed: int, max_evaluations: int | None = None
    ) -> Search: ...


def heap_problem(angle: float = 22.0, tolerance: float = 0.5) -> Problem:
    """Two parameters, one of them on a logarithmic scale, and two targets.

    Parameters
    ----------
    angle : float
        Target of the angle; all from 17 to 24 are within reach.
    tolerance : float
        Its tolerance.
    """
    return Problem(
        [Parameter("density", 1407.0, 2793.0), Parameter("friction", 0.1, 1.6, scale="log")],
        [
            Target("bulk_density", 1500.0, tolerance=15.0),
            Target("angle", angle, tolerance=tolerance),
        ],
    )


def heap(proposal: Proposal, noise: float = 1.0) -> Evaluation:
    """Return the evaluation of a proposal: linear in density, saturating in friction, and noise.

    Parameters
    ----------
    proposal : Proposal
        Its parameters are ``density`` and ``friction``; its seed decides the noise.
    noise : float
        Scatter from seed to seed, as a share of `NOISE`.
    """
    expected = {
        "bulk_density": 0.645 * proposal.parameters["density"],
        "angle": 25.0 - 11.0 * math.exp(-3.0 * proposal.parameters["friction"]),
    }
    return scattered(proposal, expected, noise)


def scattered(proposal: Proposal, expected: dict[str, float], noise: float = 1.0) -> Evaluation:
    """Add the noise of a proposal's seed to expected responses.

    Parameters
    ----------
    proposal : Proposal
        Its seed decides the noise.
    expected : dict of str to float
        Responses without noise.
    noise : float
        Scatter from seed to seed, as a share of `NOISE`; responses not named there have none.
    """
    random = np.random.default_rng(proposal.seed)
    responses = {
        name: Response(value + noise * NOISE.get(name, 0.0) * random.standard_normal())
        for name, value in expected.items()
    }
    return Evaluation(proposal, responses)


def failed(proposal: Proposal, by_machine: bool = False) -> Evaluation:
    """Return the evaluation of a proposal whose run fails."""
    reason = "the disk is full" if by_machine else "the particles flew away"
    return Evaluation(proposal, {}, {"heap": reason}, failed_by_machine=by_machine)


def nearly_quiet(proposal: Proposal) -> Evaluation:
    """A heap with a tenth of the usual noise: a calibration is short."""
    return heap(proposal, 0.1)


def quiet(proposal: Proposal) -> Evaluation:
    """A heap without noise."""
    return heap(proposal, 0.0)


def converse(search: Search, simulate: Simulate, workers: int = 1) -> list[Evaluation]:
    """Answer a search until it has finished.

    Parameters
    ----------
    search : Search
        The search, whose proposals are answered.
    simulate : callable
        Makes the evaluation of a proposal.
    workers : int
        Runs at a time. With several, the latest one ends first, except that every third time the
        earliest one does.

    Returns
    -------
    list of Evaluation
        In the order in which they were told.
    """
    evaluations: list[Evaluation] = []
    under_way: list[Proposal] = []
    while not search.finished:
        while len(under_way) < workers and not search.finished:
            proposal = search.ask()
            if proposal is None:
                break
            assert proposal not in under_way
            under_way.append(proposal)
        assert under_way, "a strategy that waits for nothing never ends"
        assert search.expected_left >= 0
        proposal = under_way.pop(0 if len(evaluations) % 3 == 2 else -1)
        evaluations.append(simulate(proposal))
        search.tell(proposal, evaluations[-1])
        assert len(evaluations) <= MOST_PROPOSALS, "this strategy does not come to an end"
    for proposal in under_way:
        # Runs that were pending when the search finished end as well.
        evaluations.append(simulate(proposal))
        search.tell(proposal, evaluations[-1])
    return evaluations


class StrategyContract:
    """Tests of a strategy, on which a calibration relies; subclasses define ``strategy``."""

    @pytest.fixture
    def strategy(self) -> Strategy:
        """Return the strategy under test, with its options at their defaults."""
        raise NotImplementedError

    @pytest.fixture
    def make(self, strategy: Strategy) -> Make:
        """Return the function that starts a search: ``make(problem, seed, max_evaluations)``."""
        return strategy.start

    @pytest.fixture
    def finished(self, strategy: Strategy) -> Search:
        """Return a search that has finished with hardly any noise: a copy for each test."""
        return deepcopy(_finished(strategy)[0])

    # Options ---------------------------------------------------------------------------------

    def test_options_are_plain_frozen_data(self, strategy: Strategy) -> None:
        again = type(strategy)(**asdict(strategy))

        assert again == strategy
        assert hash(again) == hash(strategy)
        for field in fields(strategy):
            with pytest.raises(FrozenInstanceError):
                setattr(strategy, field.name, None)

    def test_every_option_is_declared_with_help_and_refuses_what_it_cannot_be(
        self, strategy: Strategy
    ) -> None:
        declared = option_keys(type(strategy))

        assert [known.name for known in declared] == [field.name for field in fields(strategy)]
        for known in declared:
            assert known.description
            assert known.default
            assert known.example
            with pytest.raises(InputError) as caught:
                replace(strategy, **{known.name: object()})
            assert [fault.key for fault in caught.value.faults] == [known.name]

    def test_searches_of_a_strategy_know_nothing_of_each_other(self, strategy: Strategy) -> None:
        first, second = (strategy.start(heap_problem(), 5) for _ in range(2))
        asked = converse(first, nearly_quiet)[0].proposal

        assert first.strategy == second.strategy == strategy
        assert first.name == strategy.name
        assert second.ask() == asked

    # Plain numbers ---------------------------------------------------------------------------

    def test_plain_numbers_are_told_as_well(self, make: Make) -> None:
        by_campaign, by_hand = make(heap_problem(), 5), make(heap_problem(), 5)
        for _ in range(by_hand.design_runs + 1):
            proposal = _asked(by_campaign)
            assert _asked(by_hand) == proposal
            evaluation = heap(proposal)
            by_campaign.tell(proposal, evaluation)
            by_hand.tell(proposal, {n: r.value for n, r in evaluation.responses.items()})

        assert by_hand.ask() == by_campaign.ask()

    def test_a_failure_is_told_by_its_error(self, make: Make) -> None:
        by_campaign, by_hand = make(heap_problem(), 5), make(heap_problem(), 5)
        for number in range(by_hand.design_runs + 1):
            proposal = _asked(by_campaign)
            assert _asked(by_hand) == proposal
            fails = number == 1
            by_campaign.tell(proposal, failed(proposal) if fails else heap(proposal))
            by_hand.tell(proposal, RunFailedError("flew away") if fails else heap(proposal))

        assert by_hand.ask() == by_campaign.ask()

    @pytest.mark.parametrize(
        ("outcome", "word"),
        [
            ({"angel": 22.0}, "angle"),
            ({}, "nothing"),
            ({"angle": math.nan}, "RunFailedError"),
            ({"angle": "steep"}, "angle"),
            (22.0, "by name"),
        ],
    )
    def test_what_cannot_be_a_response_is_named(self, make: Make, outcome: Any, word: str) -> None:
        search = make(heap_problem(), 5)

        with pytest.raises(InputError, match=word):
            search.tell(_asked(search), outcome)

    # The same again --------------------------------------------------------------------------

    def test_told_the_same_it_asks_the_same(self, strategy: Strategy, make: Make) -> None:
        first, evaluations = _finished(strategy)
        second = make(heap_problem(), 1)

        assert converse(second, nearly_quiet) == evaluations
        assert second.answer() == first.answer()

    def test_another_seed_asks_for_other_runs(self, make: Make) -> None:
        first, second = make(heap_problem(), 5), make(heap_problem(), 6)
        of_first, of_second = ([_asked(s) for _ in range(s.design_runs)] for s in (first, second))

        assert not {p.seed for p in of_first} & {p.seed for p in of_second}
        assert [p.parameters for p in of_first] != [p.parameters for p in of_second]

    def test_definition_is_plain_data_and_always_the_same(self, make: Make) -> None:
        definition = make(heap_problem(), 5).definition
        text = json.dumps(definition, sort_keys=True, allow_nan=False)

        assert json.loads(text) == definition
        assert make(heap_problem(), 5).definition == definition

    @pytest.mark.parametrize(("workers", "behind_design"), [(3, -2), (3, 1), (1, 3)])
    def test_it_goes_on_from_its_history_as_if_nothing_had_happened(
        self, make: Make, workers: int, behind_design: int
    ) -> None:
        # Few runs do not decide so narrow a tolerance, and with a budget the search must continue.
        problem = heap_problem(tolerance=0.05)
        undisturbed = make(problem, 4, 40)
        asked, told = _interrupted(undisturbed, undisturbed.design_runs + behind_design, workers)
        resumed = make(problem, 4, 40)
        _take_up(resumed, asked, told)
        under_way = [proposal for proposal in asked if proposal not in told]

        assert under_way
        # Either both ask the same, or both know that they are done.
        compared = _continue_both(undisturbed, resumed, under_way, workers)
        assert compared > 0 or (undisturbed.finished and resumed.finished)
        assert undisturbed.answer() == resumed.answer()

    # Warm starts -----------------------------------------------------------------------------

    def test_it_learns_from_runs_of_others(self, strategy: Strategy, make: Make) -> None:
        earlier = converse(make(heap_problem(angle=20.0), 8), heap)
        cold, whole = _finished(strategy, 5, 1.0)
        warm = make(heap_problem(), 5)
        warm.warm_start(earlier)
        rest = converse(warm, heap)

        assert len(rest) <= len(whole)
        for search in (cold, warm):
            _assert_close(search.answer().parameters, bulk_density=0.02, angle=0.06)
        quality = warm.answer().quality["angle"]
        assert 0.2 * NOISE["angle"] < quality.noise < 3 * NOISE["angle"]

    def test_a_run_that_is_taken_and_asked_for_counts_once(
        self, strategy: Strategy, make: Make
    ) -> None:
        search, evaluations = _finished(strategy, 5, 1.0)
        other = make(heap_problem(), 5)
        before = search.answer()
        other.warm_start(evaluations)
        for evaluation in evaluations:
            other.tell(evaluation.proposal, evaluation)

        assert other.answer().standard_errors == pytest.approx(before.standard_errors, rel=0.05)

    # Proposals -------------------------------------------------------------------------------

    def test_proposals_are_new_runs_within_the_intervals(self, strategy: Strategy) -> None:
        problem = heap_problem()
        search, evaluations = _finished(strategy)
        proposals = [evaluation.proposal for evaluation in evaluations]

        assert [p.stage for p in proposals[: search.design_runs]].count("design") == (
            search.design_runs
        )
        assert len({p.seed for p in proposals}) == len(proposals)
        for proposal in proposals:
            assert proposal.stage != "verification"
            assert proposal.seed > 0
            _assert_within(problem, proposal.parameters)

    def test_a_log_scale_is_spread_evenly_over_its_orders_of_magnitude(self, make: Make) -> None:
        problem = Problem(
            [Parameter("density", 1407.0, 2793.0), Parameter("friction", 1e-3, 1.0, "log")],
            heap_problem().targets,
        )
        search = make(problem, 1)
        proposals = [_asked(search) for _ in range(search.design_runs)]
        # Spread evenly over the values, 3 % of them were below.
        below = sum(p.parameters["friction"] < math.sqrt(1e-3) for p in proposals)

        assert 0.25 * len(proposals) <= below <= 0.75 * len(proposals)
        for proposal in proposals:
            _assert_within(problem, proposal.parameters)

    @pytest.mark.parametrize("workers", [1, 4])
    @pytest.mark.parametrize("budget", [5, 8, 13])
    def test_the_budget_is_never_exceeded(self, make: Make, budget: int, workers: int) -> None:
        search = make(heap_problem(), 2, budget)

        assert len(converse(search, heap, workers)) <= budget
        assert search.finished
        assert search.ask() is None

    def test_several_runs_at_a_time_are_all_new_and_come_to_an_end(self, make: Make) -> None:
        search = make(heap_problem(), 3)
        evaluations = converse(search, lambda p: heap(p, 0.3), workers=4)

        assert len({e.proposal.seed for e in evaluations}) == len(evaluations)
        _assert_close(search.answer().parameters, bulk_density=0.01, angle=0.04)

    # Failures --------------------------------------------------------------------------------

    @pytest.mark.parametrize("by_machine", [False, True])
    def test_a_third_of_the_runs_may_fail(self, make: Make, by_machine: bool) -> None:
        def simulate(proposal: Proposal) -> Evaluation:
            if np.random.default_rng(proposal.seed).random() < 1 / 3:
                return failed(proposal, by_machine)
            return nearly_quiet(proposal)

        search = make(heap_problem(), 1)
        evaluations = converse(search, simulate)

        assert any(e.failures for e in evaluations)
        _assert_close(search.answer().parameters, bulk_density=0.01, angle=0.03)

    def test_a_corner_may_fail(self, make: Make) -> None:
        def fails(parameters: Any) -> bool:
            return bool(parameters["density"] < 2000.0 and parameters["friction"] > 0.4)

        search = make(heap_problem(), 1)
        evaluations = converse(
            search, lambda p: failed(p) if fails(p.parameters) else nearly_quiet(p)
        )

        assert any(e.failures for e in evaluations)
        assert not fails(search.answer().parameters)
        _assert_close(search.answer().parameters, bulk_density=0.01, angle=0.03)

    def test_when_all_runs_fail_it_ends_with_the_reason(self, make: Make) -> None:
        search = make(heap_problem(), 1, 12)

        with pytest.raises(RunFailedError, match="flew away"):
            _answered(search, failed)

    def test_there_is_no_answer_without_knowledge(self, make: Make) -> None:
        with pytest.raises(RunFailedError):
            make(heap_problem(), 1).answer()

    # The answer ------------------------------------------------------------------------------

    def test_without_noise_the_answer_is_close(self, make: Make) -> None:
        search = make(heap_problem(), 1)
        converse(search, quiet)

        _assert_close(search.answer().parameters, bulk_density=0.002, angle=0.005)

    @pytest.mark.parametrize("angle", [17.0, 22.0, 30.0])
    def test_the_answer_lies_within_the_intervals(self, make: Make, angle: float) -> None:
        problem = heap_problem(angle)
        search = make(problem, 1)
        converse(search, nearly_quiet)

        assert search.current_problem == problem
        _assert_within(problem, search.answer().parameters)
        assert bool(search.answer().out_of_reach) == (angle == 30.0)

    def test_given_parameters_are_the_answer(self, make: Make) -> None:
        search = make(heap_problem(), 1, 12)
        converse(search, nearly_quiet)
        given = {"density": 2000.0, "friction": 0.3}
        answer = search.answer(given)

        assert answer.parameters == given
        assert answer.predicted["bulk_density"] == pytest.approx(1290.0, rel=0.02)
        assert set(answer.standard_errors) == set(answer.predicted) == {"bulk_density", "angle"}

    def test_one_free_parameter_is_calibrated(self, make: Make) -> None:
        problem = Problem([Parameter("friction", 0.1, 1.6, "log")], [Target("angle", 22.0)])

        def simulate(proposal: Proposal) -> Evaluation:
            values = {"density": 2000.0, **proposal.parameters}
            return replace(nearly_quiet(replace(proposal, parameters=values)), proposal=proposal)

        search = make(problem, 1)
        converse(search, simulate)

        assert search.answer().parameters["friction"] == pytest.approx(0.433, rel=0.08)

    def test_more_targets_than_parameters_are_met(self, make: Make) -> None:
        # Any two of the targets determine the parameters, and the third agrees with them.
        height = Target("height", 0.1 * math.tan(math.radians(22.0)), tolerance=0.001)
        problem = replace(heap_problem(), targets=[*heap_problem().targets, height])

        def simulate(proposal: Proposal) -> Evaluation:
            evaluation = nearly_quiet(proposal)
            angle = evaluation.responses["angle"].value
            of_height = Response(0.1 * math.tan(math.radians(angle)))
            return replace(evaluation, responses={**evaluation.responses, "height": of_height})

        search = make(problem, 1)
        converse(search, simulate)

        _assert_close(search.answer().parameters, bulk_density=0.01, angle=0.02)
        assert search.answer().predicted["height"] == pytest.approx(height.value, abs=0.001)

    # Verification ----------------------------------------------------------------------------

    def test_verification_runs_are_knowledge(self, finished: Search) -> None:
        answer = finished.answer()
        _verify(finished, 1.0)
        again = finished.answer(answer.parameters)

        assert again.predicted["angle"] > answer.predicted["angle"] + 0.1

    @pytest.mark.parametrize("affordable", [0, 3, 10])
    def test_after_a_verification_it_asks_for_no_more_than_is_affordable(
        self, finished: Search, affordable: int
    ) -> None:
        _verify(finished, 2.0)
        goes_on = finished.resume_after_verification(affordable)
        more = converse(finished, nearly_quiet)

        assert len(more) <= affordable
        assert goes_on or not more
        if affordable == 10:
            assert more, "the verification was far off, and there is budget to do something"

    def test_without_budget_it_does_not_go_on(self, finished: Search) -> None:
        _verify(finished, 2.0)

        assert finished.resume_after_verification(affordable=-1) is False
        assert finished.finished

    def test_verifications_that_stay_off_come_to_an_end(self, finished: Search) -> None:
        for number in range(10):
            _verify(finished, 2.0, number)
            if not finished.resume_after_verification(affordable=4):
                break
            converse(finished, nearly_quiet)
        else:
            pytest.fail("the search never ends")

        assert finished.finished


@cache
def _finished(
    strategy: Strategy, seed: int = 1, noise: float = 0.1
) -> tuple[Search, list[Evaluation]]:
    """Return a finished search that several tests look at, and its evaluations."""
    search = strategy.start(heap_problem(), seed)
    return search, converse(search, lambda proposal: heap(proposal, noise))


def _asked(search: Search) -> Proposal:
    proposal = search.ask()
    assert proposal is not None
    return proposal


def _answered(search: Search, simulate: Simulate) -> object:
    converse(search, simulate)
    return search.answer()


def _assert_within(problem: Problem, parameters: Any) -> None:
    assert set(parameters) == set(problem.intervals)
    for name, (low, high) in problem.intervals.items():
        assert low <= parameters[name] <= high


def _assert_close(parameters: Any, bulk_density: float, angle: float) -> None:
    """Assert that the responses without noise deviate by at most these shares of the targets."""
    truth = quiet(Proposal(parameters, 1, "verification")).responses

    assert truth["bulk_density"].value == pytest.approx(1500.0, rel=bulk_density)
    assert truth["angle"].value == pytest.approx(22.0, rel=angle)


def _verify(search: Search, off: float, number: int = 0) -> None:
    """Tell runs at the answer whose angle is off by some degrees."""
    parameters = search.answer().parameters
    for run in range(3):
        seed = insertion_seed(search.seed, "verification", 3 * number + run + 1)
        evaluation = nearly_quiet(Proposal(parameters, seed, "verification"))
        angle = Response(evaluation.responses["angle"].value + off)
        responses = {**evaluation.responses, "angle": angle}
        search.tell(evaluation.proposal, replace(evaluation, responses=responses))


# Interruptions ------------------------------------------------------------------------------


def _interrupted(search: Search, runs: int, workers: int) -> tuple[list[Proposal], list[Proposal]]:
    """Answer a number of runs; return the proposals asked, and those already told."""
    asked: list[Proposal] = []
    told: list[Proposal] = []
    while True:
        while len(asked) - len(told) < workers and (proposal := search.ask()) is not None:
            asked.append(proposal)
        if len(told) >= runs and len(asked) > len(told):
            return asked, told
        _tell_latest(search, asked, told)


def _tell_latest(search: Search, asked: Sequence[Proposal], told: list[Proposal]) -> None:
    told.append(next(p for p in reversed(asked) if p not in told))
    search.tell(told[-1], heap(told[-1]))


def _take_up(search: Search, asked: Sequence[Proposal], told: Sequence[Proposal]) -> None:
    """Let a new search ask for its whole history again, and tell it the known runs."""
    search.replay(asked)
    again: list[Proposal] = []
    known = [proposal for proposal in asked if proposal in told]
    while len(again) < len(asked):
        proposal = search.ask()
        if proposal is None:
            # A batch must end before the search asks for the next one.
            answered = known.pop(next(i for i, p in enumerate(known) if p in again))
            search.tell(answered, heap(answered))
            continue
        # A batch may be asked for in another order than before.
        assert proposal in asked, "it asks for something else than before"
        assert proposal not in again
        again.append(proposal)
    for proposal in reversed(known):
        search.tell(proposal, heap(proposal))


def _continue_both(
    first: Search, second: Search, under_way: list[Proposal], workers: int, most: int = 4
) -> int:
    """Continue two searches that must ask the same; return the number of proposals of both."""
    asked = 0
    for _ in range(most + len(under_way)):
        # One worker more than before: the next proposal is compared before anything else is told.
        while len(under_way) <= workers and asked < most:
            proposal, other = first.ask(), second.ask()
            assert proposal == other
            if proposal is None:
                break
            under_way.append(proposal)
            asked += 1
        if not under_way:
            break
        evaluation = heap(under_way.pop(0))
        first.tell(evaluation.proposal, evaluation)
        second.tell(evaluation.proposal, evaluation)
    return asked
