"""Strata of the atlas: rows of one bulk test with one kind of particles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple, cast

from grainfit.atlas.row import Row
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.natural_units import Scale, unit_of_parameter
from grainfit.bulk_tests.parameter_names import (
    DENSITY,
    MODULUS,
    RESTITUTION,
    ROLLING,
    SLIDING,
    WALL_RESTITUTION,
    WALL_ROLLING,
    WALL_SLIDING,
)
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.size import CanBeResized, size_power
from grainfit.bulk_tests.stiffness import UnderLoad, stiffness_number
from grainfit.bulk_tests.time_steps import usual_time_step_fraction
from grainfit.bulk_tests.varied_options import InAtlas, Range, VariedOptions
from grainfit.materials.particle_shape import ASPECT_RATIO, ParticleShape
from grainfit.materials.sizes import ParticleSizes

STIFFNESS, SIZE = "stiffness", "size"
#: Overlaps of Hertz contacts, and what they add to a response, follow this power of the stiffness.
_OVERLAP = -2 / 3
#: Of the rows, in SI units; all others follow in natural units.
ROW_SCALE = Scale(0.01, 2000.0, 9.81)
#: Young's modulus over the stress that presses particles together.
_UNDER_OWN_WEIGHT = Range(1500.0, 20_000.0, power=_OVERLAP)
_UNDER_A_STRESS = Range(1000.0, 20_000.0, power=_OVERLAP)
#: Frictions, and the restitution of all contacts.
_FRICTIONS: Mapping[str, Range] = {
    SLIDING: Range(0.05, 1.5, power=0),
    # Below 0.05 hardly any heap is one: fewer rows are there than on a logarithmic scale.
    ROLLING: Range(0.01, 1.5, power=0.3),
    WALL_SLIDING: Range(0.05, 1.2, power=0),
    WALL_ROLLING: Range(0.005, 0.8, power=0),
    RESTITUTION: Range(0.2, 0.9),
}
#: Parameters of the rows that responses hardly depend on, or not at all with stiff walls.
_FIXED: Mapping[str, float] = {
    DENSITY: ROW_SCALE.density,
    "particle.poissons_ratio": 0.3,
    "wall.youngs_modulus": 2.11e11,
    "wall.poissons_ratio": 0.3,
    "wall.density": 7700.0,
    "particle_particle.rolling_damping": 0.0,
    "particle_wall.rolling_damping": 0.0,
}


@dataclass(frozen=True)
class Particles:
    """Particles of a stratum, and their contact law.

    Parameters
    ----------
    name : str
        Name of the strata that have them; that of dry spheres is empty.
    title : str
        In words.
    material : mapping of str to Range
        Material parameters that the rows vary, in natural units.
    shape : ParticleShape, optional
        None is a sphere.
    cohesion : str
        Model of cohesion; empty without one.
    limit : mapping of str to float
        Inputs at which dry spheres are these particles, too: their rows are known as well.
    """

    name: str
    title: str
    material: Mapping[str, Range]
    shape: ParticleShape | None = None
    cohesion: str = ""
    limit: Mapping[str, float] = field(default_factory=dict)

    def sizes(self, diameter: float) -> ParticleSizes:
        """Return the particles at a diameter, m."""
        return ParticleSizes((diameter,), shape=self.shape)


_ENERGIES = ("particle_particle.surface_energy", "particle_wall.surface_energy")
_DRY_SPHERES = Particles("", "dry spheres", _FRICTIONS)
#: All others by name, of which there are rows of a few tests.
_PARTICLES: Mapping[str, Particles] = {
    one.name: one
    for one in (
        Particles(
            "cohesive",
            "cohesive spheres (jkr)",
            # Bond numbers up to 9, and 18 on walls.
            {**_FRICTIONS, **dict.fromkeys(_ENERGIES, Range(0.0, 2.0, power=1 / 3))},
            cohesion="jkr",
            limit=dict.fromkeys(_ENERGIES, 0.0),
        ),
        Particles(
            "clumps",
            "clumps of two spheres",
            {
                **_FRICTIONS,
                # Many who have clumps leave out the friction of rolling.
                ROLLING: Range(0.0, 1.0, power=0.5),
                WALL_ROLLING: Range(0.0, 0.8, power=0.5),
                ASPECT_RATIO: Range(1.1, 2.0),
            },
            ParticleShape("two_spheres"),
            limit={ASPECT_RATIO: 1.0},
        ),
    )
}


class Simulated(NamedTuple):
    """A test and a material that can be simulated."""

    test: BulkTest
    material: Mapping[str, float]


@dataclass(frozen=True)
class Stratum:
    """Rows of one bulk test with one kind of particles.

    Parameters
    ----------
    kind : type
        Class of the test, which is `InAtlas`.
    varied : VariedOptions
        What the rows vary of the apparatus.
    particles : Particles
        The particles.
    """

    kind: type[BulkTest]
    varied: VariedOptions
    particles: Particles = _DRY_SPHERES

    @property
    def name(self) -> str:
        """Name of its files."""
        return "-".join(filter(None, (self.kind.type, self.varied.name, self.particles.name)))

    @property
    def title(self) -> str:
        """The test, its apparatus and the particles in words."""
        particles = self.particles.title if self.particles.name else ""
        return ", ".join(filter(None, (self.kind.title, self.varied.title, particles)))

    @property
    def limit(self) -> Mapping[str, float]:
        """Inputs at which dry spheres in the usual apparatus are the same."""
        return {**self.particles.limit, **self.varied.limit}

    @property
    def ranges(self) -> dict[str, Range]:
        """Ranges of all inputs, by name of the input."""
        # A class, not a test: all that the protocol asks for is in it.
        usual = _UNDER_A_STRESS if isinstance(self.kind, UnderLoad) else _UNDER_OWN_WEIGHT
        stiffness = self.varied.stiffness or usual
        own = self.varied.surface_energy if self.particles.cohesion else None
        energies = {} if own is None else dict.fromkeys(_ENERGIES, own)
        material = {**self.particles.material, **energies}
        return {**material, STIFFNESS: stiffness, **self.varied.ranges}

    def with_limit(self, rows: Sequence[Row]) -> list[Row]:
        """Return rows of dry spheres in the usual apparatus as rows of these; of those, none."""
        limit = self.limit
        return [replace(row, inputs={**row.inputs, **limit}) for row in rows] if limit else []

    def simulated(self, inputs: Mapping[str, float]) -> Simulated:
        """Return test and material of a row.

        Raises
        ------
        InputError
            The apparatus is impossible.
        """
        test = self.apparatus(inputs, ROW_SCALE)
        own = {
            name: inputs[name] * ROW_SCALE.of(unit_of_parameter(name))
            for name in self.particles.material
        }
        material = {**_FIXED, **own, WALL_RESTITUTION: inputs[RESTITUTION], MODULUS: 1.0}
        material[MODULUS] = inputs[STIFFNESS] / stiffness_number(test, material)
        ends = {name: (value, value) for name, value in material.items()}
        fraction = usual_time_step_fraction(test, ends)
        return Simulated(test.with_time_step_fraction(fraction), material)

    def apparatus(self, inputs: Mapping[str, float], scale: Scale) -> BulkTest:
        """Return the test in the apparatus of a row, at any scale.

        Raises
        ------
        InputError
            The apparatus is impossible.
        """
        sizes = self.particles.sizes(scale.length)
        return self.kind(sizes, gravity=scale.gravity, **self.options(inputs, scale))

    def options(self, inputs: Mapping[str, float], scale: Scale) -> dict[str, Any]:
        """Return the options of this apparatus, possible or not."""
        varied, sizes = self.varied, self.particles.sizes(scale.length)
        usual = self.kind(sizes, gravity=scale.gravity, **varied.same)
        options: dict[str, Any] = {**varied.same, **self._at_size(usual, inputs[SIZE])}
        values = usual.resolved_options()
        factors = {**varied.wider, **{name: inputs[name] for name in varied.factors}}
        for name, factor in factors.items():
            grown = inputs[SIZE] ** varied.factor_powers.get(name, 0.0)
            options[name] = factor * grown * options.get(name, values[name])
        options |= {name: _whole(span, inputs[name]) for name, span in varied.values.items()}
        return options | {name: inputs[name] * scale.of("Pa") for name in varied.loads}

    def powers(self, response: str) -> dict[str, float]:
        """Return the powers of inputs that a response follows by itself: of size and load."""
        loads = self.varied.loads if response in self.varied.per_load else ()
        return {SIZE: size_power(self.kind, response) or 0.0, **dict.fromkeys(loads, 1.0)}

    def proportion(self, response: str, inputs: Mapping[str, Any]) -> Any:
        """Return the product of these powers."""
        return math.prod(inputs[name] ** power for name, power in self.powers(response).items())

    def _at_size(self, usual: BulkTest, size: float) -> dict[str, Any]:
        found = cast(CanBeResized, usual).at_size(size)
        return {name: value for name, value in found.items() if name not in self.varied.left}


@cache
def strata() -> Mapping[str, Stratum]:
    """Return all strata by name."""
    return {one.name: one for one in _strata()}


def _strata() -> Iterator[Stratum]:
    for kind in bulk_tests().values():
        if isinstance(kind, InAtlas):
            for varied in kind.varied:
                yield Stratum(kind, varied)
                yield from (Stratum(kind, varied, _PARTICLES[name]) for name in varied.particles)


def _whole(span: Range, value: float) -> float | int:
    return round(value) if span.is_whole else value
