"""Models of cohesion in closed form, and which of them acts."""

import math
from dataclasses import astuple

import numpy as np
import pytest

from grainfit.contact_models import messages
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.dmt.contact_model import DMT
from grainfit.contact_models.hertz_mindlin.contact_model import HERTZ_MINDLIN
from grainfit.contact_models.hertz_mindlin.model import (
    hertz_overlap,
    hertz_stiffness,
    particle_moduli,
)
from grainfit.contact_models.jkr.contact_model import JKR
from grainfit.contact_models.jkr.model import force_at
from grainfit.contact_models.lammps import lammps_clauses
from grainfit.contact_models.mass_damping import mass_damping, restitution_at
from grainfit.contact_models.registry import (
    contact_law,
    contact_law_faults,
    inactive_parameters,
    non_default_models,
    selectable_models,
)
from grainfit.contact_models.sjkr.contact_model import SJKR
from grainfit.contact_models.sjkr2.contact_model import SJKR2
from grainfit.errors import InputError
from grainfit.testing.materials import GLASS_BEADS

RADIUS, GRAVITY = 0.005, 9.81
ENERGY, DENSITY = "particle_particle.surface_energy", "particle_particle.cohesion_energy_density"
STICKY = {**GLASS_BEADS, ENERGY: 0.3, "particle_wall.surface_energy": 0.2}
DAMP = {**GLASS_BEADS, DENSITY: 5e3, "particle_wall.cohesion_energy_density": 3e3}
MODULI = particle_moduli(GLASS_BEADS, "particle")


def pair(material, load=1.0):
    return Contact.between(material, RADIUS, RADIUS, GRAVITY, load)


def on_wall(material, load=1.0):
    return Contact.on_wall(material, RADIUS, GRAVITY, load)


# --- closed forms ---------------------------------------------------------------------------------


def test_pull_off_of_jkr_and_dmt_follows_from_the_work_of_adhesion():
    work, radius = 2 * 0.3, RADIUS / 2
    assert JKR.attraction(pair(STICKY)).pull_off == pytest.approx(1.5 * math.pi * work * radius)
    assert DMT.attraction(pair(STICKY)).pull_off == pytest.approx(2 * math.pi * work * radius)
    assert JKR.attraction(on_wall(STICKY)).pull_off == pytest.approx(3 * math.pi * 0.2 * RADIUS)


def test_the_force_of_jkr_has_its_pull_off_and_its_overlap_without_a_load():
    found = JKR.attraction(pair(STICKY))
    overlaps = np.linspace(-found.overlap, 3 * found.overlap, 4001)
    forces = [force_at(x, 0.3, MODULI.young, RADIUS / 2) for x in overlaps]
    assert min(forces) == pytest.approx(-found.pull_off, rel=1e-4)
    at_rest = force_at(found.overlap, 0.3, MODULI.young, RADIUS / 2)
    assert abs(at_rest) < 1e-9 * found.pull_off
    # Without surface energy, it is Hertz.
    hertz = hertz_stiffness(1e-5, MODULI, RADIUS / 2) * 1e-5
    assert force_at(1e-5, 0.0, MODULI.young, RADIUS / 2) == pytest.approx(hertz)


def test_dmt_has_the_overlap_of_hertz_under_its_pull_off_force():
    found = DMT.attraction(pair(STICKY))
    assert found.overlap == pytest.approx(hertz_overlap(found.pull_off, MODULI, RADIUS / 2))
    assert found.under_load == found.pull_off


@pytest.mark.parametrize(("model", "area"), [(SJKR, math.pi), (SJKR2, 2 * math.pi)])
def test_attraction_by_area_has_the_least_force_the_rest_and_the_load_of_its_law(model, area):
    slope = 5e3 * area * RADIUS

    def force(overlap):
        return (hertz_stiffness(overlap, MODULI, RADIUS / 2) - slope) * overlap

    found = model.attraction(pair(DAMP, 5.0))
    overlaps = np.linspace(0, 2 * found.overlap, 20001)
    assert min(map(force, overlaps)) == pytest.approx(-found.pull_off, rel=1e-6)
    assert abs(force(found.overlap)) < 1e-9
    loaded = found.under_load / slope
    assert force(loaded) == pytest.approx(pair(DAMP, 5.0).load)


def test_on_a_wall_sjkr2_is_sjkr():
    one, other = (astuple(model.attraction(on_wall(DAMP))) for model in (SJKR, SJKR2))
    assert one == pytest.approx(other)


# --- damping --------------------------------------------------------------------------------------


