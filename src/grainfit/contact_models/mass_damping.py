"""Damping by mass and velocity that gives a Hertz contact its restitution at one speed of impact.

LAMMPS has no damping with the same restitution at every speed for a cohesive normal force: it
refuses ``coeff_restitution`` and ``tsuji``, whose damping is infinite where such a force has no
overlap. Damping by ``mass_velocity`` is a rate times the reduced mass, at every overlap. It is
chosen to give the restitution of the material at an impact with the typical speed of the contact.
``viscoelastic`` grows with the contact radius, and that of cohesive particles at rest is so large
that beds get energy at time steps at which these do not (docs/developers/decisions.md).

References
----------
Johnson (1985), Contact Mechanics, chapter 11.4: the impact without damping.
"""

from __future__ import annotations

import math
from functools import lru_cache

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import particle_moduli

#: A restitution above it is elastic; the largest damping number gives one far below all limits.
_ELASTIC, _LARGEST = 1 - 1e-6, 2.0
#: Longest impact in units of its natural time; the most damped one leaves slowly.
_LONGEST = 1e5


def mass_damping(contact: Contact) -> float:
    """Return the damping coefficient of LAMMPS' ``damping mass_velocity``, 1/s.

    Parameters
    ----------
    contact : Contact
        With restitution, stiffness, radii, and the load that gives the speed of the impact.
    """
    restitution = contact.value("restitution")
    if restitution > _ELASTIC:
        return 0.0
    radius, mass = contact.effective_radius, contact.effective_mass
    stiffness = 4 / 3 * particle_moduli(contact.material, contact.body).young * math.sqrt(radius)
    length = (mass * contact.impact_speed**2 / stiffness) ** (2 / 5)
    # In units of length and length over speed, the damping force is number times speed.
    return float(_damping_number(restitution) * contact.impact_speed / length)


def restitution_at(number: float) -> float:
    """Return the restitution of an impact ``x'' = -x^(3/2) - number x'`` with speed 1.

    Examples
    --------
    >>> round(restitution_at(0.0), 6)
    1.0
    """

    def rates(_: float, state: tuple[float, float]) -> tuple[float, float]:
        overlap, speed = max(state[0], 0.0), state[1]
        return speed, -(overlap**1.5) - number * speed

    def overlap(_: float, state: tuple[float, float]) -> float:
        return state[0]

    overlap.terminal, overlap.direction = True, -1  # type: ignore[attr-defined]
    # SciPy takes a second to import, and only decks and cards of cohesive materials need it.
    from scipy.integrate import solve_ivp

    found = solve_ivp(
        rates, (0, _LONGEST), (0.0, 1.0), "LSODA", events=overlap, rtol=1e-9, atol=1e-12
    )
    return float(-found.y[1, -1])


@lru_cache(maxsize=256)
def _damping_number(restitution: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(lambda number: restitution_at(number) - restitution, 0.0, _LARGEST))
