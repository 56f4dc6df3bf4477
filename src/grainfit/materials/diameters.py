"""Particle diameters as an option: one, or a distribution by mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from grainfit.materials.sizes import ParticleSizes
from grainfit.options.kinds import Kind, ListOf, Quantity, Schema, note_wrong_kind
from grainfit.options.places import Place
from grainfit.options.tables import Key, Table


@dataclass(frozen=True)
class Diameters(Kind):
    """The particle diameter, or a discrete distribution of diameters."""

    def read(self, value: Any, place: Place) -> ParticleSizes | None:
        """Read one diameter or a list of diameters with mass fractions."""
        if isinstance(value, list):
            return self._distribution(value, place)
        if isinstance(value, dict):
            note_wrong_kind(
                value,
                place,
                "a length, or a list",
                'Write diameter = "10 mm", or a list: '
                '[{ value = "8 mm", mass_fraction = 0.3 }, { value = ..., mass_fraction = ... }].',
            )
            return None
        diameter = _DIAMETER.read(value, place)
        return None if diameter is None else ParticleSizes((diameter,))

    @staticmethod
    def _distribution(value: list[Any], place: Place) -> ParticleSizes | None:
        classes = _SIZE_CLASSES.read(value, place)
        if classes is None or any(
            None in (c.get("value"), c.get("mass_fraction")) for c in classes
        ):
            return None
        diameters = tuple(c["value"] for c in classes)
        fractions = tuple(c["mass_fraction"] for c in classes)
        if len(set(diameters)) < len(diameters):
            place.fault("has the same diameter twice.", "Add up their mass fractions.")
        elif abs(sum(fractions) - 1) > 1e-6:
            place.fault(
                f"mass fractions sum to {sum(fractions):.6g}.", "They must sum to 1 (or 100 %)."
            )
        else:
            return ParticleSizes(diameters, fractions)
        return None

    def schema(self) -> Schema:
        """Return the JSON Schema of both forms."""
        return {"anyOf": [*_DIAMETER.schema()["anyOf"], _SIZE_CLASSES.schema()]}


_DIAMETER = Quantity("m", lowest=1e-7, highest=1.0)
_SIZE_CLASSES = ListOf(
    Table(
        (
            Key("value", _DIAMETER, "Diameter of this class.", required=True, example='"8 mm"'),
            Key(
                "mass_fraction",
                Quantity("", highest=1.0, above_zero=True),
                "Share of the mass in this class, as a sieve gives it; all sum to 1.",
                required=True,
                example="0.3",
            ),
        )
    )
)
