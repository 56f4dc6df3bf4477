"""Commands of Aspherix: material properties and contact models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.cards.other_programs.base import Group, Material, OtherProgram, Setting, shown

_SAME = (
    "the keywords are those of LIGGGHTS; the damping of Aspherix is no formula in words in public: "
    "drop a particle and see"
)


def _groups(material: Material) -> Iterator[Group]:
    names = ["particle", *map(_name, material.walls)]
    yield Group("materials", [Setting("materials", f"{{{', '.join(names)}}}", "their names")])
    if material.has("linear"):
        why = "the calibration has linear springs, whose conventions could not be verified"
        yield Group("contact model", [Setting("particle_contact_model", None, why)])
        return
    yield Group("particles", [*_own(material)])
    for wall in material.walls:
        yield Group(f"wall {wall}".rstrip(), [*_wall(material, wall)])
    yield Group("contact model", [*_model(material)])


def _name(wall: str) -> str:
    return f"wall_{wall}" if wall else "wall"


def _own(material: Material) -> Iterator[Setting]:
    values = material.values
    words = f"density {values['particle.density']!r} {_elastic(values, 'particle')} "
    words += _pair(material, "particle_particle", None)
    yield Setting("material_properties particle", words, _note(material))


def _wall(material: Material, wall: str) -> Iterator[Setting]:
    values = material.on(wall)
    name = _name(wall)
    yield Setting(f"material_properties {name}", _elastic(values, "wall"), "Pa, the same")
    yield Setting(
        f"material_interaction_properties particle {name}",
        _pair(material, "particle_wall", wall),
        _note(material),
    )


def _elastic(values: Mapping[str, float], body: str) -> str:
    modulus, ratio = values[f"{body}.youngs_modulus"], values[f"{body}.poissons_ratio"]
    return f"youngsModulus {modulus!r} poissonsRatio {ratio!r}"


def _pair(material: Material, section: str, wall: str | None) -> str:
    values = material.values if wall is None else material.on(wall)
    words = (
        f"coefficientRestitution {values[f'{section}.restitution']!r} "
        f"coefficientFriction {values[f'{section}.sliding_friction']!r}"
    )
    if material.rolls:
        words += f" coefficientRollingFriction {values[f'{section}.rolling_friction']!r}"
    return words


def _note(material: Material) -> str:
    rolling = " Rolling friction: the same, a multiple of the effective radius R*."
    return f"SI units; {_SAME}.{rolling if material.rolls else ''}"


def _model(material: Material) -> Iterator[Setting]:
    rolling = f" rolling_friction {material.rolls}" if material.rolls else ""
    note = "4/3 E* a delta, with a tangential spring that has a history"
    if material.rolls == "epsd":
        note += (
            ". epsd wants a damping of rolling as well, whose keyword could not be verified "
            "(LIGGGHTS: coefficientRollingViscousDamping); the calibration has "
            f"{material.values['particle_particle.rolling_damping']!r}"
        )
    for command in ("particle_contact_model", "wall_contact_model"):
        yield Setting(command, f"normal hertz tangential history{rolling}", note)
    if material.cohesion:
        yield Setting(
            "cohesion",
            None,
            f"the calibration has {material.cohesion}; that Aspherix multiplies its energy density "
            "by the same area could not be verified",
        )


def _line(setting: Setting) -> str:
    return f"{setting.name} {shown(setting)}"


ASPHERIX = OtherProgram(
    name="aspherix",
    title="Aspherix",
    mark="#",
    how=("Include it in an input script, before particles are made.",),
    sources=(
        "doc.aspherix-dem.com/material_properties.html, /material_interaction_properties.html, "
        "/materials.html",
        "doc.aspherix-dem.com/particle_contact_model.html",
        "doc.aspherix-dem.com/gran_rolling_friction_cdt.html, /gran_rolling_friction_epsd2.html",
    ),
    groups=_groups,
    line=_line,
)
