"""Particle size distributions"""

from __future__ import annotations

import math
from dataclasses import dataclass

from grainfit.errors import Fault, InputError


@dataclass(frozen=True)
class ParticleSizes:
    """A discrete particle size distribution.

    Parameters
    ----------
    diameters : tuple of float
        Sphere diameters, m.
    mass_fractions : tuple of float
        Share of the mass in each diameter (as a sieve gives it); sums to one.

    Examples
    --------
    >>> ParticleSizes((0.010,)).smallest_radius
    0.005
    """

    diameters: tuple[float, ...]
    mass_fractions: tuple[float, ...] = (1.0,)

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
    def smallest_radius(self) -> float:
        """Radius of the smallest particle, m: it sets the Rayleigh time step."""
        return min(self.diameters) / 2

    @property
    def number_fractions(self) -> tuple[float, ...]:
        """Share of the number of particles in each diameter."""
        counts = [f / d**3 for f, d in zip(self.mass_fractions, self.diameters, strict=True)]
        total = sum(counts)
        return tuple(count / total for count in counts)

    @property
    def sauter_diameter(self) -> float:
        """Diameter of equal volume to surface ratio (d32), m: the length scale of geometries."""
        return 1 / sum(f / d for f, d in zip(self.mass_fractions, self.diameters, strict=True))
