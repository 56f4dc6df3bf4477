"""The Rayleigh time step of a DEM material, its range over intervals, and its criterion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any

from grainfit.errors import Fault


def rayleigh_time_step(
    radius: float, density: float, youngs_modulus: float, poissons_ratio: float
) -> float:
    """Time in which a Rayleigh wave crosses the smallest particle: the limit of the DEM time step.

    Parameters
    ----------
    radius : float
        Radius of the smallest particle, m.
    density : float
        Density of the solid, kg/m^3.
    youngs_modulus : float
        Young's modulus, Pa.
    poissons_ratio : float
        Poisson's ratio.

    Returns
    -------
    float
        Rayleigh time step, s.

    References
    ----------
    Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016), equation 3.

    Examples
    --------
    >>> round(rayleigh_time_step(0.005, 2100.0, 3.6e5, 0.22), 6)
    0.002054
    """
    shear_modulus = youngs_modulus / (2 * (1 + poissons_ratio))
    wave = 0.1631 * poissons_ratio + 0.8766
    return math.pi * radius * math.sqrt(density / shear_modulus) / wave


_NAMES = ("particle.density", "particle.youngs_modulus", "particle.poissons_ratio")


@dataclass(frozen=True)
class RayleighTimeStep:
    """Rayleigh time step as a function of the free parameters.

    Parameters
    ----------
    radius : float
        Radius of the smallest particle, m.
    fixed : mapping of str to float
        Values of ``particle.density``, ``particle.youngs_modulus`` and
        ``particle.poissons_ratio`` where they are not free.
    """

    radius: float
    fixed: Mapping[str, float]

    def __post_init__(self) -> None:
        # Results are written as JSON, which has no numbers of NumPy.
        object.__setattr__(self, "radius", _plain(self.radius))
        fixed = {name: _plain(value) for name, value in self.fixed.items()}
        object.__setattr__(self, "fixed", fixed)

    def faults(self, intervals: Mapping[str, tuple[float, float]]) -> list[Fault]:
        """Return why the intervals have no Rayleigh time step; empty if they have one."""
        found = _value_faults("radius", self.radius, self.radius)
        for name in _NAMES:
            if name in intervals:
                found += _value_faults(name, *intervals[name])
            elif name in self.fixed:
                found += _value_faults(name, self.fixed[name], self.fixed[name])
            else:
                found.append(
                    Fault(
                        name,
                        "is neither fixed nor free, and the Rayleigh time step needs it.",
                        "Give its value in RayleighTimeStep, or make it a parameter.",
                    )
                )
        return found

    def __call__(self, parameters: Mapping[str, float]) -> float:
        """Rayleigh time step at these values of the free parameters, s."""
        values = {**self.fixed, **parameters}
        return rayleigh_time_step(self.radius, *(values[name] for name in _NAMES))

    def limits(self, intervals: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
        """Smallest and largest Rayleigh time step that the intervals allow, s.

        The Rayleigh time grows with density and Poisson's ratio (for all ratios in [0, 0.5]) and
        falls with Young's modulus, so both extremes are corners.
        """
        slowest = dict(self.fixed)
        fastest = dict(self.fixed)
        for name in _NAMES:
            if name in intervals:
                low, high = intervals[name]
                if name == "particle.youngs_modulus":
                    low, high = high, low
                slowest[name], fastest[name] = low, high
        return self(slowest), self(fastest)

    def criterion(
        self, parameters: Mapping[str, float], intervals: Mapping[str, tuple[float, float]]
    ) -> float:
        """Rayleigh criterion: 0 for the largest time step within reach, 1 for the smallest.

        It is 0 when nothing free changes the time step.

        References
        ----------
        Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016), equation 2.
        """
        smallest, largest = self.limits(intervals)
        if largest - smallest <= 1e-12 * largest:
            return 0.0
        return (largest - self(parameters)) / (largest - smallest)


def _plain(value: Any) -> Any:
    """The number as a float; anything else is left for `RayleighTimeStep.faults` to report."""
    return float(value) if isinstance(value, Real) and not isinstance(value, bool) else value


def _value_faults(name: str, low: float, high: float) -> list[Fault]:
    is_ratio = name == "particle.poissons_ratio"
    if isinstance(low, Real) and isinstance(high, Real):
        possible = 0 <= low <= high <= 0.5 if is_ratio else 0 < low <= high < math.inf
        if possible:
            return []
    shown = f"{low!r}" if low == high else f"{low} to {high}"
    wanted = "from 0 to 0.5" if is_ratio else "above 0"
    return [Fault(name, f"is {shown}.", f"The Rayleigh time step needs numbers {wanted}.")]
