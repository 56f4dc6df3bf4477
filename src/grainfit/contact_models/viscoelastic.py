"""Viscoelastic damping that gives a Hertz contact its restitution at one speed of impact.

LAMMPS has no damping with the same restitution at every speed for a cohesive normal force: it
refuses ``coeff_restitution`` and ``tsuji``, whose damping is infinite where such a force has no
overlap. Damping by ``viscoelastic`` grows with mass and contact radius, ``D m* a``. It is chosen
to give the restitution of the material at an impact with the speed sqrt(g d).

References
----------
Brilliantov, Spahn, Hertzsch & Pöschel (1996), Phys. Rev. E 53:5382-5392: viscoelastic spheres.
Brilliantov, Albers, Spahn & Pöschel (2007), Phys. Rev. E 76:051302: the same with adhesion.
Ramírez, Pöschel, Brilliantov & Schwager (1999), Phys. Rev. E 60:4465-4472: 1 - e grows with the
speed to the power 1/5.
"""

from __future__ import annotations

import math
from functools import lru_cache

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import particle_moduli

#: A restitution above it is elastic; the largest damping number gives one far below all limits.
_ELASTIC, _LARGEST = 1 - 1e-6, 10.0
#: Longest impact in units of its natural time; the most damped one leaves slowly.
_LONGEST = 1e5


def viscoelastic_damping(contact: Contact) -> float:
    """Return the damping coefficient of LAMMPS' ``damping viscoelastic``, 1/(m s).

    Parameters
    ----------
    contact : Contact
        With restitution, stiffness, radii, and the gravity of the impact speed.
    """
    restitution = contact.value("restitution")
    if restitution > _ELASTIC:
        return 0.0
    radius, mass = contact.effective_radius, contact.effective_mass
    stiffness = 4 / 3 * particle_moduli(contact.material, contact.body).young * math.sqrt(radius)
    length = (mass * contact.impact_speed**2 / stiffness) ** (2 / 5)
    # In units of length and length over speed, the damping force is number sqrt(overlap) speed.
    contact_radius = math.sqrt(radius * length)
    return float(_damping_number(restitution) * contact.impact_speed / (length * contact_radius))


def restitution_at(number: float) -> float:
    """Return the restitution of an impact ``x'' = -x^(3/2) - number sqrt(x) x'`` with speed 1.

    Examples
    --------
    >>> round(restitution_at(0.0), 6)
    1.0
    """

    def rates(_: float, state: tuple[float, float]) -> tuple[float, float]:
        overlap, speed = max(state[0], 0.0), state[1]
        return speed, -(overlap**1.5) - number * math.sqrt(overlap) * speed

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
