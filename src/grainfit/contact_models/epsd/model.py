"""EPSD rolling friction in closed form, as a spring and a dashpot of constant coefficients.

The reference is LIGGGHTS (``rolling_friction epsd``), which computes it from rolling friction,
rolling damping and the stiffness of the Hertz contact.

References
----------
Ai, Chen, Rotter & Ooi (2011), Powder Technology 206:269-282, model C: rolling friction (EPSD).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import (
    EffectiveModuli,
    hertz_overlap,
    hertz_stiffness,
    particle_moduli,
)

#: EPSD takes the rolling stiffness from that of the normal contact: k_r = 2.25 k_n (mu_r R*)^2.
_STIFFNESS = 2.25


@dataclass(frozen=True)
class RollingSpring:
    """Rolling resistance as a force at the effective radius, like LAMMPS' ``rolling sds``.

    Parameters
    ----------
    stiffness : float
        N/m.
    damping : float
        N s/m.
    """

    stiffness: float
    damping: float


def rolling_spring(
    moduli: EffectiveModuli,
    effective_radius: float,
    load: float,
    rolling_inertia: float,
    rolling_friction: float,
    rolling_damping: float,
) -> RollingSpring:
    """Return the spring and dashpot that are equivalent to EPSD at a normal force.

    EPSD: spring ``k_r = 2.25 k_n (mu_r R*)^2`` (N m), dashpot ``2 eta_r sqrt(I_r k_r)`` (N m s).
    The force acts on the rolling displacement R* theta and its torque has the lever R*, so both
    are divided by R*^2. EPSD's k_n = F_n / overlap grows with the load while the coefficient here
    is a constant.

    Parameters
    ----------
    moduli : EffectiveModuli
        Of the contact.
    effective_radius : float
        R*, m: r_i r_j / (r_i + r_j) of two spheres, r of a sphere on a wall.
    load : float
        Normal force, N.
    rolling_inertia : float
        I_r, kg m^2: 1.4 m r^2 of a sphere on a wall, the reduced one of two spheres.
    rolling_friction, rolling_damping : float
        mu_r and eta_r of EPSD.
    """
    overlap = hertz_overlap(load, moduli, effective_radius)
    normal_stiffness = hertz_stiffness(overlap, moduli, effective_radius)
    stiffness = _STIFFNESS * normal_stiffness * rolling_friction**2
    damping = 2 * rolling_damping * math.sqrt(rolling_inertia * stiffness) / effective_radius
    return RollingSpring(stiffness, damping)


def rolling_spring_of(contact: Contact, rolling_damping: float) -> RollingSpring:
    """Return the spring of a contact at its typical load, see `rolling_spring`."""
    return rolling_spring(
        particle_moduli(contact.material, contact.body),
        contact.effective_radius,
        contact.load,
        contact.rolling_inertia,
        contact.value("rolling_friction"),
        rolling_damping,
    )
