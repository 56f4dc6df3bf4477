"""Properties of PFC's contact models hertz and rrlinear."""

from __future__ import annotations

import math
from collections.abc import Iterator

from grainfit.cards.other_programs.base import Group, Material, OtherProgram, Setting, shown
from grainfit.contact_models.linear.model import springs

_NO_PUBLIC_FORMULA = (
    "the stiffness of a contact that PFC makes of it is a formula that no public text shows in "
    "words: compare the overlap of two balls under a known force"
)


def _groups(material: Material) -> Iterator[Group]:
    if "particle.density" in material.values:
        density = Setting("density", material.values["particle.density"], "kg/m^3, of the ball")
        yield Group("balls", [density])
    model = "rrlinear" if material.has("linear") else "hertz"
    for wall in (None, *material.walls):
        title = "ball and ball" if wall is None else f"ball and facet of {wall or 'the wall'}"
        settings = _linear(material, wall) if model == "rrlinear" else _hertz(material, wall)
        yield Group(f"contact model {model}: {title}", [*settings])


def _hertz(material: Material, wall: str | None) -> Iterator[Setting]:
    section, values = _section(material, wall)
    modulus, ratio = values["particle.youngs_modulus"], values["particle.poissons_ratio"]
    if wall is None:
        shear = "Pa: E / (2 (1 + nu)) of the particles; "
        yield Setting("hz_shear", modulus / (2 * (1 + ratio)), f"{shear}{_NO_PUBLIC_FORMULA}")
        yield Setting("hz_poiss", ratio, "the same")
    else:
        yield Setting("hz_shear, hz_poiss", None, f"two materials touch, and {_NO_PUBLIC_FORMULA}")
    yield _sliding(section, values)
    yield Setting(
        "dp_nratio, dp_sratio",
        None,
        f"a restitution of {values[f'{section}.restitution']!r} is wanted; hertz has critical "
        "damping ratios whose law with dp_alpha could not be verified. The model hysteretic takes "
        "a restitution",
    )
    if material.rolls:
        friction = values[f"{section}.rolling_friction"]
        why = f"hertz resists no rotation, and a rolling friction of {friction!r} is wanted"
        yield Setting("rolling friction", None, f"{why}; rrlinear has one, with linear springs")
    yield from _cohesion(material)


def _linear(material: Material, wall: str | None) -> Iterator[Setting]:
    section, values = _section(material, wall)
    found = None if material.sizes is None else springs(material.contact(wall))
    kn, ks = (None, None) if found is None else (found.normal, found.tangential)
    note = "N/m, of the contact: the same for the calibrated diameter"
    yield Setting("kn", kn, note)
    yield Setting("ks", ks, note)
    yield _sliding(section, values)
    logarithm = math.log(values[f"{section}.restitution"])
    ratio = -logarithm / math.hypot(logarithm, math.pi)
    yield Setting(
        "dp_nratio",
        None,
        f"critical damping ratio; {ratio!r} if it is that of kn and of m1 m2 / (m1 + m2) and the "
        "contact may pull, which could not be verified",
    )
    if material.rolls:
        friction = values[f"{section}.rolling_friction"]
        yield Setting(
            "rr_fric",
            None,
            "the largest moment is rr_fric times an effective radius times F_n; whether that is "
            "R* = R1 R2 / (R1 + R2) could not be verified in words. If it is, rr_fric is "
            f"{friction!r}",
        )


def _section(material: Material, wall: str | None) -> tuple[str, dict[str, float]]:
    if wall is None:
        return "particle_particle", dict(material.values)
    return "particle_wall", dict(material.on(wall))


def _sliding(section: str, values: dict[str, float]) -> Setting:
    return Setting("fric", values[f"{section}.sliding_friction"], "the same")


def _cohesion(material: Material) -> Iterator[Setting]:
    if material.cohesion:
        why = f"the calibration has {material.cohesion}; hertz has none"
        yield Setting("cohesion", None, f"{why}, and the conventions of jkr could not be verified")


def _line(setting: Setting) -> str:
    if setting.name == "density":
        return f"ball attribute density {shown(setting)}"
    return f"[{setting.name} = {shown(setting)}]"


PFC = OtherProgram(
    name="pfc",
    title="PFC",
    mark=";",
    how=(
        "FISH variables with the names of the properties, each group for its contacts: "
        "contact cmat default model hertz property fric [fric]. Run one group at a time.",
    ),
    sources=(
        "docs.itascacg.com/pfc700/common/contactmodel/hertz/doc/manual/cmhertz.html",
        "docs.itascacg.com/pfc700/common/contactmodel/hertz/doc/manual/def_hertz_property.html",
        "docs.itascacg.com/itasca900/common/contactmodel/rrlinear/doc/manual/cmrrlinear.html",
        "docs.itascacg.com/pfc600/common/contactmodel/rrlinear/doc/manual/def_rrlinear_property.html",
    ),
    groups=_groups,
    line=_line,
)
