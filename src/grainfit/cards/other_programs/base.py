"""Cards for programs that grainfit does not run: values, each with its conversion beside it.

A program is an `OtherProgram`: what one must know of it, the public sources of its conventions, and
a function that gives its settings for a material. A setting without a value is one whose convention
no public source shows, or that has no counterpart; the card says which.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from grainfit.cards import messages
from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.registry import contact_law, parameters_of_walls, with_defaults
from grainfit.errors import InputError
from grainfit.formatting import in_a_row
from grainfit.materials.card import MaterialCard
from grainfit.materials.card_text import about, comment, header
from grainfit.materials.sizes import ParticleSizes
from grainfit.materials.walls import material_on, plain_name
from grainfit.solvers.dem.card_parts import simulated_card, walls_of_card
from grainfit.solvers.dem.sphere_types import SphereTypes

_WIDTH = 94
_BODIES = {
    f"{body}.{key}"
    for body, keys in (
        ("particle", ("youngs_modulus", "poissons_ratio", "density")),
        ("wall", ("youngs_modulus", "poissons_ratio")),
    )
    for key in keys
}


@dataclass(frozen=True)
class Setting:
    """A setting of another program.

    Parameters
    ----------
    name : str
        As the program calls it.
    value : float or str or None
        In SI units, a text as it stands, or None: it is not written.
    note : str
        Conversion, or why it is not written.
    """

    name: str
    value: float | str | None
    note: str


@dataclass(frozen=True)
class Group:
    """Settings that belong together.

    Parameters
    ----------
    title : str
        In words.
    settings : sequence of Setting
        In the order of the card.
    """

    title: str
    settings: Sequence[Setting]


@dataclass(frozen=True)
class Material:
    """The simulated material of a card, for the settings of a program.

    Parameters
    ----------
    values : mapping of str to float
        All parameters by dotted name, SI, defaults included.
    law : ContactLaw
        Contact law of the calibration.
    walls : tuple of str
        Names of the walls; empty for the plain one.
    sizes : ParticleSizes or None
        Of the simulated particles.
    gravity : float
        m/s^2.
    """

    values: Mapping[str, float]
    law: ContactLaw
    walls: tuple[str, ...]
    sizes: ParticleSizes | None
    gravity: float

    def has(self, model: str) -> bool:
        """Return whether a contact model is part of the law."""
        return any(one.name == model for one in self.law.models)

    @property
    def rolls(self) -> str:
        """Name of the model of rolling; empty without one, or without rolling friction."""
        named = [one.name for one in self.law.models if one.kind == "rolling"]
        frictions = [v for n, v in self.values.items() if plain_name(n) in _ROLLING]
        return named[0] if named and any(frictions) else ""

    @property
    def cohesion(self) -> str:
        """Name of the model of cohesion; empty without one."""
        return "" if self.law.cohesion is None else self.law.cohesion.name

    @cached_property
    def diameter(self) -> float | None:
        """Sauter diameter, m, as far as it is known."""
        return None if self.sizes is None else self.sizes.sauter_diameter

    def on(self, wall: str) -> Mapping[str, float]:
        """Return the values with those of a wall in place of the plain ones."""
        return material_on(self.values, wall)

    def contact(self, wall: str | None = None) -> Contact:
        """Return the contact of two particles of mean size, or of one on a wall."""
        assert self.sizes is not None
        types = SphereTypes.mean_of(self.sizes)
        if wall is None:
            return types.between(self.values, 1, 1, self.gravity)
        return types.on_wall(self.on(wall), 1, self.gravity)


_ROLLING = {"particle_particle.rolling_friction", "particle_wall.rolling_friction"}


@dataclass(frozen=True)
class OtherProgram:
    """A program that grainfit writes a card for without running it.

    Parameters
    ----------
    name, title : str
        As in ``--to``, and for people.
    mark : str
        What a comment begins with.
    how : sequence of str
        Sentences on how to use the card.
    sources : sequence of str
        Public sources of the conventions.
    groups : callable
        Yields the settings of a material.
    line : callable
        Returns a setting that has a value in the syntax of the program.
    before, after : str
        Lines around the settings.
    """

    name: str
    title: str
    mark: str
    how: Sequence[str]
    sources: Sequence[str]
    groups: Callable[[Material], Iterator[Group]]
    line: Callable[[Setting], str]
    before: str = ""
    after: str = ""


def plain_line(setting: Setting) -> str:
    """Return a setting as ``name = value``, for programs whose values are typed in by hand."""
    return f"{setting.name} = {shown(setting)}"


def shown(setting: Setting) -> str:
    """Return the value of a setting, a number with all its digits."""
    return setting.value if isinstance(setting.value, str) else repr(setting.value)


def render_other(program: OtherProgram) -> Callable[[MaterialCard], str]:
    """Return the function that writes the card of a program.

    The function raises an InputError where a parameter is missing that every such card needs.
    """

    def render(card: MaterialCard) -> str:
        simulated = simulated_card(card)
        material = _material(simulated, program)
        lines = [*_head(simulated, program, material), *([program.before] * bool(program.before))]
        for group in [*program.groups(material), *_left_out(material, program)]:
            lines += ["", *_comments(program, f"--- {group.title} ---")]
            for setting in group.settings:
                lines += _setting(program, setting)
        return "\n".join([*lines, *([program.after] * bool(program.after))]) + "\n"

    return render


def _left_out(material: Material, program: OtherProgram) -> Iterator[Group]:
    """Yield what no card of another program has: dashpots of rolling, and clumps."""
    found = []
    damping = [v for n, v in material.values.items() if n.endswith(".rolling_damping")]
    if material.rolls == "epsd" and any(damping):
        found.append(Setting("rolling damping", None, messages.NO_DASHPOT(title=program.title)))
    if material.sizes is not None and material.sizes.clump is not None:
        found.append(Setting("shape", None, messages.NO_CLUMPS()))
    if found:
        yield Group("left out", found)


def _material(card: MaterialCard, program: OtherProgram) -> Material:
    values = with_defaults(card.values)
    law = contact_law(values, card.contact_models)
    walls = walls_of_card(card)
    named = {p.name for model in law.models for p in model.parameters} | _BODIES
    needed = [name for name in parameters_of_walls(walls) if plain_name(name) in named]
    if missing := [name for name in needed if name not in values]:
        lacking = ", ".join(missing)
        raise InputError(messages.OTHER_NEEDS.fault("", program=program.title, missing=lacking))
    return Material(values, law, walls, card.sizes, card.gravity)


def _head(card: MaterialCard, program: OtherProgram, material: Material) -> Iterator[str]:
    yield from (_marked(program, line) for line in header(card).splitlines())
    words = [
        "",
        f"For {program.title}. {messages.NOT_RUN(program=program.title)}",
        *program.how,
        "",
        f"Contact law of the calibration: {in_a_row([m.name for m in material.law.models])}",
        *(f"  {equation.words}" for equation in material.law.equations()),
        *(f"  {c.symbol} ({c.key}): {c.meaning}" for c in material.law.conventions),
        "",
        "Sources of the conventions:",
        *(f"  {source}" for source in program.sources),
        "",
        "Values of the calibration, SI units:",
    ]
    yield from (line for text in words for line in _comments(program, text))
    for parameter in card.parameters:
        line = f"{comment(parameter.name)} = {parameter.value!r}  {about(parameter)[2:]}"
        yield _marked(program, line)
    if card.recommended_time_step is not None:
        remark = "s, of the calibration; the program may have a rule of its own"
        yield _marked(
            program, f"# recommended time step = {card.recommended_time_step!r}  {remark}"
        )


def _setting(program: OtherProgram, setting: Setting) -> Iterator[str]:
    if setting.value is None:
        yield from _comments(program, f"NOT WRITTEN: {setting.name}: {setting.note}")
        return
    yield from _comments(program, setting.note)
    yield program.line(setting)


def _comments(program: OtherProgram, text: str) -> list[str]:
    inset = " " * (len(text) - len(text.lstrip()) + 2)
    lines = textwrap.wrap(text, _WIDTH, subsequent_indent=inset) or [""]
    return [_marked(program, comment(line)) for line in lines]


def _marked(program: OtherProgram, line: str) -> str:
    """Return a comment that begins with ``#`` with the mark of a program instead."""
    # A backslash at the end would make the next line part of a comment in C++.
    safe = f"{line} ." if line.endswith("\\") else line
    return f"{program.mark}{safe.removeprefix('#')}".rstrip()
