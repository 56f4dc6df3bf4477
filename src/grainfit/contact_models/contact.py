"""A contact of a particle with another or with a wall: material, radii, typical normal force."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

#: Normal force, in particle weights, at which coefficients are taken that a solver holds constant
#: while those of the contact model grow with the load.
TYPICAL_LOAD = 5.0
#: Moment of inertia about the point of contact over mass times squared radius.
_ROLLING_INERTIA = 7 / 5


@dataclass(frozen=True)
class Springs:
    """Stiffness of a contact that is the same at every load.

    Parameters
    ----------
    normal, tangential : float
        Force over overlap, and over tangential displacement, N/m.
    """

    normal: float
    tangential: float


@dataclass(frozen=True)
class Contact:
    """A particle that touches another, or a wall.

    Parameters
    ----------
    material : mapping of str to float
        All material parameters by dotted name; those of walls are those of this wall.
    radius : float
        Of the particle, m.
    other_radius : float or None
        Of the other particle, m; None is a wall.
    load : float
        Typical normal force, N.
    gravity : float
        m/s^2.
    springs : Springs, optional
        Those of its contact law; without them, the stiffness is that of Hertz and Mindlin.
    """

    material: Mapping[str, float]
    radius: float
    other_radius: float | None
    load: float
    gravity: float
    springs: Springs | None = None

    @classmethod
    def between(
        cls,
        material: Mapping[str, float],
        radius: float,
        other: float,
        gravity: float,
        load: float = TYPICAL_LOAD,
    ) -> Contact:
        """Return the contact of two particles under a load in particle weights."""
        masses = particle_mass(material, radius), particle_mass(material, other)
        weight = 2 * _reduced(*masses) * gravity
        return cls(material, radius, other, load * weight, gravity)

    @classmethod
    def on_wall(
        cls,
        material: Mapping[str, float],
        radius: float,
        gravity: float,
        load: float = TYPICAL_LOAD,
    ) -> Contact:
        """Return the contact of a particle with a wall under a load in particle weights."""
        weight = particle_mass(material, radius) * gravity
        return cls(material, radius, None, load * weight, gravity)

    @property
    def body(self) -> Literal["particle", "wall"]:
        """The other body."""
        return "wall" if self.other_radius is None else "particle"

    def value(self, key: str) -> float:
        """Return a parameter of this contact, by its key in the section of the file."""
        return self.material[f"particle_{self.body}.{key}"]

    @property
    def effective_radius(self) -> float:
        """R*, m: r_i r_j / (r_i + r_j) of two spheres, r of a sphere on a wall."""
        if self.other_radius is None:
            return self.radius
        return _reduced(self.radius, self.other_radius)

    @property
    def effective_mass(self) -> float:
        """m*, kg: m_i m_j / (m_i + m_j) of two spheres, m of a sphere on a wall."""
        own = particle_mass(self.material, self.radius)
        if self.other_radius is None:
            return own
        return _reduced(own, particle_mass(self.material, self.other_radius))

    @property
    def weight(self) -> float:
        """Weight that loads are counted in, N: of the particle, or 2 m* g of two."""
        return self._counted_mass * self.gravity

    @property
    def impact_speed(self) -> float:
        """Typical speed of an impact, m/s: sqrt(g d) at `TYPICAL_LOAD`, with the mean diameter d.

        It grows with the root of the load, so that it is that of the stress where there is one.
        """
        other = self.radius if self.other_radius is None else self.other_radius
        acceleration = self.load / TYPICAL_LOAD / self._counted_mass
        return math.sqrt(acceleration * (self.radius + other))

    @property
    def _counted_mass(self) -> float:
        return self.effective_mass * (1 if self.other_radius is None else 2)

    @property
    def rolling_inertia(self) -> float:
        """I_r, kg m^2: 1.4 m r^2 of a sphere on a wall, the reduced one of two spheres."""
        own = _rolling_inertia(self.material, self.radius)
        if self.other_radius is None:
            return own
        return _reduced(own, _rolling_inertia(self.material, self.other_radius))


def particle_mass(material: Mapping[str, float], radius: float) -> float:
    """Return the mass of a sphere of the particles' density, kg."""
    return material["particle.density"] * 4 / 3 * math.pi * radius**3


def _rolling_inertia(material: Mapping[str, float], radius: float) -> float:
    return _ROLLING_INERTIA * particle_mass(material, radius) * radius**2


def _reduced(one: float, other: float) -> float:
    return one * other / (one + other)
