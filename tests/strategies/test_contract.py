"""Both strategies keep the contract of strategies."""

import pytest

from grainfit import Sequential, Staged, Strategy
from grainfit.testing.strategy_contract import StrategyContract


class TestStaged(StrategyContract):
    @pytest.fixture
    def strategy(self) -> Strategy:
        return Staged()

    @pytest.mark.thorough
    def test_it_learns_from_runs_of_others(self, strategy, make) -> None:
        super().test_it_learns_from_runs_of_others(strategy, make)


class TestSequential(StrategyContract):
    @pytest.fixture
    def strategy(self) -> Strategy:
        return Sequential()


class TestSequentialWithAWantedHalfWidth(StrategyContract):
    @pytest.fixture
    def strategy(self) -> Strategy:
        return Sequential(wanted_half_width="22 %")

    @pytest.mark.thorough
    def test_it_learns_from_runs_of_others(self, strategy, make) -> None:
        super().test_it_learns_from_runs_of_others(strategy, make)