def test_slow_impacts_lose_more():
    # The time of an impact, and with it what is lost, falls with the speed to the power 1/5.
    lost = [1 - restitution_at(number) for number in (0.01, 0.01 * 10**0.2)]
    assert lost[1] / lost[0] == pytest.approx(10**0.2, rel=0.01)


def test_damping_follows_the_load_and_not_the_unit_of_gravity():
    # Twice the load is an impact that is sqrt(2) times as fast, which is over in less time.
    one, two = (mass_damping(pair(STICKY, load)) for load in (5.0, 10.0))
    assert two / one == pytest.approx(2**0.1)


def test_an_elastic_material_is_not_damped():
    elastic = {**STICKY, "particle_particle.restitution": 1.0}
    assert mass_damping(pair(elastic)) == 0.0
    assert mass_damping(pair(STICKY)) > 0


def test_a_contact_without_surface_energy_keeps_hertz_in_lammps():
    dry_walls = {**STICKY, "particle_wall.surface_energy": 0.0}
    law = contact_law(dry_walls)
    assert lammps_clauses(law, pair(dry_walls))[0].startswith("jkr ")
    assert lammps_clauses(law, on_wall(dry_walls)) == lammps_clauses(
        contact_law(GLASS_BEADS), on_wall(GLASS_BEADS)
    )


# --- the model that acts --------------------------------------------------------------------------


def test_of_models_with_the_same_parameter_the_first_or_the_chosen_one_acts():
    assert JKR in contact_law(STICKY).models
    assert DMT in contact_law(STICKY, ["dmt"]).models
    assert SJKR in contact_law(DAMP).models
    assert SJKR2 in contact_law(DAMP, ["sjkr2"]).models


def test_a_chosen_model_without_cohesion_does_nothing():
    assert contact_law(GLASS_BEADS, ["dmt"]) == contact_law(GLASS_BEADS)
    assert contact_law({**STICKY, ENERGY: 0.0}, ["dmt"]).models[:2] == (HERTZ_MINDLIN, DMT)


def test_cohesion_by_energy_and_by_area_cannot_act_together():
    with pytest.raises(InputError, match=messages.CONTRADICTION.pattern):
        contact_law({**STICKY, DENSITY: 1e3})


def test_the_usual_models_of_cohesion_are_no_choice():
    assert selectable_models() == {
        "contact": ("hertz_mindlin", "linear"),
        "cohesion": ("sjkr", "sjkr2", "jkr", "dmt"),
        "rolling": ("epsd", "epsd2"),
    }
    assert non_default_models(["jkr"]) == non_default_models(["sjkr"]) == ()
    assert non_default_models(["dmt"]) == ("dmt",)
    with pytest.raises(InputError, match=messages.CONTRADICTION.pattern):
        non_default_models(["jkr", "dmt"])


def test_parameters_of_other_models_of_cohesion_have_no_effect():
    others = {"particle_particle.surface_energy", "particle_wall.surface_energy"}
    assert inactive_parameters(["sjkr2"]) - inactive_parameters([]) == others
    assert inactive_parameters([]).isdisjoint(others)
    [fault] = contact_law_faults({**GLASS_BEADS, ENERGY: 0.1}, "liggghts", ["sjkr2"])[-1:]
    assert fault == messages.NO_EFFECT.fault(ENERGY, models="sjkr2")
    # A default that is filled in is no fault.
    assert contact_law_faults({**DAMP, ENERGY: 0.0}, "liggghts", ["sjkr2"]) == []


@pytest.mark.parametrize(
    ("material", "chosen", "having"),
    [
        (STICKY, (), {"lammps"}),
        (STICKY, ("dmt",), {"lammps", "yade"}),
        (DAMP, (), {"liggghts"}),
        (DAMP, ("sjkr2",), {"liggghts"}),
    ],
)
def test_solvers_without_a_model_refuse_it(material, chosen, having):
    for solver in ("lammps", "liggghts", "yade"):
        faults = contact_law_faults(material, solver, chosen)
        assert (not faults) == (solver in having)
        assert all(messages.NOT_IN_SOLVER.is_in(str(fault)) for fault in faults)


def test_a_solver_with_another_model_of_the_parameter_names_that_model():
    [fault] = contact_law_faults(STICKY, "yade")
    assert str(fault).endswith(
        "jkr, which yade does not have. Use lammps, or calibrate with a model that yade has: "
        '[contact_models] cohesion = "dmt".'
    )
    assert contact_law_faults(STICKY, "yade", ["dmt"]) == []
    [fault] = contact_law_faults(STICKY, "liggghts")
    assert str(fault).endswith("jkr, which liggghts does not have. Use lammps, or leave it out.")
