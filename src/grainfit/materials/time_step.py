"""The Rayleigh time step of a DEM material, its range over intervals, and its criterion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any

from grainfit.errors import Fault, InputError
from grainfit.materials import messages
from grainfit.materials.equations import Equation
from grainfit.materials.particle_shape import ASPECT_RATIO, ParticleShape
from grainfit.one_line import OneLine
from grainfit.options.fields import read_options
from grainfit.options.kinds import Quantity
from grainfit.options.tables import Key
from grainfit.validation import mapping_faults

_ARGUMENTS = (
    Key("radius", Quantity("m", above_zero=True), "Of the smallest particle."),
    Key("density", Quantity("kg/m^3", above_zero=True), "Of the solid."),
    Key("youngs_modulus", Quantity("Pa", above_zero=True), "Of the solid."),
    Key("poissons_ratio", Quantity("", 0.0, 0.5), "Of the solid."),
)


def rayleigh_time_step(
    radius: float | str,
    density: float | str,
    youngs_modulus: float | str,
    poissons_ratio: float,
) -> float:
    """Time in which a Rayleigh wave crosses the smallest particle: the limit of the DEM time step.

    Parameters
    ----------
    radius : float or str
        Radius of the smallest particle, m, or a quantity such as ``"5 mm"``.
    density : float or str
        Density of the solid, kg/m^3.
    youngs_modulus : float or str
        Young's modulus, Pa.
    poissons_ratio : float
        Poisson's ratio.

    Returns
    -------
    float
        Rayleigh time step, s.

    Raises
    ------
    InputError
        An argument is no number of its unit, or an impossible one.

    References
    ----------
    Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016), equation 3.

    Examples
    --------
    >>> round(rayleigh_time_step(0.005, 2100.0, 3.6e5, 0.22), 6)
    0.002054
    """
    given = (radius, density, youngs_modulus, poissons_ratio)
    values = dict(zip((key.name for key in _ARGUMENTS), given, strict=True))
    InputError.raise_for(
        messages.NO_VALUE.fault(name) for name, value in values.items() if value is None
    )
    return _time_step(**read_options(_ARGUMENTS, values))


def _time_step(
    radius: float, density: float, youngs_modulus: float, poissons_ratio: float
) -> float:
    shear_modulus = youngs_modulus / (2 * (1 + poissons_ratio))
    wave = 0.1631 * poissons_ratio + 0.8766
    return math.pi * radius * math.sqrt(density / shear_modulus) / wave


#: Equations of `rayleigh_time_step` for people.
RAYLEIGH_EQUATIONS = (
    Equation("shear modulus", "G = E/(2 (1 + nu))", "of the particles"),
    Equation(
        "Rayleigh time step",
        "t_R = pi R sqrt(rho/G)/(0.1631 nu + 0.8766)",
        "R: radius of the smallest simulated sphere, rho: density of the solid",
    ),
)
RAYLEIGH_NAMES = ("particle.density", "particle.youngs_modulus", "particle.poissons_ratio")


@dataclass(frozen=True)
class RayleighTimeStep(OneLine):
    """Rayleigh time step as a function of the free parameters.

    Parameters
    ----------
    radius : float
        Radius of the smallest particle, m; of a clump, that of its smallest sphere.
    fixed : mapping of str to float
        Values of ``particle.density``, ``particle.youngs_modulus`` and
        ``particle.poissons_ratio`` where they are not free.
    shape : str, optional
        Family of clumps whose aspect ratio is free; the radius is then that of a sphere with the
        volume of the smallest clump. At an aspect ratio of 1, the time step is that of clumps
        whose spheres nearly coincide, which is shorter than that of a sphere.

    Examples
    --------
    >>> fixed = {"particle.density": 2100, "particle.youngs_modulus": 3.6e5}
    >>> step = RayleighTimeStep(0.005, {**fixed, "particle.poissons_ratio": 0.22}, "grain")
    >>> step({"particle.aspect_ratio": 1.5}) > step({"particle.aspect_ratio": 2.0})
    True
    """

    radius: float
    fixed: Mapping[str, float]
    shape: str = ""

    def __post_init__(self) -> None:
        InputError.raise_for(mapping_faults("fixed", self.fixed, '{"particle.density": 2500}'))
        # Results are written as JSON, which has no numbers of NumPy.
        object.__setattr__(self, "radius", _plain(self.radius))
        fixed = {name: _plain(value) for name, value in self.fixed.items()}
        object.__setattr__(self, "fixed", fixed)

    def to_json(self) -> dict[str, Any]:
        """Return the arguments, without a shape that there is not."""
        shape = {"shape": self.shape} if self.shape else {}
        return {"radius": self.radius, "fixed": dict(self.fixed), **shape}

    def faults(self, intervals: Mapping[str, tuple[float, float]]) -> list[Fault]:
        """Return why the intervals have no Rayleigh time step; empty if they have one."""
        found = _value_faults("radius", self.radius, self.radius)
        for name in RAYLEIGH_NAMES:
            if name in intervals:
                found += _value_faults(name, *intervals[name])
            elif name in self.fixed:
                found += _value_faults(name, self.fixed[name], self.fixed[name])
            else:
                found.append(messages.NEITHER_FIXED_NOR_FREE.fault(name))
        return found + (self._shape_faults(intervals) if self.shape else [])

    def _shape_faults(self, intervals: Mapping[str, tuple[float, float]]) -> list[Fault]:
        if ASPECT_RATIO not in intervals:
            return [messages.NEEDS_NO_SHAPE.fault(ASPECT_RATIO)]
        try:
            ParticleShape(self.shape)
        except InputError as error:
            return list(error.faults)
        return []

    def __call__(self, parameters: Mapping[str, float]) -> float:
        """Rayleigh time step at these values of the free parameters, s."""
        try:
            return self._at({**self.fixed, **parameters})
        except (KeyError, TypeError, ValueError, ArithmeticError):
            InputError.raise_for(self.faults({name: (v, v) for name, v in parameters.items()}))
            raise

    def _at(self, values: Mapping[str, float]) -> float:
        radius = self.radius
        if self.shape:
            # Imports NumPy, which the state of a calibration does without.
            from grainfit.materials.clump_radii import rayleigh_radius

            radius *= 2 * rayleigh_radius(self.shape, values[ASPECT_RATIO])
        return _time_step(radius, *(values[name] for name in RAYLEIGH_NAMES))

    def limits(self, intervals: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
        """Smallest and largest Rayleigh time step that the intervals allow, s."""
        shortest, longest = self.extremes(intervals)
        return self(shortest), self(longest)

    def extremes(
        self, intervals: Mapping[str, tuple[float, float]]
    ) -> tuple[dict[str, float], dict[str, float]]:
        """Return the values that give the smallest and the largest Rayleigh time step.

        The Rayleigh time grows with density and Poisson's ratio (for all ratios in [0, 0.5]) and
        falls with Young's modulus, so both extremes of these are corners.
        """
        shortest, longest = dict(self.fixed), dict(self.fixed)
        for name in RAYLEIGH_NAMES:
            if name in intervals:
                low, high = intervals[name]
                if name == "particle.youngs_modulus":
                    low, high = high, low
                shortest[name], longest[name] = low, high
        if self.shape:
            from grainfit.materials.clump_radii import extreme_aspect_ratios

            found = extreme_aspect_ratios(self.shape, *intervals[ASPECT_RATIO])
            shortest[ASPECT_RATIO], longest[ASPECT_RATIO] = found
        return shortest, longest

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
    return [messages.NO_TIME_STEP.fault(name, shown=shown, wanted=wanted)]
