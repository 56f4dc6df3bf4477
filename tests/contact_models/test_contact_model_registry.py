"""A material's parameters and contact law follow from the registered contact models."""

import math
from dataclasses import dataclass, replace

import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.contact_models import messages, registry
from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.epsd.contact_model import EPSD
from grainfit.contact_models.hertz_mindlin.contact_model import HERTZ_MINDLIN
from grainfit.contact_models.lammps import LammpsKeywords, lammps_clauses
from grainfit.contact_models.liggghts import LiggghtsKeywords, liggghts_model, liggghts_properties
from grainfit.contact_models.registry import (
    CONTACT_MODELS,
    MATERIAL_PARAMETERS,
    contact_law,
    contact_law_faults,
    material_parameters,
    with_defaults,
)
from grainfit.errors import InputError
from grainfit.materials.parameters import CONTACTS, declare
from grainfit.materials.sizes import ParticleSizes
from grainfit.run_definition import without_defaults
from grainfit.solvers.dem import program
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.materials import GLASS_BEADS

LIMITS = (0.0, 10.0)


@dataclass(frozen=True)
class _Adhesive(LammpsKeywords):
    """Takes the place of the normal force, as JKR does in LAMMPS."""

    def clauses(self, contact):
        return {"normal": f"jkr {contact.value('surface_energy')}"}


STICKY = ContactModel(
    "sticky",
    "sticky",
    "cohesion",
    declare(CONTACTS, "surface_energy", "γ", "J/m^2", "surface energy", LIMITS, default=0.0),
    (_Adhesive(),),
)
DAMP = ContactModel(
    "damp",
    "damp",
    "cohesion",
    declare(CONTACTS, "cohesion", "c", "J/m^3", "cohesion", LIMITS, default=0.0),
    (LiggghtsKeywords("cohesion damp", pair_properties={"cohesionEnergyDensity": "cohesion"}),),
)
UNDAMPED = replace(EPSD, name="undamped", keywords=(LiggghtsKeywords("rolling_friction undamped"),))
MODELS = (HERTZ_MINDLIN, EPSD, UNDAMPED, STICKY, DAMP)
STICKY_BEADS = {
    **GLASS_BEADS,
    "particle_particle.surface_energy": 0.05,
    "particle_wall.surface_energy": 0.0,
}


def test_the_parameters_of_version_0_1_keep_their_order():
    needed = [name for name, known in MATERIAL_PARAMETERS.items() if known.default is None]
    assert needed == list(GLASS_BEADS)


def test_the_limits_hold_the_glass_beads():
    for name, value in GLASS_BEADS.items():
        assert MATERIAL_PARAMETERS[name].lowest <= value <= MATERIAL_PARAMETERS[name].highest


def test_parameters_of_new_models_follow_those_of_their_section():
    names = list(material_parameters(MODELS))
    assert names[-6:] == [
        "particle_wall.sliding_friction",
        "particle_wall.rolling_friction",
        "particle_wall.restitution",
        "particle_wall.rolling_damping",
        "particle_wall.surface_energy",
        "particle_wall.cohesion",
    ]
    assert len(names) == 19


def test_a_model_at_its_defaults_does_not_act():
    at_defaults = {**STICKY_BEADS, "particle_particle.surface_energy": 0.0}
    for material in (GLASS_BEADS, at_defaults):
        assert contact_law(material, models=MODELS).models == (HERTZ_MINDLIN, EPSD)


def test_a_parameter_away_from_its_default_switches_its_model_on():
    law = contact_law(STICKY_BEADS, models=MODELS)
    assert law.models == (HERTZ_MINDLIN, STICKY, EPSD)


def test_the_clause_of_a_later_model_replaces_that_of_an_earlier_one_in_its_place():
    law = contact_law(STICKY_BEADS, models=MODELS)
    clauses = lammps_clauses(law, Contact.between(STICKY_BEADS, 0.005, 0.005, 9.81))
    assert [clause.split()[:2] for clause in clauses] == [
        ["jkr", "0.05"],
        ["tangential", "mindlin"],
        ["rolling", "sds"],
    ]


