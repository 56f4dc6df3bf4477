"""EPSD rolling friction in closed form, as a spring and a dashpot of constant coefficients.

The reference is LIGGGHTS (``rolling_friction epsd``), which computes it from rolling friction,
rolling damping and the stiffness of the Hertz contact.

References
----------
Ai, Chen, Rotter & Ooi (2011), Powder Technology 206:269-282, model C: rolling friction (EPSD).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import (
    NEIGHBOURS,
    EffectiveModuli,
    hertz_overlap,
    hertz_stiffness,
    particle_moduli,
    safe_share,
)

#: EPSD takes the rolling stiffness from that of the normal contact: k_r = 2.25 k_n (mu_r R*)^2.
_STIFFNESS = 2.25
#: Usual values, where a parameter is not known.
_ROLLING_FRICTION, _ROLLING_DAMPING, _POISSONS_RATIO = 1.0, 0.25, 0.3


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
    return _rolling_spring(
        normal_stiffness, effective_radius, rolling_inertia, rolling_friction, rolling_damping
    )


def _rolling_spring(
    normal_stiffness: float,
    effective_radius: float,
    rolling_inertia: float,
    rolling_friction: float,
    rolling_damping: float,
) -> RollingSpring:
    stiffness = _STIFFNESS * normal_stiffness * rolling_friction**2
    damping = 2 * rolling_damping * math.sqrt(rolling_inertia * stiffness) / effective_radius
    return RollingSpring(stiffness, damping)


def safe_time_step(material: Mapping[str, float], stiffness_ratio: float | None = None) -> float:
    """Return the share of the Rayleigh time step that is safe for rolling spring and dashpot.

    Two equal spheres that turn against each other have the rolling frequency
    ``w_r^2 = 45/16 mu_r^2 k_n / m``, two that slide on each other ``w_s^2 = 7 k_t / m``, with the
    secant stiffness ``k_n = (2 - nu)/(3 - 3 nu) k_t``. The dashpot ``2 eta_r sqrt(I_r k_r)`` with
    the inertia of rolling along is ``sqrt(7/2) eta_r`` times critical for turning in place, and of
    several neighbours the root of their number more. See `hertz_mindlin.model.safe_time_step`.

    Parameters
    ----------
    material : mapping of str to float
        Values by dotted name; usual ones where they are missing. A wall touches a particle once,
        and is left out.
    stiffness_ratio : float, optional
        Stiffness of the normal over that of the tangential spring; that above without it.

    Examples
    --------
    >>> contacts = {f"particle_particle.rolling_{a}": b for a, b in
    ...             {"friction": 0.67, "damping": 1.0}.items()}
    >>> round(safe_time_step({**contacts, "particle.poissons_ratio": 0.22}), 3)
    0.093
    """
    friction = material.get("particle_particle.rolling_friction", _ROLLING_FRICTION)
    damping = material.get("particle_particle.rolling_damping", _ROLLING_DAMPING)
    ratio = material.get("particle.poissons_ratio", _POISSONS_RATIO)
    over_tangential = stiffness_ratio or (2 - ratio) / (3 - 3 * ratio)
    frequency = friction * math.sqrt(45 / 16 * over_tangential / 7)
    return safe_share(frequency, math.sqrt(3.5 * NEIGHBOURS) * damping)


def rolling_spring_of(contact: Contact, rolling_damping: float) -> RollingSpring:
    """Return the spring of a contact at its typical load, see `rolling_spring`."""
    radius, inertia = contact.effective_radius, contact.rolling_inertia
    friction = contact.value("rolling_friction")
    if contact.springs is not None:
        normal = contact.springs.normal
        return _rolling_spring(normal, radius, inertia, friction, rolling_damping)
    moduli = particle_moduli(contact.material, contact.body)
    return rolling_spring(moduli, radius, contact.load, inertia, friction, rolling_damping)
