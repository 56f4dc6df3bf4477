"""Hertz-Mindlin contact with rolling friction: one definition, in the coefficients of each solver.

The reference is what LIGGGHTS computes from the 14 material parameters (``gran model hertz
tangential history rolling_friction epsd``); the functions here turn the same parameters into the
coefficients that LAMMPS (``pair_style granular``) wants.

References
----------
Johnson (1985), Contact Mechanics, chapters 4.2 and 7.2: Hertz and Mindlin stiffness.
Tsuji, Tanaka & Ishida (1992), Powder Technology 71:239-250; Antypov & Elliott (2011), EPL 94:50004:
damping of a Hertz contact from the coefficient of restitution.
Ai, Chen, Rotter & Ooi (2011), Powder Technology 206:269-282, model C: rolling friction (EPSD).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

#: EPSD takes the rolling stiffness from that of the normal contact: k_r = 2.25 k_n (mu_r R*)^2.
_EPSD_STIFFNESS = 2.25
#: Normal force, in particle weights, at which the constant rolling stiffness of LAMMPS is taken.
TYPICAL_LOAD = 5.0
#: Moment of inertia about the point of contact over mass times squared radius.
_ROLLING_INERTIA = 7 / 5


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


@dataclass(frozen=True)
class RollingSpring:
    """Coefficients of LAMMPS' ``rolling sds``, which acts as a force at the effective radius.

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
    weight: float,
    rolling_inertia: float,
    rolling_friction: float,
    rolling_damping: float,
) -> RollingSpring:
    """Return the spring and dashpot of ``rolling sds`` that stand for EPSD.

    EPSD: spring ``k_r = 2.25 k_n (mu_r R*)^2`` (N m), dashpot ``2 eta_r sqrt(I_r k_r)`` (N m s).
    The force of ``rolling sds`` acts on the rolling displacement R* theta and its torque has the
    lever R*, hence both are divided by R*^2. EPSD's k_n = F_n / overlap grows with the load while
    the coefficient here is a constant: it is taken at a typical load of five particle weights.

    Parameters
    ----------
    moduli : EffectiveModuli
        Of the contact.
    effective_radius : float
        R*, m: r_i r_j / (r_i + r_j) of two spheres, r of a sphere on a wall.
    weight : float
        Of a particle, N.
    rolling_inertia : float
        I_r, kg m^2: 1.4 m r^2 of a sphere on a wall, the reduced one of two spheres.
    rolling_friction, rolling_damping : float
        mu_r and eta_r of EPSD.
    """
    overlap = hertz_overlap(TYPICAL_LOAD * weight, moduli, effective_radius)
    normal_stiffness = hertz_stiffness(overlap, moduli, effective_radius)
    stiffness = _EPSD_STIFFNESS * normal_stiffness * rolling_friction**2
    damping = 2 * rolling_damping * math.sqrt(rolling_inertia * stiffness) / effective_radius
    return RollingSpring(stiffness, damping)


def lammps_coefficients(material: Mapping[str, float], body: str) -> dict[str, float]:
    """Return what ``hertz/material`` and ``mindlin`` take for a particle against a body.

    Parameters
    ----------
    material : mapping of str to float
        The material parameters by dotted name.
    body : str
        ``"particle"`` or ``"wall"``.
    """
    moduli = particle_moduli(material, body)
    return {
        # LAMMPS works out E* of two particles of this material, against a wall too.
        "modulus": 2 * (1 - material["particle.poissons_ratio"] ** 2) * moduli.young,
        "restitution": material[f"particle_{body}.restitution"],
        "tangential_stiffness": tangential_stiffness(moduli),
        "tangential_damping": tangential_damping_ratio(moduli),
    }


def rolling_between_particles(
    material: Mapping[str, float], radius: float, other: float, gravity: float
) -> RollingSpring:
    """Return the rolling spring of two particles, see `rolling_spring`."""
    masses = particle_mass(material, radius), particle_mass(material, other)
    inertias = [
        _ROLLING_INERTIA * mass * r**2 for mass, r in zip(masses, (radius, other), strict=True)
    ]
    return rolling_spring(
        particle_moduli(material, "particle"),
        _reduced(radius, other),
        2 * _reduced(*masses) * gravity,
        _reduced(*inertias),
        material["particle_particle.rolling_friction"],
        material["particle_particle.rolling_damping"],
    )


def rolling_on_wall(
    material: Mapping[str, float], radius: float, gravity: float, rolling_friction: float
) -> RollingSpring:
    """Return the rolling spring of a particle on a wall of this friction, see `rolling_spring`."""
    mass = particle_mass(material, radius)
    return rolling_spring(
        particle_moduli(material, "wall"),
        radius,
        mass * gravity,
        _ROLLING_INERTIA * mass * radius**2,
        rolling_friction,
        material["particle_wall.rolling_damping"],
    )


def particle_mass(material: Mapping[str, float], radius: float) -> float:
    """Return the mass of a sphere of the particles' density, kg."""
    return material["particle.density"] * 4 / 3 * math.pi * radius**3


def _reduced(one: float, other: float) -> float:
    return one * other / (one + other)
