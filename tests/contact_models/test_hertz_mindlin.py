"""Hertz and Mindlin stiffness against closed forms."""

import math

import pytest

from grainfit.contact_models.hertz_mindlin.model import (
    effective_moduli,
    hertz_overlap,
    hertz_stiffness,
    impact_overlap,
    impact_time,
    particle_moduli,
    safe_time_step,
    tangential_damping_ratio,
    tangential_stiffness,
)

MODULI = effective_moduli(3.6e5, 0.22, 3.6e5, 0.22)
RADIUS = 0.0025


def test_two_equal_bodies_have_the_moduli_of_johnsons_closed_form():
    assert pytest.approx(3.6e5 / (2 * (1 - 0.22**2))) == MODULI.young
    assert pytest.approx(3.6e5 / (4 * (2 - 0.22) * (1 + 0.22))) == MODULI.shear


def test_a_hard_wall_leaves_the_particle_as_the_only_spring():
    moduli = effective_moduli(3.6e5, 0.22, 1e20, 0.3)
    assert moduli.young == pytest.approx(3.6e5 / (1 - 0.22**2))
    assert moduli.shear == pytest.approx(3.6e5 / (2 * (2 - 0.22) * (1 + 0.22)))


def test_wall_moduli_come_from_the_wall_section():
    material = {
        "particle.youngs_modulus": 1e6,
        "particle.poissons_ratio": 0.1,
        "wall.youngs_modulus": 4e6,
        "wall.poissons_ratio": 0.4,
    }
    assert particle_moduli(material, "wall") == effective_moduli(1e6, 0.1, 4e6, 0.4)
    assert particle_moduli(material, "particle") == effective_moduli(1e6, 0.1, 1e6, 0.1)


def test_hertz_force_grows_with_the_overlap_to_the_power_three_halves():
    overlap = hertz_overlap(0.05, MODULI, RADIUS)
    assert pytest.approx(0.05) == 4 / 3 * MODULI.young * math.sqrt(RADIUS) * overlap**1.5
    assert hertz_overlap(0.05 * 8, MODULI, RADIUS) == pytest.approx(4 * overlap)


def test_stiffness_times_overlap_is_the_force():
    overlap = hertz_overlap(0.05, MODULI, RADIUS)
    assert hertz_stiffness(overlap, MODULI, RADIUS) * overlap == pytest.approx(0.05)


def test_tangential_to_normal_stiffness_is_mindlins_ratio():
    # Mindlin: k_t / k_n = 2 (1 - nu) / (2 - nu) for equal bodies, k_n = 2 E* a the tangent.
    contact_radius = 1e-3
    normal = 2 * MODULI.young * contact_radius
    tangential = tangential_stiffness(MODULI) * contact_radius
    assert tangential / normal == pytest.approx(2 * (1 - 0.22) / (2 - 0.22))


def test_both_directions_have_the_same_damping_ratio():
    # Damping coefficients are 2 zeta sqrt(S m): their ratio is the root of the stiffness ratio.
    assert tangential_damping_ratio(MODULI) ** 2 == pytest.approx(2 * (1 - 0.22) / (2 - 0.22))


def test_an_elastic_impact_turns_all_kinetic_energy_into_strain():
    overlap = impact_overlap(0.3, 1e-3, MODULI, RADIUS)
    strain = 8 / 15 * MODULI.young * math.sqrt(RADIUS) * overlap**2.5
    assert strain == pytest.approx(0.5 * 1e-3 * 0.3**2)


def test_the_time_of_an_impact_is_johnsons():
    # Johnson (1985), eq. 11.24: 2.94 times largest overlap over speed.
    overlap = impact_overlap(0.3, 1e-3, MODULI, RADIUS)
    assert impact_time(0.3, 1e-3, MODULI, RADIUS) == pytest.approx(2.94 * overlap / 0.3, rel=2e-3)


@pytest.mark.parametrize(
    ("restitution", "right", "wrong"),
    [(0.1, 0.08, 0.1), (0.2, 0.1, 0.12), (0.3, 0.12, 0.147), (0.4, 0.14, 0.18), (0.6, 0.2, 0.25)],
)
def test_beds_come_to_rest_right_with_the_safe_time_step(restitution, right, wrong):
    # Shares of the Rayleigh time step at which beds of 0.36 MPa have the density of shorter ones,
    # and at which they are 0.5 % too dense or more: benchmarks/data/time_steps.jsonl.
    contacts = ("particle_particle", "particle_wall")
    safe = safe_time_step({f"{one}.restitution": restitution for one in contacts})
    # As it is used, rounded down to a percent.
    assert 0.8 * right < math.floor(100 * safe + 1e-9) / 100 <= right < wrong
