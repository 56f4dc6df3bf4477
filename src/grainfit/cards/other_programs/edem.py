"""Settings of EDEM: Hertz-Mindlin (no slip) and its rolling friction models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.cards.other_programs.base import Group, Material, OtherProgram, Setting, plain_line
from grainfit.materials.walls import on_wall

_SHEAR = "E / (2 (1 + nu)), for versions that ask for it in place of Young's modulus"


def _groups(material: Material) -> Iterator[Group]:
    yield Group("bulk material: particles", [*_body(material, "particle", "particle.density")])
    for wall in material.walls:
        body = on_wall("wall.", wall).removesuffix(".")
        density = f"{body}.density"
        yield Group(f"equipment material: {wall or 'wall'}", [*_body(material, body, density)])
    yield Group("interaction: particle and particle", [*_interaction(material, None)])
    for wall in material.walls:
        title = f"interaction: particle and {wall or 'wall'}"
        yield Group(title, [*_interaction(material, wall)])


def _body(material: Material, body: str, density: str) -> Iterator[Setting]:
    modulus, ratio = (material.values[f"{body}.{k}"] for k in ("youngs_modulus", "poissons_ratio"))
    yield Setting("Poisson's ratio", ratio, "the same")
    if density in material.values:
        yield Setting("Solids density", material.values[density], "kg/m^3, of the solid")
    yield Setting("Young's modulus", modulus, "Pa, the same")
    yield Setting("Shear modulus", modulus / (2 * (1 + ratio)), f"Pa: {_SHEAR}")


def _interaction(material: Material, wall: str | None) -> Iterator[Setting]:
    section = "particle_particle" if wall is None else "particle_wall"
    values = material.values if wall is None else material.on(wall)
    if material.has("linear"):
        why = "the calibration has linear springs, and no public text shows those of EDEM"
        yield Setting("Contact model", None, why)
        return
    yield Setting("Contact model", "Hertz-Mindlin (no slip)", "4/3 E* sqrt(R*) delta^(3/2)")
    yield Setting(
        "Coefficient of Restitution",
        values[f"{section}.restitution"],
        "the same; the help cites Tsuji et al. (1992) for the damping, as grainfit does",
    )
    yield Setting(
        "Coefficient of Static Friction",
        values[f"{section}.sliding_friction"],
        "the same: the tangential force is at most mu_s F_n",
    )
    yield from _rolling(material, values[f"{section}.rolling_friction"], wall)
    yield from _cohesion(material, values, section)


def _rolling(material: Material, friction: float, wall: str | None) -> Iterator[Setting]:
    if not material.rolls:
        yield Setting("Coefficient of Rolling Friction", 0.0, "the calibration has none")
        return
    yield Setting(
        "Coefficient of Rolling Friction (Type C)",
        None,
        f"{material.rolls} has a spring of rolling, and of EDEM's models Type C has one. Its page "
        "names rolling stiffness, equivalent rolling radius R_r, mu_r and a damping ratio, but its "
        f"equations are pictures. If R_r is R* and the torque is at most mu_r R* F_n, it is "
        f"{friction!r}.",
    )
    constant = "another model, a constant torque without a spring, with the same largest torque: "
    yield Setting(
        "Coefficient of Rolling Friction (RVD)",
        friction,
        f"{constant}mu_r R* F_n, so mu_r is the same",
    )
    ratio, radius = (0.5, "half of it between equal spheres") if wall is None else (1.0, "it")
    yield Setting(
        "Coefficient of Rolling Friction (Standard)",
        ratio * friction,
        f"{constant}EDEM has mu_r R_i F_n with R_i from the centre to the contact, and R* is "
        f"{radius}: mu_r R*/R_i = {ratio:g} mu_r",
    )


def _cohesion(material: Material, values: Mapping[str, float], section: str) -> Iterator[Setting]:
    if material.cohesion == "jkr":
        energy = values[f"{section}.surface_energy"]
        yield Setting(
            "Surface Energy (Hertz-Mindlin with JKR)",
            None,
            "the page of EDEM contradicts itself: its normal force is that of the calibration with "
            f"gamma = {energy!r} J/m^2, its pull-out force 3/2 pi gamma R* is that of "
            f"{2 * energy!r} J/m^2. Pull two particles apart: 3 pi gamma R* is wanted with the "
            f"first value, R* the reduced radius",
        )
    elif material.cohesion:
        yield Setting(
            "Cohesion",
            None,
            f"the calibration has {material.cohesion}; no public text shows by which area EDEM's "
            "linear cohesion multiplies its energy density, nor a DMT model",
        )


EDEM = OtherProgram(
    name="edem",
    title="EDEM",
    mark="#",
    how=(
        "Type the values into the Creator: bulk material, equipment material, interactions. Of the "
        "rolling friction models choose one, and repeat the bulk test before you rely on it.",
    ),
    sources=(
        "help.altair.com/edem/topics/creator_tree_physics/the_hertz_mindlin_no_slip_model_r.htm",
        "help.altair.com/edem/topics/creator_tree_physics/the_standard_rolling_friction_model_r.htm",
        "help.altair.com/edem/topics/creator_tree_physics/the_rvd_rolling_friction_model_r.htm",
        "help.altair.com/EDEM/Creator/Physics/Rolling_Friction/Type_C_Rolling_Friction.htm",
        "help.altair.com/edem/topics/creator_tree_physics/the_hertz_mindlin_with_jkr_model_r.htm",
    ),
    groups=_groups,
    line=plain_line,
)
