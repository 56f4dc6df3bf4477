"""The rolling spring against closed forms."""

import math

import pytest

from grainfit.contact_models.contact import Contact, particle_mass
from grainfit.contact_models.epsd.model import rolling_spring, safe_time_step
from grainfit.contact_models.hertz_mindlin.model import (
    EffectiveModuli,
    effective_moduli,
    hertz_overlap,
)
from grainfit.testing.materials import GLASS_BEADS

MODULI = effective_moduli(3.6e5, 0.22, 3.6e5, 0.22)
RADIUS = 0.0025
_OVER_TANGENTIAL = (2 - 0.22) / (3 - 3 * 0.22)


@pytest.mark.parametrize("friction", [0.1, 0.67, 2.0])
def test_rolling_spring_reaches_the_full_torque_at_the_angle_of_epsd(friction):
    # Ai et al. (2011): full mobilisation at theta = overlap / (2.25 mu_r R*), torque mu_r R* F_n.
    weight = 0.0108
    force = 5 * weight
    overlap = hertz_overlap(force, MODULI, RADIUS)
    spring = rolling_spring(MODULI, RADIUS, force, 4e-8, friction, 0.25)
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


def test_the_inertia_of_rolling_is_that_about_the_point_of_contact():
    # 7/5 m r^2 on a wall (parallel axis); two equal particles have half of it.
    own = 1.4 * particle_mass(GLASS_BEADS, RADIUS) * RADIUS**2
    assert Contact.on_wall(GLASS_BEADS, RADIUS, 9.81).rolling_inertia == pytest.approx(own)
    pair = Contact.between(GLASS_BEADS, RADIUS, RADIUS, 9.81)
    assert pair.rolling_inertia == pytest.approx(own / 2)


def test_the_typical_load_is_five_particle_weights():
    weight = particle_mass(GLASS_BEADS, RADIUS) * 9.81
    assert Contact.on_wall(GLASS_BEADS, RADIUS, 9.81).load == pytest.approx(5 * weight)
    assert Contact.between(GLASS_BEADS, RADIUS, RADIUS, 9.81).load == pytest.approx(5 * weight)


def test_the_effective_radius_is_that_of_hertz():
    assert Contact.on_wall(GLASS_BEADS, RADIUS, 9.81).effective_radius == RADIUS
    pair = Contact.between(GLASS_BEADS, RADIUS, 3 * RADIUS, 9.81)
    assert pair.effective_radius == pytest.approx(0.75 * RADIUS)


def test_the_safe_time_step_is_that_at_which_rolling_in_place_becomes_unstable():
    """A particle turns against four that turn the other way, its dashpots a half step behind."""

    def is_stable(step, friction, damping):
        # In units in which the tangential stiffness, the mass and the radius are one.
        stiffness = 2.25 * _OVER_TANGENTIAL * (friction / 2) ** 2
        inertia = 0.4
        dashpot = 2 * damping * math.sqrt(0.7 * stiffness)
        angle, spin = 1e-3, 0.0
        for _ in range(4000):
            # Both turn: twice the angle and twice the spin.
            torque = -4 * 2 * (stiffness * angle + dashpot * spin)
            spin += step * torque / inertia
            angle += step * spin
            if abs(angle) > 1:
                return False
        return True

    def limit(friction, damping):
        low, high = 0.0, 100.0
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (middle, high) if is_stable(middle, friction, damping) else (low, middle)
        return low

    def share(friction, damping):
        contact = "particle_particle.rolling_"
        material = {f"{contact}friction": friction, f"{contact}damping": damping}
        return safe_time_step({**material, "particle.poissons_ratio": 0.22})

    undamped = limit(5.0, 0.0) / share(5.0, 0.0)
    for friction, damping in [(2.5, 0.25), (0.67, 1.0), (1.5, 0.5), (4.0, 0.1)]:
        assert limit(friction, damping) / share(friction, damping) == pytest.approx(
            undamped, rel=0.01
        )
