"""Particle shape as an option: the name of a family of clumps, or a list of spheres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from grainfit.errors import InputError
from grainfit.materials import messages
from grainfit.materials.particle_shape import FAMILIES, ParticleShape
from grainfit.options.kinds import Choice, Kind, ListOf, Quantity, Schema
from grainfit.options.places import Place
from grainfit.options.tables import Key, Table

_FAMILY = Choice(tuple(FAMILIES))
_NUMBERS = ListOf(Quantity(None), shortest=3)
_SPHERE = Table(
    (
        Key(
            "position",
            _NUMBERS,
            "Centre: three numbers, in the same unit as the radii.",
            required=True,
            example="[0.0, 0.0, 0.0]",
        ),
        Key("radius", Quantity(None, above_zero=True), "Radius.", required=True, example="1.0"),
    )
)
_SPHERES = Table(
    (
        Key(
            "spheres",
            ListOf(_SPHERE, shortest=2),
            "Overlapping spheres, in any unit: the diameter gives the scale.",
            required=True,
            example="[{ position = [0, 0, 0], radius = 1 }, { position = [1, 0, 0], radius = 1 }]",
        ),
    )
)


@dataclass(frozen=True)
class Shapes(Kind):
    """The shape of particles that are clumps of spheres."""

    def read(self, value: Any, place: Place) -> ParticleShape | None:
        """Read the name of a family, or a table of spheres."""
        if not isinstance(value, dict):
            family = _FAMILY.read(value, place)
            return None if family is None else ParticleShape(family)
        entries = _SPHERES.read(value, place).get("spheres")
        if entries is None or any(None in (e.get("position"), e.get("radius")) for e in entries):
            return None
        spheres = []
        for number, entry in enumerate(entries):
            if len(entry["position"]) != 3:
                fault = messages.NO_POSITION.fault("", count=len(entry["position"]))
                place.at("spheres", number, "position").refuse(fault)
                return None
            x, y, z = entry["position"]
            spheres.append((x, y, z, entry["radius"]))
        try:
            return ParticleShape(spheres=tuple(spheres))
        except InputError as error:
            for fault in error.faults:
                place.at("spheres").refuse(fault)
            return None

    def schema(self) -> Schema:
        """Return the JSON Schema of both forms."""
        return {"anyOf": [_FAMILY.schema(), _SPHERES.schema()]}
