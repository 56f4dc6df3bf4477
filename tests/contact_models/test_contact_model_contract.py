"""The contract of contact models, kept by each model in each solver that has it."""

import pytest
from programs import contacts

from grainfit.contact_models.registry import CONTACT_MODELS
from grainfit.testing.cohesion_contract import DmtContract, JkrContract, Sjkr2Contract, SjkrContract
from grainfit.testing.contact_model_contract import (
    Epsd2Contract,
    EpsdContract,
    HertzMindlinContract,
    LinearContract,
)
from grainfit.testing.single_contacts import YadeContacts
from tests.started_yade import started_yade

CONTRACTS = (
    HertzMindlinContract,
    LinearContract,
    EpsdContract,
    Epsd2Contract,
    SjkrContract,
    Sjkr2Contract,
    JkrContract,
    DmtContract,
)


def programs(model):
    """The solvers that have a model; YADE takes longest."""
    slow = {"yade": (pytest.mark.slow,)}
    return [pytest.param(solver, marks=slow.get(solver, ())) for solver in model.solvers]


class StartedYadeContacts(YadeContacts):
    """YADE in a copy of a process that has been started."""

    def simulate(self, case, folder):
        self.write(case, folder)
        self.run_script(folder / self.input_name)
        return self.read(case, folder)


@pytest.fixture(scope="module")
def yade(tmp_path_factory):
    with started_yade(tmp_path_factory.mktemp("server")) as run_script:
        program = StartedYadeContacts([])
        program.run_script = run_script
        yield program


def kept_by_solvers(contract):
    """The tests of a contract in all solvers that have its model."""

    class Kept(contract):
        @pytest.fixture(params=programs(contract.model))
        def program(self, request):
            program = contacts(request.param)
            return request.getfixturevalue("yade") if request.param == "yade" else program

    return Kept


TestHertzMindlin = kept_by_solvers(HertzMindlinContract)
TestLinear = kept_by_solvers(LinearContract)
TestEpsd = kept_by_solvers(EpsdContract)
TestEpsd2 = kept_by_solvers(Epsd2Contract)
TestSjkr = kept_by_solvers(SjkrContract)
TestSjkr2 = kept_by_solvers(Sjkr2Contract)
TestJkr = kept_by_solvers(JkrContract)
TestDmt = kept_by_solvers(DmtContract)


def test_every_model_has_a_contract():
    assert [contract.model for contract in CONTRACTS] == list(CONTACT_MODELS)