def test_liggghts_gets_keywords_and_properties_of_every_model():
    damp = {**GLASS_BEADS, "particle_particle.cohesion": 3.0, "particle_wall.cohesion": 1.0}
    law = contact_law(damp, models=MODELS)
    assert liggghts_model(law) == "hertz tangential history cohesion damp rolling_friction epsd"
    other = {**damp, "particle_wall.cohesion": 2.0}
    found = liggghts_properties(law, [damp, other])
    assert found.pairs["cohesionEnergyDensity"] == [
        [3.0, 1.0, 2.0],
        [1.0, 1.0, 1.0],
        [2.0, 1.0, 2.0],
    ]
    assert found.bodies["youngsModulus"] == [3.6e5, 2.11e11, 2.11e11]


def test_a_model_can_be_chosen_instead_of_the_one_that_acts_by_default():
    law = contact_law(GLASS_BEADS, chosen=["undamped"], models=MODELS)
    assert law.models == (HERTZ_MINDLIN, UNDAMPED)


def test_two_models_of_a_kind_are_refused():
    material = {**STICKY_BEADS, "particle_wall.cohesion": 1.0}
    with pytest.raises(InputError, match=messages.CONTRADICTION.pattern) as raised:
        contact_law(material, models=MODELS)
    assert [fault.key for fault in raised.value.faults] == [
        "particle_particle.surface_energy",
        "particle_wall.cohesion",
    ]


def test_a_law_knows_the_models_that_a_solver_lacks_and_the_parameters_it_needs():
    law = contact_law(STICKY_BEADS, models=MODELS)
    assert law.without("lammps") == []
    assert law.without("liggghts") == [STICKY]
    assert contact_law(GLASS_BEADS).needs("yade") == {
        "particle_particle.sliding_friction",
        "particle_wall.sliding_friction",
        "particle_particle.restitution",
        "particle_wall.restitution",
        "particle_particle.rolling_friction",
        "particle_wall.rolling_friction",
    }


@pytest.mark.parametrize("model", CONTACT_MODELS, ids=lambda model: model.name)
def test_declarations_are_complete(model):
    for parameter in model.parameters:
        assert parameter.section in CONTACTS
        assert parameter.symbol
        assert parameter.description
        assert parameter.example
        assert math.isfinite(parameter.lowest)
        assert parameter.lowest < parameter.highest


def test_a_model_without_equations_or_conventions_is_incomplete():
    assert "equations are missing" in list(replace(EPSD, equations=()).missing())
    gaps = list(replace(EPSD, conventions=EPSD.conventions[:1]).missing())
    assert gaps == ["the convention of rolling_damping is missing"]
    assert list(EPSD.missing()) == []


@pytest.fixture
def cohesive(monkeypatch):
    """A grainfit with two more contact models."""
    parameters = material_parameters(MODELS)
    for module in (registry, program):
        monkeypatch.setattr(module, "MATERIAL_PARAMETERS", parameters)
    monkeypatch.setattr(contact_law, "__defaults__", ((), MODELS))


@pytest.mark.usefixtures("cohesive")
def test_values_at_their_default_are_added_and_left_out_again():
    complete = with_defaults(GLASS_BEADS)
    assert complete.keys() - GLASS_BEADS.keys() == {
        "particle.aspect_ratio",
        *(f"{section}.{key}" for section in CONTACTS for key in ("surface_energy", "cohesion")),
    }
    assert without_defaults(complete, with_defaults({})) == GLASS_BEADS
    sticky = without_defaults(STICKY_BEADS, with_defaults({}))
    assert "particle_particle.surface_energy" in sticky


@pytest.mark.usefixtures("cohesive")
def test_a_new_contact_model_leaves_the_runs_of_other_materials_as_they_are():
    test = Heap(ParticleSizes((0.010,)))
    assert Lammps(test, GLASS_BEADS).definition({}, 1).parameters == GLASS_BEADS
    sticky = Lammps(test, GLASS_BEADS).definition({"particle_wall.surface_energy": 0.1}, 1)
    assert sticky.parameters == {**GLASS_BEADS, "particle_wall.surface_energy": 0.1}


@pytest.mark.usefixtures("cohesive")
def test_a_solver_refuses_a_model_that_it_does_not_have():
    [fault] = contact_law_faults(STICKY_BEADS, "liggghts")
    assert fault == messages.NOT_IN_SOLVER.fault(
        "particle_particle.surface_energy",
        model="sticky",
        solver="liggghts",
        remedy="Use lammps, or leave it out.",
    )
    assert contact_law_faults(STICKY_BEADS, "lammps") == []
    with pytest.raises(InputError, match=messages.NOT_IN_SOLVER.pattern):
        Liggghts(Heap(ParticleSizes((0.010,))), STICKY_BEADS)
