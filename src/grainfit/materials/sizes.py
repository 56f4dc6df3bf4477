"""Particle size distributions"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Protocol

from grainfit.errors import Fault, InputError
from grainfit.formatting import millimetres, percent

#: Diameters that particles can have, m.
SMALLEST_DIAMETER, LARGEST_DIAMETER = 1e-7, 1.0


class Origin(Protocol):
    """Distribution that particle sizes stand for."""

    @property
    def is_cut_below(self) -> bool:
        """Whether the finest particles are left out already."""

    def describe(self, sizes: ParticleSizes) -> Iterator[str]:
        """Yield the distribution, and what the sizes change, in words."""

    def without_finest(self, share: float) -> tuple[float, ParticleSizes]:
        """Return the sizes without the finest share of the mass, and their lower limit, m."""


@dataclass(frozen=True)
class ParticleSizes:
    """A discrete particle size distribution.

    Parameters
    ----------
    diameters : tuple of float
        Sphere diameters, m.
    mass_fractions : tuple of float
        Share of the mass in each diameter (as a sieve gives it); sums to one.
    origin : Origin, optional
        Continuous distribution that they stand for. Sizes that agree are equal whatever it is.

    Examples
    --------
    >>> ParticleSizes((0.010,)).smallest_radius
    0.005
    """

    diameters: tuple[float, ...]
    mass_fractions: tuple[float, ...] = (1.0,)
    origin: Origin | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if not self.diameters or len(self.diameters) != len(self.mass_fractions):
            raise InputError(
                Fault("particle.diameter", "needs one mass fraction for every diameter.")
            )
        if any(not (math.isfinite(d) and d > 0) for d in self.diameters):
            raise InputError(Fault("particle.diameter", f"{self.diameters} must all be above 0."))
        if any(not (math.isfinite(f) and f > 0) for f in self.mass_fractions) or not math.isclose(
            sum(self.mass_fractions), 1.0, abs_tol=1e-6
        ):
            raise InputError(
                Fault(
                    "particle.diameter",
                    f"mass fractions {self.mass_fractions} must be above 0 and sum to 1.",
                )
            )

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
    def smallest_radius(self) -> float:
        """Radius of the smallest particle, m: it sets the Rayleigh time step."""
        return min(self.diameters) / 2

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
        return ParticleSizes(
            tuple(self.diameters[i] for i in rest),
            tuple(self.mass_fractions[i] / mass for i in rest),
        )

    def mass_moment(self, order: int) -> float:
        """Return the mean of d^order over the mass, m^order."""
        shares = zip(self.mass_fractions, self.diameters, strict=True)
        return sum(share * diameter**order for share, diameter in shares)

    @property
    def sauter_diameter(self) -> float:
        """Diameter of equal volume to surface ratio (d32), m: the length scale of geometries."""
        return 1 / sum(f / d for f, d in zip(self.mass_fractions, self.diameters, strict=True))
