"""The 14 parameters of one particulate medium and one wall, and the sizes of its particles."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from grainfit.errors import Fault, InputError


@dataclass(frozen=True)
class MaterialParameter:
    """What a DEM material parameter is called, measured in, and can physically be.

    Parameters
    ----------
    name : str
        Dotted name as in the calibration file, ``section.key``.
    symbol, unit, description : str
        For axis labels and help; the unit is SI, ``""`` when dimensionless.
    lowest, highest : float
        Physical limits (inclusive) that no interval may leave.
    """

    name: str
    symbol: str
    unit: str
    description: str
    lowest: float
    highest: float


_BODY = (
    ("youngs_modulus", "E", "Pa", "Young's modulus", 1e3, 1e13),
    ("poissons_ratio", "ν", "", "Poisson's ratio", 0.0, 0.4999),
    ("density", "ρ", "kg/m^3", "density of the solid", 1.0, 3e4),
)
_CONTACT = (
    ("sliding_friction", "μ", "", "sliding friction coefficient", 0.0, 10.0),
    ("rolling_friction", "μ_r", "", "rolling friction coefficient", 0.0, 10.0),
    ("restitution", "e", "", "coefficient of restitution", 0.01, 1.0),
    ("rolling_damping", "η_r", "", "viscous rolling damping ratio", 0.0, 1.0),
)


def _all_parameters() -> dict[str, MaterialParameter]:
    sections = {
        "particle": ("particle", "p", _BODY),
        "wall": ("wall", "w", _BODY),
        "particle_particle": ("particle-particle", "pp", _CONTACT),
        "particle_wall": ("particle-wall", "pw", _CONTACT),
    }
    parameters = {}
    for section, (words, index, rows) in sections.items():
        for key, symbol, unit, description, lowest, highest in rows:
            name = f"{section}.{key}"
            parameters[name] = MaterialParameter(
                name, f"{symbol}_{index}", unit, f"{words} {description}", lowest, highest
            )
    return parameters


#: The 14 material parameters by dotted name, in the order of the calibration file.
MATERIAL_PARAMETERS: Mapping[str, MaterialParameter] = _all_parameters()


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
