"""Keywords of MFiX-DEM, for the file ``mfix.dat``: the collision model HERTZIAN.

MFiX (``check_solids_dem.f``, ``calc_force_dem.f``) has the springs of the calibration,
``4/3 E* a`` and ``8 G* a``. Its dashpots are ``f |ln e| / sqrt(ln^2 e + pi^2) sqrt(k m)`` with
``m*`` in the normal direction and ``2/7 m*`` in the tangential one, where f is sqrt(5) in version
25.2.1 and 2 in 21.3.2. Its rolling friction is a constant torque on the rotation of each particle:
``MEW_R d k_n delta`` in 25.2.1, ``MEW_R k_n delta`` in 21.3.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from grainfit.cards.other_programs.base import Group, Material, OtherProgram, Setting, shown
from grainfit.contact_models.hertz_mindlin.model import damping_factor

#: Damping factor of the tangential restitution over that of the calibration; that of the normal
#: one is 1, or sqrt(5)/2 in version 21.3.2.
_TANGENTIAL, _OLD_TANGENTIAL, _OLD_NORMAL = math.sqrt(7 / 3), math.sqrt(35 / 12), math.sqrt(5) / 2


def restitution_of(factor: float) -> float | None:
    """Return the restitution of a damping factor; None where there is none, from 1 on.

    Examples
    --------
    >>> restitution_of(damping_factor(0.5))
    0.5
    """
    if factor >= 1:
        return None
    return round(math.exp(-math.pi * factor / math.sqrt(1 - factor**2)), 15)


def _groups(material: Material) -> Iterator[Group]:
    if material.has("linear"):
        why = "the calibration has linear springs; this card is for the model HERTZIAN"
        yield Group("collision model", [Setting("DES_COLL_MODEL", None, why)])
        return
    yield Group("collision model", [Setting("DES_COLL_MODEL", "'HERTZIAN'", "4/3 E* a, 8 G* a")])
    yield Group("solids phase 1", [*_particles(material)])
    yield Group("contacts of particles", [*_contact(material, None)])
    wall, *others = material.walls
    yield Group(f"contacts with {wall or 'walls'}", [*_walls(material, wall)])
    for other in others:
        why = "MFiX has one material for all walls"
        yield Group(f"contacts with {other}", [Setting("MEW_W", None, why)])


def _particles(material: Material) -> Iterator[Setting]:
    if material.diameter is not None:
        yield Setting("D_p0(1)", material.diameter, "m, Sauter diameter")
    yield Setting("RO_s0(1)", material.values["particle.density"], "kg/m^3, of the solid")
    yield Setting("E_YOUNG(1)", material.values["particle.youngs_modulus"], "Pa, the same")
    yield Setting("V_POISSON(1)", material.values["particle.poissons_ratio"], "the same")


def _walls(material: Material, wall: str) -> Iterator[Setting]:
    values = material.on(wall)
    yield Setting("EW_YOUNG", values["wall.youngs_modulus"], "Pa, the same")
    yield Setting("VW_POISSON", values["wall.poissons_ratio"], "the same")
    yield from _contact(material, wall)


def _contact(material: Material, wall: str | None) -> Iterator[Setting]:
    section = "particle_particle" if wall is None else "particle_wall"
    middle, end = ("", "") if wall is None else ("_WALL", "W")
    values = material.values if wall is None else material.on(wall)
    restitution = values[f"{section}.restitution"]
    factor = damping_factor(restitution)
    yield Setting(
        f"DES_EN{middle}_INPUT(1)",
        restitution,
        "the same in version 25.2.1, whose dashpot has sqrt(5); that of 21.3.2 has 2 in its place "
        f"and wants {_words(restitution_of(_OLD_NORMAL * factor))}",
    )
    yield Setting(
        f"DES_ET{middle}_INPUT(1)",
        restitution_of(_TANGENTIAL * factor),
        "tangential dashpot of the calibration: sqrt(7/3) beta instead of beta, as MFiX has 2/7 of "
        f"the mass in it; version 21.3.2 wants {_words(restitution_of(_OLD_TANGENTIAL * factor))}",
    )
    sliding = "MEW" if wall is None else "MEW_W"
    note = "the same; it limits spring and dashpot together"
    yield Setting(sliding, values[f"{section}.sliding_friction"], note)
    yield _rolling(material, f"MEW_R{end}", values[f"{section}.rolling_friction"], wall)
    if material.cohesion:
        why = f"the calibration has {material.cohesion}, whose counterpart could not be verified"
        yield Setting("cohesion", None, why)


def _rolling(material: Material, name: str, friction: float, wall: str | None) -> Setting:
    if not material.rolls:
        return Setting(name, 0.0, "the calibration has none")
    share = 1 / 4 if wall is None else 1 / 2
    old = "unknown, as the diameter is"
    if material.diameter is not None:
        old = f"{share * friction * material.diameter!r} (m)"
    spheres = "between equal spheres R* = d/4" if wall is None else "on a wall R* = d/2"
    return Setting(
        name,
        share * friction,
        f"another model, a constant torque without a spring, with the same largest torque mu_r R* "
        f"F_n: version 25.2.1 has MEW_R d F_n, and {spheres}. Version 21.3.2 has MEW_R F_n, and "
        f"wants {old}",
    )


def _words(restitution: float | None) -> str:
    if restitution is None:
        return "more damping than any restitution there has"
    return repr(restitution)


def _line(setting: Setting) -> str:
    return f"  {setting.name} = {shown(setting)}"


MFIX = OtherProgram(
    name="mfix",
    title="MFiX",
    mark="!",
    how=("Keywords for mfix.dat, SI units, MFiX 25.2.1; other versions have other conventions.",),
    sources=(
        "source of MFiX 25.2.1 and 21.3.2: model/check_data/check_solids_dem.f, "
        "model/des/calc_force_dem.f, model/des/des_init_namelist.f",
    ),
    groups=_groups,
    line=_line,
)
