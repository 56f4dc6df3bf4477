"""The contract of contact models, kept by each model in each solver that has it."""

import pytest
from programs import contacts

from grainfit.contact_models.registry import CONTACT_MODELS
from grainfit.testing.cohesion_contract import DmtContract, JkrContract, Sjkr2Contract, SjkrContract
from grainfit.testing.contact_model_contract import (
    Epsd2Contract,
    EpsdContract,
    HertzMindlinContract,
)

CONTRACTS = (
    HertzMindlinContract,
    EpsdContract,
    Epsd2Contract,
    SjkrContract,
    Sjkr2Contract,
    JkrContract,
    DmtContract,
)


def programs(model):
    """The solvers that have a model; YADE takes seconds to start."""
    slow = {"yade": (pytest.mark.slow,)}
    return [pytest.param(solver, marks=slow.get(solver, ())) for solver in model.solvers]


class TestHertzMindlin(HertzMindlinContract):
    @pytest.fixture(params=programs(HertzMindlinContract.model))
    def program(self, request):
        return contacts(request.param)


class TestEpsd(EpsdContract):
    @pytest.fixture(params=programs(EpsdContract.model))
    def program(self, request):
        return contacts(request.param)


class TestEpsd2(Epsd2Contract):
    @pytest.fixture(params=programs(Epsd2Contract.model))
    def program(self, request):
        return contacts(request.param)


class TestSjkr(SjkrContract):
    @pytest.fixture(params=programs(SjkrContract.model))
    def program(self, request):
        return contacts(request.param)


class TestSjkr2(Sjkr2Contract):
    @pytest.fixture(params=programs(Sjkr2Contract.model))
    def program(self, request):
        return contacts(request.param)


class TestJkr(JkrContract):
    @pytest.fixture(params=programs(JkrContract.model))
    def program(self, request):
        return contacts(request.param)


class TestDmt(DmtContract):
    @pytest.fixture(params=programs(DmtContract.model))
    def program(self, request):
        return contacts(request.param)


def test_every_model_has_a_contract():
    assert [contract.model for contract in CONTRACTS] == list(CONTACT_MODELS)
