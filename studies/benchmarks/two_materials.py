"""Programs for beds of two materials, one for each diameter, which grainfit does not offer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from grainfit.contact_models.contact import TYPICAL_LOAD, Contact
from grainfit.contact_models.liggghts import LiggghtsProperties
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.lammps.scene_deck import LammpsSceneDeck
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.dem.liggghts.scene_deck import LiggghtsSceneDeck
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.dem.script_syntax import command
from grainfit.solvers.dem.sphere_types import SphereTypes


@dataclass(frozen=True)
class SecondMaterial:
    """Spheres of the second diameter: their material, and their contacts with the others.

    Parameters
    ----------
    material : mapping of str to float
        Their material by dotted name, with their contacts with each other and with walls.
    with_first : mapping of str to float
        ``particle_particle`` parameters of a contact with a sphere of the first diameter.
    """

    material: Mapping[str, float]
    with_first: Mapping[str, float]

    def between(self, first: Mapping[str, float]) -> dict[str, float]:
        """Return a material whose contacts are those of the two, of equal Poisson's ratios."""
        key = "particle.youngs_modulus"
        one, other = first[key], self.material[key]
        return {**first, **self.with_first, key: 2 * one * other / (one + other)}


@dataclass(frozen=True)
class _Types(SphereTypes):
    """Two types of spheres, of two materials."""

    second: SecondMaterial = SecondMaterial({}, {})

    def between(
        self,
        material: Mapping[str, float],
        first: int,
        second: int,
        gravity: float,
        load: float = TYPICAL_LOAD,
    ) -> Contact:
        if first != second:
            material = self.second.between(material)
        elif first == 2:
            material = {**material, **self.second.material}
        return super().between(material, first, second, gravity, load)

    def on_wall(
        self,
        material: Mapping[str, float],
        number: int,
        gravity: float,
        load: float = TYPICAL_LOAD,
    ) -> Contact:
        if number == 2:
            material = {**material, **self.second.material}
        return super().on_wall(material, number, gravity, load)


def two_materials(solver: str, second: SecondMaterial) -> type[DeckSolver]:
    """Return the program whose spheres of the second diameter are of a second material."""
    density = second.material["particle.density"]

    class _LammpsDeck(LammpsSceneDeck):
        @cached_property
        def kinds(self) -> SphereTypes:
            return _Types(super().kinds.radii, second=second)

        def contacts(self) -> Iterator[str]:
            yield command("set", f"type 2 density {density}")
            yield from super().contacts()

    class _LiggghtsDeck(LiggghtsSceneDeck):
        def particle_types(self) -> tuple[int, list[int]]:
            last = super().particle_types()[0] + 1
            return last, np.where(self.size_indices == 1, last, 1).tolist()

        def contacts(self) -> Iterator[str]:
            yield command("set", f"type {self.particle_types()[0]} density {density}")
            yield from super().contacts()

        def properties(self) -> LiggghtsProperties[float]:
            return _with_second(super().properties(), second)

    class _Lammps(Lammps):
        deck: ClassVar[type[SceneDeck]] = _LammpsDeck

    class _Liggghts(Liggghts):
        deck: ClassVar[type[SceneDeck]] = _LiggghtsDeck

    return {"lammps": _Lammps, "liggghts": _Liggghts}[solver]


def _with_second(
    properties: LiggghtsProperties[float], second: SecondMaterial
) -> LiggghtsProperties[float]:
    """Return properties with those of the second material as the last type."""
    keys, material = properties.keys, second.material
    bodies = {
        name: [*row, material[f"particle.{keys[name]}"]] for name, row in properties.bodies.items()
    }
    pairs = {
        name: _bordered(
            matrix,
            {**material, **second.with_first}[f"particle_particle.{keys[name]}"],
            material[f"particle_wall.{keys[name]}"],
            material[f"particle_particle.{keys[name]}"],
        )
        for name, matrix in properties.pairs.items()
    }
    return LiggghtsProperties(bodies, pairs, keys)


def _bordered(
    matrix: Sequence[Sequence[float]], with_first: float, on_wall: float, itself: float
) -> list[list[float]]:
    """Return a symmetric matrix with a row and a column more: particles, walls, itself."""
    last = [with_first, *[on_wall] * (len(matrix) - 1)]
    return [*([*row, value] for row, value in zip(matrix, last, strict=True)), [*last, itself]]
