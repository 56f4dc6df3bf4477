"""Friction of a part that is rougher or smoother than the walls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Quantity, Schema
from grainfit.options.places import Place

#: Value of an option: the friction between particles, as on a plate that they are glued to.
AS_PARTICLES = "particle_particle"


@dataclass(frozen=True)
class PartFriction(Quantity):
    """A friction coefficient, or that between two particles."""

    unit: str | None = ""
    lowest: float = 0.0
    highest: float = 10.0

    def read(self, value: Any, place: Place) -> Any:
        """Read a number, or the name of the section with the friction between particles."""
        return value if value == AS_PARTICLES else super().read(value, place)

    def limits(self) -> str:
        """Return the possible values in words."""
        return f'{super().limits()}, or "{AS_PARTICLES}"'

    def schema(self) -> Schema:
        """Return the JSON Schema of a number, a number in quotes, or the name of the section."""
        accepted: Schema = super().schema()
        return {"anyOf": [*accepted["anyOf"], {"const": AS_PARTICLES}]}


def friction_option(kind: str, part: str, what: str, example: str, **remarks: Any) -> Any:
    """Return the option of the friction of a part, by default that of the walls.

    Parameters
    ----------
    kind : {"Sliding", "Rolling"}
        Kind of friction.
    part : str
        The part.
    what : str
        The part for readers, and what they should know about it, as the end of a sentence.
    example : str
        A good value, as TOML.
    **remarks : str
        As of `grainfit.options.fields.option`.
    """
    return option(
        PartFriction(),
        f"{kind} friction between particles and {what}",
        example=example,
        default=Derived("that of the walls"),
        part=part,
        **remarks,
    )


def friction_of_part(
    material: Mapping[str, float], sliding: Amount | None, rolling: Amount | None
) -> dict[str, float]:
    """Return the friction of a part where it differs from that of the walls.

    Parameters
    ----------
    material : mapping of str to float
        Material parameters by dotted name.
    sliding, rolling : float, str or None
        Options of the part; None for the friction of the walls.
    """
    given = {"sliding_friction": sliding, "rolling_friction": rolling}
    return {
        f"particle_wall.{name}": (
            material[f"particle_particle.{name}"] if value == AS_PARTICLES else float(value)
        )
        for name, value in given.items()
        if value is not None
    }
