"""Both strategies keep the contract of strategies."""

import pytest

from grainfit import Sequential, Staged, Strategy
from grainfit.testing.strategy_contract import StrategyContract


class TestStaged(StrategyContract):
    @pytest.fixture
    def strategy(self) -> Strategy:
        return Staged()


class TestSequential(StrategyContract):
    @pytest.fixture
    def strategy(self) -> Strategy:
        return Sequential()


class TestSequentialWithAWantedHalfWidth(StrategyContract):
    @pytest.fixture
    def strategy(self) -> Strategy:
        return Sequential(wanted_half_width="22 %")
