"""A warm start saves runs of the sequential strategy."""

from __future__ import annotations

from dataclasses import replace

from grainfit.strategies.sequential.strategy import Sequential
from grainfit.testing.strategy_contract import converse, heap, heap_problem


def test_runs_of_others_stand_in_for_the_design_and_most_of_the_search() -> None:
    runs = {"cold": 0, "warm": 0}
    for seed in range(1, 4):
        earlier = converse(Sequential().start(heap_problem(angle=19.0), 50 + seed), heap)
        runs["cold"] += len(converse(Sequential().start(heap_problem(), seed), heap))
        warm = Sequential().start(heap_problem(), seed)
        warm.warm_start(earlier)
        assert warm.design_runs == 0
        runs["warm"] += len(converse(warm, heap))
    # A search that hands over to its verification leaves little to save behind the design.
    assert 0 < runs["warm"] <= 2 * runs["cold"] / 3


def test_few_runs_of_others_make_the_design_smaller_by_their_number() -> None:
    whole = Sequential().start(heap_problem(), 1)
    evaluations = converse(Sequential().start(heap_problem(), 2), heap)
    search = Sequential().start(heap_problem(), 1)
    # Another seed at the same place is no other place.
    again = replace(evaluations[0], proposal=replace(evaluations[0].proposal, seed=1))
    search.warm_start([*evaluations[:2], again])
    assert search.design_runs == whole.design_runs - 2
    assert search.definition == whole.definition
