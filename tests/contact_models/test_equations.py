"""The equations on cards, evaluated as they are written: closed forms, decks, and impacts."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.dmt.model import pull_off_force as dmt_pull_off
from grainfit.contact_models.epsd.model import rolling_spring_of
from grainfit.contact_models.epsd2.model import rolling_stiffness_of
from grainfit.contact_models.hertz_mindlin.model import (
    hertz_overlap,
    hertz_stiffness,
    particle_moduli,
    tangential_damping_ratio,
    tangential_stiffness,
)
from grainfit.contact_models.jkr.model import force_at, unloaded_contact_radius
from grainfit.contact_models.jkr.model import pull_off_force as jkr_pull_off
from grainfit.contact_models.lammps import lammps_clauses
from grainfit.contact_models.liggghts import liggghts_properties
from grainfit.contact_models.linear.model import (
    damping_ratio_without_pull,
    restitution_without_pull,
)
from grainfit.contact_models.mass_damping import mass_damping
from grainfit.contact_models.registry import contact_law, with_defaults
from grainfit.contact_models.sjkr.model import sphere_area
from grainfit.contact_models.sjkr2.model import area_over_overlap
from grainfit.contact_models.yade import yade_body, yade_physics
from grainfit.materials.equations import Equation
from grainfit.materials.time_step import RAYLEIGH_EQUATIONS, rayleigh_time_step
from grainfit.testing.contact_model_contract import BEADS
from tests.evaluated_equations import evaluate, symbols_of

GRAVITY = 9.81
#: Two spheres of different sizes, and one on a wall of the same stiffness.
CONTACTS = {
    "spheres": Contact.between(BEADS, 0.004, 0.006, GRAVITY),
    "wall": Contact.on_wall(BEADS, 0.005, GRAVITY),
}
DELTA = 2e-4
#: A motion, in SI units.
MOTION = {"v_n": 0.2, "v_t": 0.1, "xi": 1e-5, "theta": 1e-3, "omega_r": 3.0}
_SPRINGS = ("normal stiffness", "tangential spring")
#: Thornton, Cummins & Cleary (2013), table 2.
THORNTON = (-6.918798, -16.41105, 146.8049, -796.4559, 2928.711, -7206.864, 11494.29)
THORNTON += (-11342.18, 6276.757, -1489.915)

each_contact = pytest.mark.parametrize("contact", CONTACTS.values(), ids=CONTACTS)


def terms(
    law: ContactLaw, contact: Contact, solver: str = "", **symbols: float
) -> dict[str, float]:
    """Return the terms of a law at an overlap of `DELTA`, or at a given contact radius."""
    overlap = {} if "a" in symbols else {"delta": DELTA}
    known = symbols_of(law, contact) | MOTION | overlap | symbols
    return evaluate(law.equations(solver), known)


def cohesive(name: str, key: str, value: float, contact: Contact) -> tuple[ContactLaw, Contact]:
    extra = {f"{pair}.{key}": value for pair in ("particle_particle", "particle_wall")}
    material = {**contact.material, **extra}
    found = Contact(material, contact.radius, contact.other_radius, contact.load, GRAVITY)
    return contact_law(material, [name]), found


@each_contact
def test_forces_are_those_of_hertz_and_mindlin(contact: Contact) -> None:
    found = terms(contact_law(BEADS), contact)
    moduli, radius = particle_moduli(BEADS, contact.body), contact.effective_radius

    assert found["reduced radius"] == pytest.approx(radius)
    assert found["reduced mass"] == pytest.approx(contact.effective_mass)
    stiffness = hertz_stiffness(DELTA, moduli, radius)
    assert found["elastic force"] == pytest.approx(stiffness * DELTA)
    contact_radius = math.sqrt(radius * DELTA)
    assert found["tangential spring"] == pytest.approx(
        tangential_stiffness(moduli) * contact_radius
    )
    ratio = found["tangential damping"] / found["normal damping"]
    assert ratio == pytest.approx(tangential_damping_ratio(moduli))
    assert found["sliding limit"] == pytest.approx(
        contact.value("sliding_friction") * found["normal force"]
    )


@pytest.mark.parametrize("restitution", [0.3, 0.55, 0.9])
@pytest.mark.parametrize("solver", ["lammps", "liggghts", "yade"])
@pytest.mark.parametrize("model", ["hertz_mindlin", "linear"])
def test_an_impact_by_the_equations_has_the_restitution(
    solver: str, restitution: float, model: str
) -> None:
    law = contact_law(BEADS, [model]).in_solver(solver)
    contact = replace(CONTACTS["spheres"], material=with_defaults(BEADS))
    steepness = sum(h * restitution ** (n + 1) for n, h in enumerate(THORNTON))
    given = symbols_of(law, contact) | MOTION
    given |= {"e": restitution, "h": steepness, "F_s": 0.0, "eta": 0.0}
    if model == "linear":
        given["b"] = damping_ratio_without_pull(restitution)
    # Linear springs from the same Young's modulus are stiffer.
    overlap, speed, step = 1e-9, 0.3, 5e-6 if model == "linear" else 2e-5
    while overlap > 0:
        found = evaluate(law.equations(solver), given | {"delta": overlap, "v_n": speed})
        speed -= found["normal force"] / contact.effective_mass * step
        overlap += speed * step
        # The force of YADE ends before the overlap does.
        if solver == "yade" and speed < 0 and found["normal force"] == 0:
            break

    assert -speed / 0.3 == pytest.approx(restitution, abs=0.005)


@each_contact
def test_rolling_is_that_of_epsd_with_the_reduced_radius(contact: Contact) -> None:
    law, radius = contact_law(BEADS), contact.effective_radius
    overlap = hertz_overlap(contact.load, particle_moduli(BEADS, contact.body), radius)
    found = terms(law, contact, delta=overlap)
    spring = rolling_spring_of(contact, contact.value("rolling_damping"))

    assert found["inertia of rolling"] == pytest.approx(contact.rolling_inertia)
    assert found["rolling spring"] == pytest.approx(spring.stiffness * radius**2)
    assert found["rolling damping"] == pytest.approx(spring.damping * radius**2)
    friction = contact.value("rolling_friction")
    assert found["rolling limit"] == pytest.approx(friction * radius * found["normal force"])


@each_contact
def test_the_rolling_spring_of_epsd2_is_the_tangential_one(contact: Contact) -> None:
    law = contact_law(BEADS, ["epsd2"])
    moduli = particle_moduli(BEADS, contact.body)
    overlap = hertz_overlap(contact.load, moduli, contact.effective_radius)
    found = terms(law, contact, delta=overlap)

    expected = rolling_stiffness_of(contact) * contact.effective_radius**2
    assert found["rolling spring"] == pytest.approx(expected)


@each_contact
@pytest.mark.parametrize("rolling", ["epsd", "epsd2"])
def test_coefficients_of_lammps_are_those_of_its_equations(contact: Contact, rolling: str) -> None:
    law = contact_law(BEADS, [rolling])
    moduli, radius = particle_moduli(BEADS, contact.body), contact.effective_radius
    overlap = hertz_overlap(contact.load, moduli, radius)
    found = terms(law, contact, "lammps", delta=overlap)
    clauses = {
        c.split()[0]: list(map(float, c.split()[2:])) for c in lammps_clauses(law, contact)[1:]
    }

    stiffness, damping, friction = clauses["tangential"]
    assert stiffness * math.sqrt(radius * overlap) == pytest.approx(found["tangential spring"])
    assert damping == pytest.approx(found["tangential damping"] / found["normal damping"])
    assert friction * found["normal force"] == pytest.approx(found["sliding limit"])
    stiffness, damping, friction = clauses["rolling"]
    assert stiffness * radius**2 == pytest.approx(found["rolling spring"])
    assert damping * radius**2 == pytest.approx(found.get("rolling damping", 0.0))
    assert friction * radius * found["normal force"] == pytest.approx(found["rolling limit"])


@pytest.mark.parametrize("rolling", ["epsd", "epsd2"])
def test_arguments_of_yade_are_those_of_its_equations(rolling: str) -> None:
    law, contact = contact_law(BEADS, [rolling]), Contact.between(BEADS, 0.005, 0.005, GRAVITY)
    overlap = hertz_overlap(contact.load, particle_moduli(BEADS, "particle"), 0.0025)
    given = {one.name: one.value for one in yade_physics(law, contact)}
    eta = float(given["eta"])
    found = terms(law, contact, "yade", delta=overlap, eta=eta, h=-3.0, F_s=0.0)
    usual = terms(law, contact, delta=overlap)

    assert float(given["krot"]) == pytest.approx(found["rolling spring"])
    share = found["normal force"] / usual["normal force"]
    assert found["rolling limit"] == pytest.approx(share * usual["rolling limit"])


@each_contact
@pytest.mark.parametrize("given", [{}, {"normal_stiffness": 900.0, "tangential_stiffness": 250.0}])
def test_linear_springs_are_those_of_their_equations(
    contact: Contact, given: dict[str, float]
) -> None:
    changes = {f"particle_{contact.body}.{k}": v for k, v in given.items()}
    material = with_defaults({**BEADS, **changes})
    contact = replace(contact, material=material)
    law = contact_law(material, ["linear"])
    contact = law.with_springs(contact)
    assert contact.springs is not None
    symbols = {"k_n": contact.springs.normal, "k_t": contact.springs.tangential} if given else {}
    found = evaluate(
        [e for e in law.equations("lammps") if not given or e.term not in _SPRINGS],
        symbols_of(law, contact) | MOTION | {"delta": DELTA} | symbols,
    )
    springs = contact.springs
    if given:
        assert (springs.normal, springs.tangential) == (900.0, 250.0)
    else:
        assert found["normal stiffness"] == pytest.approx(springs.normal)
        assert found["tangential spring"] == pytest.approx(springs.tangential)
    assert found["elastic force"] == pytest.approx(springs.normal * DELTA)

    clauses = {c.split()[0]: c.split()[2:] for c in lammps_clauses(law, contact)[1:]}
    stiffness, damping, friction = map(float, clauses["tangential"])
    assert stiffness == pytest.approx(springs.tangential)
    assert damping == pytest.approx(found["tangential damping"] / found["normal damping"])
    assert friction == contact.value("sliding_friction")
    stiffness, damping, _ = map(float, clauses["rolling"])
    radius = contact.effective_radius
    assert stiffness * radius**2 == pytest.approx(found["rolling spring"])
    assert damping * radius**2 == pytest.approx(found["rolling damping"])
    tangential = lammps_clauses(contact_law(material, ["linear", "epsd2"]), contact)[-1].split()[2]
    assert float(tangential) == pytest.approx(springs.tangential)

    properties = liggghts_properties(law, [material], [contact, contact])
    values = {name: matrix[0][0] for name, matrix in properties.pairs.items()}
    assert values["kn"] == pytest.approx(springs.normal)
    assert values["kt"] == pytest.approx(springs.tangential)
    mass = contact.effective_mass
    assert values["gamman"] * mass == pytest.approx(found["normal damping"])
    assert values["gammat"] * mass == pytest.approx(found["tangential damping"])


def test_bodies_of_yade_give_contacts_the_linear_springs() -> None:
    material = {**BEADS, "particle_wall.normal_stiffness": 5000.0}
    law = contact_law(material, ["linear"])
    particles = Contact.between(material, 0.005, 0.005, GRAVITY)
    on_wall = Contact.on_wall(material, 0.005, GRAVITY)
    body = yade_body(law)
    own = {a.name: float(a.value) for a in body.particle(particles)}
    wall = {a.name: float(a.value) for a in body.wall(on_wall, particles)}
    for contact, other in ((particles, own), (on_wall, wall)):
        springs = law.with_springs(contact).springs
        assert springs is not None
        assert 1 / (1 / own["kn"] + 1 / other["kn"]) == pytest.approx(springs.normal)
        assert 1 / (1 / own["ks"] + 1 / other["ks"]) == pytest.approx(springs.tangential)
        damping = 1 / (1 / own["cn"] + 1 / other["cn"])
        critical = 2 * math.sqrt(springs.normal * contact.effective_mass)
        assert restitution_without_pull(damping / critical) == pytest.approx(
            contact.value("restitution")
        )


@each_contact
def test_adhesion_is_that_of_dmt_and_jkr(contact: Contact) -> None:
    moduli, radius = particle_moduli(BEADS, contact.body), contact.effective_radius
    law, found = cohesive("dmt", "surface_energy", 0.3, contact)
    dmt = terms(law, found)
    assert dmt["pull-off force"] == pytest.approx(dmt_pull_off(0.3, radius))
    elastic = hertz_stiffness(DELTA, moduli, radius) * DELTA
    assert dmt["elastic force"] == pytest.approx(elastic - dmt_pull_off(0.3, radius))

    law, found = cohesive("jkr", "surface_energy", 0.3, contact)
    contact_radius = 1.3 * unloaded_contact_radius(0.3, moduli.young, radius)
    jkr = terms(law, found, "lammps", a=contact_radius, D=mass_damping(found))
    expected = force_at(jkr["contact radius"], 0.3, moduli.young, radius)
    assert jkr["elastic force"] == pytest.approx(expected)
    assert jkr["pull-off force"] == pytest.approx(jkr_pull_off(0.3, radius))
    assert jkr["normal damping"] == pytest.approx(mass_damping(found) * contact.effective_mass)


def test_attraction_is_that_of_sjkr_and_sjkr2() -> None:
    contact = CONTACTS["spheres"]
    radius, other = contact.radius, contact.other_radius
    assert other is not None
    law, found = cohesive("sjkr", "cohesion_energy_density", 5e3, contact)
    distance = radius + other - DELTA
    sjkr = terms(law, found, d=distance)
    assert sjkr["area of contact"] == pytest.approx(sphere_area(distance, radius, other))
    assert sjkr["attraction"] == pytest.approx(5e3 * sjkr["area of contact"])
    without = sjkr["force that limits friction"]
    assert without - sjkr["normal force"] == pytest.approx(sjkr["attraction"])

    law, found = cohesive("sjkr2", "cohesion_energy_density", 5e3, contact)
    expected = area_over_overlap(radius, other) * DELTA
    assert terms(law, found)["area of contact"] == pytest.approx(expected)


def test_the_time_step_is_that_of_its_equation() -> None:
    known = {"R": 0.005, "rho": 2100.0, "E": 3.6e5, "nu": 0.22}
    found = evaluate(RAYLEIGH_EQUATIONS, known)["Rayleigh time step"]

    assert found == pytest.approx(rayleigh_time_step(0.005, 2100.0, 3.6e5, 0.22))


def test_a_symbol_without_a_value_is_named() -> None:
    with pytest.raises(ValueError, match="G"):
        evaluate([Equation("spring", "k = 8 G a")], {"a": 1.0})
