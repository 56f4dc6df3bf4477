"""Linear contact in closed form: springs, dashpots, and the impact of two bodies.

References
----------
Cundall & Strack (1979), Géotechnique 29:47-65: the springs.
Schwager & Pöschel (2007), Granular Matter 9:465-469: the impact of a force that never pulls.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from grainfit.contact_models.cohesive_contacts import contacts_of
from grainfit.contact_models.contact import Contact, Springs
from grainfit.contact_models.hertz_mindlin.model import (
    SAFE_SHARE,
    particle_moduli,
    share_by_restitution,
)
from grainfit.materials.time_step import rayleigh_time_step

#: Safe step over sqrt(m* / stiffness) at restitutions from 0.6 on: half of that at which beds go
#: wrong that come to rest (benchmarks/time_steps.py), about a twentieth of the collision time.
_SAFE_STEP = 0.2
#: Damping ratio of rolling in place, with 2/7 of the mass, over that of a normal impact.
_SLIDING_DAMPING = math.sqrt(7 / 2)
_HALVINGS = 60


def springs(contact: Contact) -> Springs:
    """Return the springs of a contact: the given ones, or those that follow from Young's moduli.

    Those are the tangent stiffness of Hertz and Mindlin, 2 E* a and 8 G* a, with the radius of the
    smaller sphere for the radius a of the contact. A tangential spring that is not given is 4 G*/E*
    times the normal one.
    """
    moduli = particle_moduli(contact.material, contact.body)
    radius = min(contact.radius, contact.other_radius or math.inf)
    normal = _given(contact, "normal_stiffness") or 2 * moduli.young * radius
    tangential = _given(contact, "tangential_stiffness")
    return Springs(normal, tangential or 4 * moduli.shear / moduli.young * normal)


def _given(contact: Contact, key: str) -> float:
    return contact.material.get(f"particle_{contact.body}.{key}", 0.0)


def normal_damping(contact: Contact, damping_ratio: float) -> float:
    """Return the coefficient of the normal dashpot, N s/m: 2 zeta sqrt(k_n m*)."""
    return 2 * damping_ratio * math.sqrt(springs(contact).normal * contact.effective_mass)


def tangential_damping_ratio(contact: Contact) -> float:
    """Return the tangential over the normal dashpot: that of equal damping ratios."""
    found = springs(contact)
    return math.sqrt(found.tangential / found.normal)


def impact_overlap(speed: float, reduced_mass: float, stiffness: float) -> float:
    """Return the largest overlap of an elastic impact, m."""
    return speed * math.sqrt(reduced_mass / stiffness)


def impact_time(reduced_mass: float, stiffness: float, damping_ratio: float = 0.0) -> float:
    """Return the time of contact of an impact whose force may pull before bodies part, s."""
    return math.pi * math.sqrt(reduced_mass / stiffness / (1 - damping_ratio**2))


def restitution_without_pull(damping_ratio: float) -> float:
    """Return the restitution of a contact that ends when its force is zero.

    Examples
    --------
    >>> [round(restitution_without_pull(ratio), 3) for ratio in (0.0, 0.2, 1.0, 2.0)]
    [1.0, 0.572, 0.135, 0.048]
    """
    ratio = damping_ratio
    if ratio < 1:
        return math.exp(-2 * ratio * math.acos(ratio) / math.sqrt(1 - ratio**2))
    return (
        math.exp(-2 * ratio * math.acosh(ratio) / math.sqrt(ratio**2 - 1))
        if ratio > 1
        else (math.exp(-2))
    )


def damping_ratio_without_pull(restitution: float) -> float:
    """Return the damping ratio with which `restitution_without_pull` is a restitution."""
    low, high = 0.0, 1.0
    while restitution_without_pull(high) > restitution:
        low, high = high, 2 * high
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        is_low = restitution_without_pull(middle) > restitution
        low, high = (middle, high) if is_low else (low, middle)
    # Where there is no damping, not the last digit of any.
    return high if restitution < 1 else 0.0


def safe_time_step(material: Mapping[str, float], stiffness_ratio: float | None = None) -> float:  # noqa: ARG001
    """Return the share of the Rayleigh time step that is safe by the lowest restitution.

    Times `step_factor`; see `hertz_mindlin.model.safe_time_step`.
    """
    return share_by_restitution(material, _SLIDING_DAMPING)


def step_factor(material: Mapping[str, float], radius: float, stress: float | None) -> float:  # noqa: ARG001
    """Return how much larger a safe step is than the share that is safe for Hertz contacts.

    The stiffness is the same at every load, so that the collision time, pi sqrt(m* / k_n), decides:
    the step is in proportion to it, not to the Rayleigh time step. A particle that all neighbours
    move against is held by (k_n + 2 k_t)/3 of each contact in translation, and by 5/3 k_t of each
    (over its mass) in turning.

    Parameters
    ----------
    material : mapping of str to float
        Values of the simulated particles by dotted name.
    radius : float
        Of the smallest sphere, m.
    stress : float or None
        Of no effect.
    """
    rates = (_rate(contact) for contact in contacts_of(material, 2 * radius, 0.0).values())
    body = (material[f"particle.{key}"] for key in ("density", "youngs_modulus", "poissons_ratio"))
    longest = SAFE_SHARE * rayleigh_time_step(radius, *body)
    return _SAFE_STEP / (max(rates) * longest)


def _rate(contact: Contact) -> float:
    """Return the frequency sqrt(stiffness / m*) of a contact in a bed, 1/s."""
    found = springs(contact)
    stiffness = max(5 * found.tangential, found.normal + 2 * found.tangential) / 3
    return math.sqrt(stiffness / contact.effective_mass)
