"""Contact coefficients against closed forms."""

import math

import pytest

from grainfit.contact_models.hertz_mindlin.model import (
    EffectiveModuli,
    effective_moduli,
    hertz_overlap,
    hertz_stiffness,
    particle_moduli,
    rolling_spring,
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


@pytest.mark.parametrize("friction", [0.1, 0.67, 2.0])
def test_rolling_spring_reaches_the_full_torque_at_the_angle_of_epsd(friction):
    # Ai et al. (2011): full mobilisation at theta = overlap / (2.25 mu_r R*), torque mu_r R* F_n.
    weight = 0.0108
    force = 5 * weight
    overlap = hertz_overlap(force, MODULI, RADIUS)
    spring = rolling_spring(MODULI, RADIUS, weight, 4e-8, friction, 0.25)
    angle = overlap / (2.25 * friction * RADIUS)
    torque = spring.stiffness * (RADIUS * angle) * RADIUS
    assert torque == pytest.approx(friction * RADIUS * force)


def test_rolling_damping_of_one_is_critical():
    inertia = 4e-8
    spring = rolling_spring(MODULI, RADIUS, 0.0108, inertia, 0.67, 1.0)
    torsional_stiffness = spring.stiffness * RADIUS**2
    torsional_damping = spring.damping * RADIUS**2
    assert torsional_damping == pytest.approx(2 * math.sqrt(inertia * torsional_stiffness))


def test_no_rolling_friction_means_no_spring_and_no_dashpot():
    spring = rolling_spring(EffectiveModuli(1e6, 1e5), RADIUS, 0.01, 4e-8, 0.0, 0.25)
    assert (spring.stiffness, spring.damping) == (0.0, 0.0)
