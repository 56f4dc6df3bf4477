"""Settings of Rocky: what its public technical manual shows."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.cards.other_programs.base import Group, Material, OtherProgram, Setting, plain_line
from grainfit.materials.walls import on_wall


def _groups(material: Material) -> Iterator[Group]:
    for body in ("particle", *(on_wall("wall.", w).removesuffix(".") for w in material.walls)):
        yield Group(f"material: {body}", [*_body(material, body)])
    yield Group("materials interaction: particle and particle", [*_pair(material, None)])
    for wall in material.walls:
        yield Group(
            f"materials interaction: particle and {wall or 'wall'}", [*_pair(material, wall)]
        )
    yield Group("particle: movement", [*_rolling(material)])


def _body(material: Material, body: str) -> Iterator[Setting]:
    if f"{body}.density" in material.values:
        density = material.values[f"{body}.density"]
        yield Setting("Density", density, "kg/m^3, of the solid, not of the bulk")
    yield Setting("Young's Modulus", material.values[f"{body}.youngs_modulus"], "Pa, the same")
    yield Setting("Poisson's Ratio", material.values[f"{body}.poissons_ratio"], "the same")


def _pair(material: Material, wall: str | None) -> Iterator[Setting]:
    section = "particle_particle" if wall is None else "particle_wall"
    values = material.values if wall is None else material.on(wall)
    friction = values[f"{section}.sliding_friction"]
    yield Setting("Static Friction", friction, "the same at rest and sliding")
    yield Setting("Dynamic Friction", friction, "the same at rest and sliding")
    yield Setting(
        "Restitution Coefficient",
        values[f"{section}.restitution"],
        "the same; the damping formula of Rocky's Hertzian spring-dashpot could not be verified in "
        "a public text: drop a particle and see",
    )
    if material.cohesion:
        yield Setting(
            "Adhesion",
            None,
            f"the calibration has {material.cohesion}; the conversion to Rocky's adhesion "
            "could not be verified in a public text",
        )


def _rolling(material: Material) -> Iterator[Setting]:
    friction = material.values["particle_particle.rolling_friction"]
    if not material.rolls:
        yield Setting("Rolling Resistance", 0.0, "the calibration has none")
        return
    yield Setting(
        "Rolling Resistance (Type C: linear spring rolling limit)",
        None,
        f"{material.rolls} has a spring of rolling, as Type C has. Its limit and its radius are "
        "formulas that no public text shows in words: if the moment is at most mu_r R* F_n, it is "
        f"{friction!r}",
    )
    yield Setting(
        "Rolling Resistance (Type A: constant moment)",
        friction / 2,
        "another model, a constant moment without a spring, with the same largest moment between "
        "equal spheres: Rocky has mu_r F_n R with R from the centroid to the contact, and R* is "
        "half of it: mu_r / 2. It is a property of the particle: contacts on walls have it, too",
    )


ROCKY = OtherProgram(
    name="rocky",
    title="Rocky",
    mark="#",
    how=(
        "Type the values in: materials, materials interactions, particles. The nearest models are "
        "Hertzian spring-dashpot and Mindlin-Deresiewicz; whether their stiffness and damping are "
        "those of the calibration could not be verified. Repeat the bulk test.",
    ),
    sources=(
        "ansyshelp.ansys.com/public/Views/Secured/corp/v242/en/dem_tec/rol.html (rolling)",
        "ansyshelp.ansys.com/public/Views/Secured/corp/v242/en/dem_tec/cfm.html (contacts)",
    ),
    groups=_groups,
    line=plain_line,
)
