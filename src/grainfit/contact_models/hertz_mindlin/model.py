"""Hertz-Mindlin contact in closed form: stiffness, damping, and the impact of two bodies.

References
----------
Johnson (1985), Contact Mechanics, chapters 4.2, 7.2 and 11.4: Hertz and Mindlin stiffness, impact.
Tsuji, Tanaka & Ishida (1992), Powder Technology 71:239-250; Antypov & Elliott (2011), EPL 94:50004:
damping of a Hertz contact from the coefficient of restitution.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from grainfit.materials.touching import ONE_PAIR, Touching
from grainfit.materials.walls import same_on_walls

#: Contact time of an elastic impact, divided by largest overlap over speed:
#: 4/5 sqrt(pi) Gamma(2/5) / Gamma(9/10).
_IMPACT_TIME = 4 / 5 * math.sqrt(math.pi) * math.gamma(2 / 5) / math.gamma(9 / 10)


#: Largest share of the Rayleigh time step at which beds come to rest with the responses of smaller
#: steps, and the restitution at which it was measured (benchmarks/time_steps.py).
SAFE_SHARE, _RESTITUTION = 0.2, 0.6
#: Young's modulus over the largest stress of the bed in which it was measured, and of the stiffest
#: bed.
_SOFT_BED, _STIFF_BED = 250.0, 6_800.0
#: Share that is safe where the restitution is not known.
_USUALLY_SAFE = 0.12
#: Damping ratio of rolling in place over that of a normal impact: sqrt(7/2) sqrt(5/6).
_SLIDING_DAMPING = math.sqrt(35 / 12)
#: Neighbours that a particle in a bed moves against: their springs and dashpots add up.
NEIGHBOURS = 4


@dataclass(frozen=True)
class EffectiveModuli:
    """Stiffness of the contact of two bodies.

    Parameters
    ----------
    young : float
        Effective Young's modulus E*, Pa.
    shear : float
        Effective shear modulus G*, Pa.
    """

    young: float
    shear: float


def effective_moduli(
    youngs_modulus: float,
    poissons_ratio: float,
    other_youngs_modulus: float,
    other_poissons_ratio: float,
) -> EffectiveModuli:
    """Return the effective moduli of the contact of two bodies (Johnson 1985, eqs 4.22 and 7.42).

    Examples
    --------
    >>> effective_moduli(1e7, 0.0, 1e7, 0.0).young
    5000000.0
    """
    pairs = ((youngs_modulus, poissons_ratio), (other_youngs_modulus, other_poissons_ratio))
    return EffectiveModuli(
        1 / sum((1 - nu**2) / young for young, nu in pairs),
        1 / sum(2 * (2 - nu) * (1 + nu) / young for young, nu in pairs),
    )


def particle_moduli(material: Mapping[str, float], body: str) -> EffectiveModuli:
    """Return the effective moduli of a particle against a ``"particle"`` or a ``"wall"``."""
    return effective_moduli(
        material["particle.youngs_modulus"],
        material["particle.poissons_ratio"],
        material[f"{body}.youngs_modulus"],
        material[f"{body}.poissons_ratio"],
    )


def hertz_overlap(force: float, moduli: EffectiveModuli, effective_radius: float) -> float:
    """Return the overlap at which a Hertz contact carries a force, m (Johnson 1985, eq. 4.23)."""
    return float((force / (4 / 3 * moduli.young * math.sqrt(effective_radius))) ** (2 / 3))


def hertz_stiffness(overlap: float, moduli: EffectiveModuli, effective_radius: float) -> float:
    """Return the secant stiffness force / overlap of a Hertz contact, N/m."""
    return 4 / 3 * moduli.young * math.sqrt(effective_radius * overlap)


def tangential_stiffness(moduli: EffectiveModuli) -> float:
    """Return the Mindlin stiffness over the contact radius, 8 G*, Pa."""
    return 8 * moduli.shear


def tangential_damping_ratio(moduli: EffectiveModuli) -> float:
    """Return the tangential damping coefficient over the normal one.

    Both are ``2 sqrt(5/6) beta sqrt(S m*)``, with the tangent stiffness S_n = 2 E* a in the normal
    and S_t = 8 G* a in the tangential direction, so their ratio is sqrt(S_t / S_n).
    """
    return math.sqrt(4 * moduli.shear / moduli.young)


def damping_factor(restitution: float) -> float:
    """Return beta of the damping 2 sqrt(5/6) beta sqrt(S m*): -ln e / sqrt(ln^2 e + pi^2).

    Examples
    --------
    >>> round(damping_factor(0.5), 4)
    0.2155
    """
    logarithm = math.log(restitution)
    return -logarithm / math.hypot(logarithm, math.pi)


def safe_time_step(material: Mapping[str, float], stiffness_ratio: float | None = None) -> float:  # noqa: ARG001
    """Return the largest safe share of the Rayleigh time step, by the lowest restitution.

    The damping force lags by half a step, so that a mode of frequency w and damping ratio z is
    stable up to a step of ``2 / w (sqrt(1 + z^2) - z)``. A contact gives way most easily to
    rolling in place, with 2/7 of the mass: ``z = sqrt(35 / 12) beta``, and several neighbours damp
    it by the root of their number more. The highest frequency of a bed follows from one measured
    limit. Restitutions of 0.1 to 0.95 agree with it; above 0.6 the share is not increased.

    Parameters
    ----------
    material : mapping of str to float
        Values by dotted name. Without both restitutions, a share that is usually safe.
    stiffness_ratio : float, optional
        Of no effect.

    References
    ----------
    Belytschko, Liu & Moran (2000), Nonlinear Finite Elements for Continua and Structures,
    chapter 6.2: stability of central differences with damping.

    Examples
    --------
    >>> [
    ...     round(safe_time_step({f"particle_{b}.restitution": e for b in ("particle", "wall")}), 3)
    ...     for e in (0.1, 0.2, 0.4, 0.9)
    ... ]
    [0.079, 0.099, 0.144, 0.2]
    """
    return share_by_restitution(material, _SLIDING_DAMPING)


def share_by_restitution(
    material: Mapping[str, float], sliding_damping: float, touching: Touching = ONE_PAIR
) -> float:
    """Return the share of the Rayleigh time step that is safe by the lowest restitution.

    Parameters
    ----------
    material : mapping of str to float
        Values by dotted name. Without both restitutions, a share that is usually safe.
    sliding_damping : float
        Damping ratio of rolling in place over that of a normal impact, of one contact.
    touching : Touching
        Contact of two clumps; by default of two spheres.
    """
    names = ("particle_particle.restitution", "particle_wall.restitution")
    found = [same_on_walls(name, material) for name in names]
    if not all(found):
        return _USUALLY_SAFE
    lowest = min(material[name] for names_on_walls in found for name in names_on_walls)
    of_bed = math.sqrt(NEIGHBOURS) * sliding_damping
    damping, usual = (of_bed * damping_factor(e) for e in (lowest, _RESTITUTION))
    stable = _stable_step(touching.damping * damping) / _stable_step(usual)
    return SAFE_SHARE * min(1.0, stable / touching.frequency)


def clump_factor(material: Mapping[str, float], touching: Touching) -> float:
    """Return the share of the Rayleigh time step that is safe for clumps over that for spheres.

    Several pairs of their spheres touch at once. The dashpots of n of them damp a contact by the
    root of n more than one of the same stiffness would.

    Parameters
    ----------
    material : mapping of str to float
        Values by dotted name; without both restitutions it is 1.
    touching : Touching
        Contact of two clumps.

    Examples
    --------
    >>> bounce = {f"particle_{body}.restitution": 0.3 for body in ("particle", "wall")}
    >>> round(clump_factor(bounce, Touching(1.0, 2.0)), 2)
    0.55
    """
    of_clumps = share_by_restitution(material, _SLIDING_DAMPING, touching)
    return min(1.0, of_clumps / share_by_restitution(material, _SLIDING_DAMPING))


def safe_share(frequency: float, damping_ratio: float) -> float:
    """Return the share of the Rayleigh time step that is safe for a mode of a bed.

    Parameters
    ----------
    frequency : float
        Over that of particles that roll in place and slide on each other.
    damping_ratio : float
        Damping over the critical damping of the mode.
    """
    usual = _SLIDING_DAMPING * damping_factor(_RESTITUTION)
    stable = _stable_step(damping_ratio) / _stable_step(usual)
    return SAFE_SHARE if frequency <= stable else SAFE_SHARE * stable / frequency


def _stable_step(damping_ratio: float) -> float:
    """Return the largest stable step of a damped mode over that of an undamped one."""
    return math.hypot(1, damping_ratio) - damping_ratio


def step_factor(material: Mapping[str, float], radius: float, stress: float | None) -> float:  # noqa: ARG001
    """Return how much larger a safe step is in a bed than in the soft one that was measured.

    The stiffness of a Hertz contact follows (stress / E)^(1/3), the Rayleigh time step does not.
    So the share of it that is stable follows (E / stress)^(1/6). Measured in beds of 250 to 6,800,
    above which it does not grow any more.

    Parameters
    ----------
    material : mapping of str to float
        Values by dotted name.
    radius : float
        Of no effect.
    stress : float or None
        Largest stress of the bed, Pa; None where it is not known.
    """
    if stress is None:
        return 1.0
    number = min(material["particle.youngs_modulus"] / stress, _STIFF_BED)
    return float((number / _SOFT_BED) ** (1 / 6))


def impact_overlap(
    speed: float, reduced_mass: float, moduli: EffectiveModuli, effective_radius: float
) -> float:
    """Return the largest overlap of an elastic impact, m (Johnson 1985, eq. 11.22)."""
    stiffness = moduli.young * math.sqrt(effective_radius)
    return float((15 / 16 * reduced_mass * speed**2 / stiffness) ** (2 / 5))


def impact_time(
    speed: float, reduced_mass: float, moduli: EffectiveModuli, effective_radius: float
) -> float:
    """Return the time of contact of an elastic impact, s (Johnson 1985, eq. 11.24)."""
    overlap = impact_overlap(speed, reduced_mass, moduli, effective_radius)
    return _IMPACT_TIME * overlap / speed
