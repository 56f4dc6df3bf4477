"""Species of MercuryDPM, as C++: HertzianViscoelasticMindlinRollingTorsionSpecies.

MercuryDPM (``HertzianViscoelasticInteraction.cc``, ``MindlinInteraction.cc``) has the normal force
``4/3 E* sqrt(R* delta) delta + gamma sqrt(m* k) v`` with ``k = 4/3 E* sqrt(R* delta)`` and
``gamma = sqrt(5) beta`` of the restitution: that of the calibration. Its tangential force is
``2/3 k_t0 xi + c sqrt(m* k_t0) v`` with ``k_t0 = 8 G sqrt(R* delta)``, and its rolling torque is
``k_t0 R*^2 theta``, at most ``mu_r R* F_n``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from grainfit.cards.other_programs.base import Group, Material, OtherProgram, Setting, shown
from grainfit.contact_models.hertz_mindlin.model import damping_factor, particle_moduli

_SPECIES = "HertzianViscoelasticMindlinRollingTorsionSpecies"
_NEW = f"speciesHandler.copyAndAddObject({_SPECIES}())"


def _groups(material: Material) -> Iterator[Group]:
    yield Group("species of the particles", [*_particles(material)])
    for wall in material.walls:
        yield Group(
            f"species of {wall or 'the wall'}, and contacts with it", [*_wall(material, wall)]
        )


def _particles(material: Material) -> Iterator[Setting]:
    yield Setting("", f"auto particle = {_NEW};", "for particles: setSpecies(particle)")
    density = material.values["particle.density"]
    yield Setting("particle->setDensity", density, "kg/m^3, of the solid")
    yield from _contact(material, "particle->", None)


def _wall(material: Material, wall: str) -> Iterator[Setting]:
    name = f"wall_{wall}" if wall else "wall"
    yield Setting("", f"auto {name} = {_NEW};", "for walls: setSpecies")
    yield Setting(
        "",
        f"auto particle_{name} = speciesHandler.getMixedObject(particle, {name});",
        "MercuryDPM averages two species unless their mixed one is set: all of it is set here",
    )
    yield from _contact(material, f"particle_{name}->", wall)


def _contact(material: Material, owner: str, wall: str | None) -> Iterator[Setting]:
    section = "particle_particle" if wall is None else "particle_wall"
    values = material.values if wall is None else material.on(wall)
    if material.has("linear"):
        why = "the calibration has linear springs, which these species do not have"
        yield Setting(f"{owner}setEffectiveElasticModulus", None, why)
        return
    restitution = values[f"{section}.restitution"]
    moduli = particle_moduli(values, "particle" if wall is None else "wall")
    yield Setting(
        f"{owner}setEffectiveElasticModulusAndRestitutionCoefficient",
        f"{moduli.young!r}, {restitution!r}",
        "E* of the contact, Pa, not E; the restitution is the same, with the same damping",
    )
    yield Setting(
        f"{owner}setEffectiveShearModulus",
        1.5 * moduli.shear,
        "3/2 of G* of the contact, Pa: MercuryDPM takes two thirds of 8 G* a as the tangential "
        "spring. Its setPoissonRatio has another formula than G* of two bodies: do not use it",
    )
    yield Setting(
        f"{owner}setSlidingDissipation",
        2 * math.sqrt(5) / 3 * damping_factor(restitution),
        "2 sqrt(5)/3 beta, so that c sqrt(m* 12 G* a) is 2 sqrt(5/6) beta sqrt(8 G* a m*)",
    )
    yield Setting(
        f"{owner}setSlidingFrictionCoefficient",
        values[f"{section}.sliding_friction"],
        "the same at rest and sliding; it limits the spring",
    )
    yield from _rolling(material, owner, values[f"{section}.rolling_friction"])
    if material.cohesion:
        yield Setting(
            f"{owner}adhesion",
            None,
            f"the calibration has {material.cohesion}, which these species do not have",
        )


def _rolling(material: Material, owner: str, friction: float) -> Iterator[Setting]:
    spring = {
        "epsd": "its spring is k_t0 R*^2 (here 12 G* a R*^2), that of the calibration "
        "2.25 k_n (mu_r R*)^2: the same once the limit is reached",
        "epsd2": "its spring is k_t0 R*^2, here 3/2 of that of the calibration: the same once the "
        "limit is reached",
    }
    if not material.rolls:
        yield Setting(f"{owner}setRollingFrictionCoefficient", 0.0, "the calibration has none")
        return
    note = f"the same: its torque is at most mu_r R* F_n, too. But {spring[material.rolls]}"
    yield Setting(f"{owner}setRollingFrictionCoefficient", friction, note)


def _line(setting: Setting) -> str:
    if not setting.name:
        return shown(setting)
    return f"{setting.name}({shown(setting)});"


MERCURYDPM = OtherProgram(
    name="mercurydpm",
    title="MercuryDPM",
    mark="//",
    how=("Paste it into setupInitialConditions() of a driver. SI units throughout.",),
    sources=(
        "source of MercuryDPM, state of July 2024 (fb0ebf1): HertzianViscoelasticInteraction.cc, "
        "HertzianViscoelasticNormalSpecies.cc, MindlinInteraction.cc, MindlinSpecies.cc, "
        "MindlinRollingTorsionInteraction.cc, BaseInteraction.cc",
    ),
    groups=_groups,
    line=_line,
)
