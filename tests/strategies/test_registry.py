"""Which strategy a user gets, and what is said of options that make no sense."""

import pytest

from grainfit.errors import InputError
from grainfit.problem import Parameter, Problem, Target
from grainfit.strategies.registry import DEFAULT_STRATEGY, StrategyChoice, make_strategy
from grainfit.strategies.sequential.strategy import Sequential
from grainfit.strategies.staged.strategy import Staged

PROBLEM = Problem([Parameter("friction", 0.1, 0.9)], [Target("angle", 30.0)])


@pytest.mark.parametrize(
    "choice",
    [
        StrategyChoice(),
        StrategyChoice("sequential", 12, "accuracy", True),
        StrategyChoice("sequential", prefer="time_step", extend_intervals=False),
        StrategyChoice("staged", 26),
    ],
)
def test_what_makes_sense_is_accepted(choice: StrategyChoice) -> None:
    choice.check()


@pytest.mark.parametrize(
    ("choice", "weight", "keys"),
    [
        (StrategyChoice("bayesian"), 0.0, ["strategy"]),
        (StrategyChoice("Staged"), 0.0, ["strategy"]),
        (StrategyChoice(prefer="speed"), 0.0, ["prefer"]),
        (StrategyChoice(extend_intervals="yes"), 0.0, ["extend_intervals"]),
        (StrategyChoice("staged", prefer="accuracy"), 0.0, ["prefer"]),
        (StrategyChoice("staged", extend_intervals=False), 0.0, ["extend_intervals"]),
        (StrategyChoice("sequential"), 0.1, ["rayleigh_weight"]),
        (StrategyChoice("bayesian", prefer="speed"), 0.0, ["strategy", "prefer"]),
        (
            StrategyChoice("staged", prefer="time_step", extend_intervals=True),
            0.0,
            ["prefer", "extend_intervals"],
        ),
    ],
)
def test_what_makes_no_sense_is_refused_by_its_key(
    choice: StrategyChoice, weight: float, keys: list[str]
) -> None:
    with pytest.raises(InputError) as caught:
        choice.check(weight)
    assert [fault.key for fault in caught.value.faults] == keys
    assert all(fault.remedy for fault in caught.value.faults)


def test_unknown_names_are_answered_with_the_known_ones() -> None:
    with pytest.raises(InputError, match="sequential, staged"):
        StrategyChoice("bayesian").check()
    with pytest.raises(InputError, match="time_step, accuracy"):
        StrategyChoice(prefer="speed").check()


def test_the_staged_strategy_takes_a_rayleigh_weight() -> None:
    StrategyChoice("staged").check(0.1)


def test_the_strategy_that_is_wanted_is_made_with_its_options() -> None:
    assert DEFAULT_STRATEGY == "sequential"
    sequential = StrategyChoice("sequential", 7, "accuracy", True).make(PROBLEM, 3, 20)
    assert isinstance(sequential, Sequential)
    assert (sequential.design_runs, sequential.seed, sequential.max_evaluations) == (7, 3, 20)
    assert sequential.options.prefer == "accuracy"
    assert sequential.options.extend_intervals is True
    staged = StrategyChoice("staged", 9).make(PROBLEM, 3, None)
    assert isinstance(staged, Staged)
    assert staged.design_runs == 9


def test_what_is_not_said_is_left_to_the_strategy() -> None:
    strategy = StrategyChoice().make(PROBLEM, 1, None)
    assert strategy.definition == Sequential(PROBLEM, 1).definition


def test_a_budget_of_runs_is_shared_by_the_tests_and_keeps_room_for_the_verification() -> None:
    strategy = make_strategy(PROBLEM, StrategyChoice(), 2, 1, 31, 3)
    assert strategy.max_evaluations == 31 // 2 - 3
    with pytest.raises(InputError, match="Allow at least 14"):
        make_strategy(PROBLEM, StrategyChoice(), 2, 1, 13, 3)
    assert make_strategy(PROBLEM, StrategyChoice(), 2, 1, 14, 3).max_evaluations == 4
