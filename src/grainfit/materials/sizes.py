"""Particle size distributions"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Protocol

from grainfit.errors import InputError
from grainfit.formatting import millimetres, percent, without_noise
from grainfit.materials import messages
from grainfit.materials.particle_shape import CLUMPS_REVISION, ParticleShape
from grainfit.one_line import OneLine
from grainfit.validation import as_number, number_list_faults, plain_tuple, set_plain

if TYPE_CHECKING:
    from grainfit.arrays import Array
    from grainfit.materials.clumps import Clump

#: Diameters that particles can have, m.
SMALLEST_DIAMETER, LARGEST_DIAMETER = 1e-7, 1.0


class Origin(Protocol):
    """Distribution that particle sizes stand for."""

    @property
    def is_cut_below(self) -> bool:
        """Whether the finest particles are left out already."""

    def describe(self, sizes: ParticleSizes) -> Iterator[str]:
        """Yield the distribution, and what the sizes change, in words; real sizes are named."""

    def without_finest(self, share: float) -> tuple[float, ParticleSizes]:
        """Return real sizes without the finest share of the mass, and their lower limit, m."""


#: Largest factor of coarse graining: beyond it no bulk test has room for its particles.
LARGEST_FACTOR = 1000.0


@dataclass(frozen=True)
class ParticleSizes(OneLine):
    """A discrete particle size distribution.

    Parameters
    ----------
    diameters : sequence of float
        Sphere diameters, m; of clumps, those of spheres of equal volume.
    mass_fractions : sequence of float
        Share of the mass in each diameter (as a sieve gives it); sums to one.
    coarse_graining : float
        Number of real diameters in a simulated one: the diameters are those of the simulation.
    shape : ParticleShape, optional
        Shape of all particles, see `grainfit.materials.clumps`; None is a sphere.
    origin : Origin, optional
        Continuous distribution that the real ones stand for. Sizes that agree are equal whatever
        it is.

    Examples
    --------
    >>> ParticleSizes((0.010,)).smallest_radius
    0.005
    """

    diameters: tuple[float, ...]
    mass_fractions: tuple[float, ...] = (1.0,)
    coarse_graining: float = 1.0
    shape: ParticleShape | None = None
    origin: Origin | None = field(default=None, compare=False, repr=False)

    if TYPE_CHECKING:
        # Arrays are read: attributes are tuples.
        def __init__(
            self,
            diameters: Sequence[float] | Array,
            mass_fractions: Sequence[float] | Array = (1.0,),
            coarse_graining: float = 1.0,
            shape: ParticleShape | None = None,
            origin: Origin | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        for key in ("diameters", "mass_fractions"):
            object.__setattr__(self, key, plain_tuple(getattr(self, key)))
        set_plain(self, "coarse_graining")
        InputError.raise_for(
            number_list_faults("particle.diameter", self.diameters)
            + number_list_faults("mass_fractions", self.mass_fractions)
        )
        if not 1 <= as_number(self.coarse_graining) <= LARGEST_FACTOR:
            raise InputError(
                messages.COARSE_GRAINING.fault(
                    "particle.coarse_graining", factor=self.coarse_graining, largest=LARGEST_FACTOR
                )
            )
        if not self.diameters or len(self.diameters) != len(self.mass_fractions):
            raise InputError(messages.NUMBER_OF_FRACTIONS.fault("particle.diameter"))
        if any(not (math.isfinite(d) and d > 0) for d in self.diameters):
            fault = messages.DIAMETERS_NOT_POSITIVE.fault("particle.diameter", given=self.diameters)
            raise InputError(fault)
        if any(not (math.isfinite(f) and f > 0) for f in self.mass_fractions) or not math.isclose(
            sum(self.mass_fractions), 1.0, abs_tol=1e-6
        ):
            fault = messages.NO_MASS_FRACTIONS.fault("particle.diameter", given=self.mass_fractions)
            raise InputError(fault)

    @classmethod
    def from_definition(cls, definition: Mapping[str, Any]) -> ParticleSizes:
        """Rebuild the sizes from the definition of a run.

        Raises
        ------
        KeyError, TypeError, InputError
            The definition is damaged.
        """
        return cls(
            tuple(definition["diameters"]),
            tuple(definition["mass_fractions"]),
            definition.get("coarse_graining", 1.0),
            ParticleShape.from_definition(definition.get("shape")),
        )

    def definition(self) -> dict[str, Any]:
        """Return everything that identifies the sizes, as JSON; an aspect ratio is a parameter."""
        found: dict[str, Any] = {
            "diameters": list(self.diameters),
            "mass_fractions": list(self.mass_fractions),
        }
        # Runs of spheres of real sizes keep the identity that they had before there were others.
        if self.coarse_graining != 1:
            found["coarse_graining"] = self.coarse_graining
        if self.shape is not None:
            found["shape"] = self.shape.definition()
            found["clumps"] = CLUMPS_REVISION
        return found

    def coarse_grained(self, factor: float) -> ParticleSizes:
        """Return these particles enlarged by a factor, for fewer particles and longer time steps.

        Examples
        --------
        >>> ParticleSizes((0.003,)).coarse_grained(4).diameters
        (0.012,)
        """
        diameters = tuple(factor * d for d in self.diameters)
        return replace(self, diameters=diameters, coarse_graining=factor * self.coarse_graining)

    @property
    def real(self) -> ParticleSizes:
        """The real particles, which default geometries follow."""
        if self.coarse_graining == 1:
            return self
        diameters = tuple(d / self.coarse_graining for d in self.diameters)
        return replace(self, diameters=diameters, coarse_graining=1.0)

    @property
    def without_noise(self) -> ParticleSizes:
        """The same sizes as they are to be written: products have rounding of the computer.

        Runs keep the products that they had, as their identities follow from them.

        Examples
        --------
        >>> enlarged = ParticleSizes((0.003,)).coarse_grained(3)
        >>> enlarged.diameters, enlarged.without_noise.diameters
        ((0.009000000000000001,), (0.009,))
        """
        return replace(self, diameters=tuple(map(without_noise, self.diameters)))

    @property
    def words(self) -> str:
        """The diameters for readers, with their shares of the mass.

        Examples
        --------
        >>> ParticleSizes((0.010,)).words
        '10 mm'
        >>> ParticleSizes((0.008, 0.010), (0.3, 0.7)).words
        '8 mm (30 % of the mass), 10 mm (70 %)'
        """
        if len(self.diameters) == 1:
            return millimetres(self.diameters[0])
        if len(set(self.mass_fractions)) == 1:
            shown = ", ".join(map(millimetres, self.diameters))
            return f"{shown}, each {percent(self.mass_fractions[0])} of the mass"
        pairs = zip(self.diameters, self.mass_fractions, strict=True)
        shown = ", ".join(f"{millimetres(d)} ({percent(share)})" for d, share in pairs)
        return shown.replace("%)", "% of the mass)", 1)

    @property
    def clump(self) -> Clump | None:
        """The clump that all particles are; None for spheres, and for an unknown aspect ratio."""
        return None if self.shape is None else self.shape.clump

    def with_aspect_ratio(self, aspect_ratio: float | None) -> ParticleSizes:
        """Return the same sizes at another aspect ratio; None, and spheres, change nothing."""
        if self.shape is None or aspect_ratio is None:
            return self
        return replace(self, shape=self.shape.with_aspect_ratio(aspect_ratio))

    @property
    def smallest_radius(self) -> float:
        """Radius of the smallest sphere, m."""
        return min(self.sphere_diameters) / 2

    @property
    def sphere_diameters(self) -> tuple[float, ...]:
        """Diameters of the smallest spheres of the particles, m; of spheres, their own."""
        clump = self.clump
        scale = 1.0 if clump is None else 2 * clump.smallest_radius
        return tuple(scale * diameter for diameter in self.diameters)

    @property
    def rayleigh_radius(self) -> float:
        """Radius of the sphere whose Rayleigh time limits the time step, m.

        It is that of the smallest sphere, unless spheres of a clump nearly coincide.
        """
        clump = self.clump
        return min(self.diameters) * (0.5 if clump is None else clump.rayleigh_radius)

    @property
    def outer_diameters(self) -> tuple[float, ...]:
        """Diameters of the spheres about the centres that contain the particles, m."""
        clump = self.clump
        scale = 1.0 if clump is None else 2 * clump.outer_radius
        return tuple(scale * diameter for diameter in self.diameters)

    @property
    def number_fractions(self) -> tuple[float, ...]:
        """Share of the number of particles in each diameter."""
        counts = [f / d**3 for f, d in zip(self.mass_fractions, self.diameters, strict=True)]
        total = sum(counts)
        return tuple(count / total for count in counts)

    def without(self, index: int) -> ParticleSizes:
        """Return the sizes without one of the diameters; the others keep their proportions."""
        rest = [i for i in range(len(self.diameters)) if i != index]
        mass = sum(self.mass_fractions[i] for i in rest)
        return replace(
            self,
            diameters=tuple(self.diameters[i] for i in rest),
            mass_fractions=tuple(self.mass_fractions[i] / mass for i in rest),
            origin=None,
        )

    def mass_moment(self, order: int) -> float:
        """Return the mean of d^order over the mass, m^order."""
        shares = zip(self.mass_fractions, self.diameters, strict=True)
        return sum(share * diameter**order for share, diameter in shares)

    @property
    def sauter_diameter(self) -> float:
        """Diameter of equal volume to surface ratio (d32), m: the length scale of geometries."""
        return 1 / sum(f / d for f, d in zip(self.mass_fractions, self.diameters, strict=True))
