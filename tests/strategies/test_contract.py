"""Both strategies keep the contract of strategies."""

import pytest

from grainfit.strategies.sequential.strategy import Sequential
from grainfit.strategies.staged.strategy import Staged
from grainfit.testing.strategy_contract import Make, StrategyContract


class TestStaged(StrategyContract):
    @pytest.fixture
    def make(self) -> Make:
        return Staged


class TestSequential(StrategyContract):
    @pytest.fixture
    def make(self) -> Make:
        return Sequential
