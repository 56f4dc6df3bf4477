"""Particle size distributions"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from grainfit.errors import Fault, InputError
from grainfit.materials.particle_shape import ParticleShape

if TYPE_CHECKING:
    from grainfit.materials.clumps import Clump


@dataclass(frozen=True)
class ParticleSizes:
    """A discrete particle size distribution.

    Parameters
    ----------
    diameters : tuple of float
        Sphere diameters, m; of clumps, those of spheres of equal volume.
    mass_fractions : tuple of float
        Share of the mass in each diameter (as a sieve gives it); sums to one.
    shape : ParticleShape, optional
        Shape of all particles, see `grainfit.materials.clumps`; None is a sphere.

    Examples
    --------
    >>> ParticleSizes((0.010,)).smallest_radius
    0.005
    """

    diameters: tuple[float, ...]
    mass_fractions: tuple[float, ...] = (1.0,)
    shape: ParticleShape | None = None

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
        """Radius of the smallest sphere, m: it sets the Rayleigh time step."""
        clump = self.clump
        return min(self.diameters) * (0.5 if clump is None else clump.smallest_radius)

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

    @property
    def sauter_diameter(self) -> float:
        """Diameter of equal volume to surface ratio (d32), m: the length scale of geometries."""
        return 1 / sum(f / d for f, d in zip(self.mass_fractions, self.diameters, strict=True))
