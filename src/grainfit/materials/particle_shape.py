"""Shapes of particles: built-in families of clumps of spheres, or spheres of the user.

A clump has the volume of the sphere whose diameter the particle size distribution has. Its mass and
inertia are those of the union of its spheres, of uniform density (`grainfit.materials.clumps`).

References
----------
Kruggel-Emden, Rickelt, Wirtz & Scherer, Powder Technol. 188 (2008), 153: multi-sphere particles.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import permutations
from typing import TYPE_CHECKING

from grainfit.errors import Fault, InputError
from grainfit.materials import messages

if TYPE_CHECKING:
    # Imports NumPy, which the state of a calibration does without.
    from grainfit.materials.clumps import Clump

#: Material parameter with the aspect ratio of built-in clumps; 1 is a sphere.
ASPECT_RATIO = "particle.aspect_ratio"
#: Aspect ratio from which on an interval that begins at 1 has clumps.
NEAREST_CLUMP = 1.001
#: Distance of spheres in a row over their diameter: the outline dents by 3 % of the diameter.
_ROW_STEP = 0.5
_MOST_SPHERES = 50
#: Raised whenever clumps of one definition become other runs.
CLUMPS_REVISION = 2
#: Smallest radius over the largest: the smallest sphere sets the time step.
_SMALLEST = 0.01

Sphere = tuple[float, float, float, float]


@dataclass(frozen=True)
class Family:
    """A built-in family of clumps with an aspect ratio, at which 1 is a sphere.

    Parameters
    ----------
    words : str
        Description, for help.
    largest : float
        Largest aspect ratio.
    spheres : callable
        Returns the spheres at an aspect ratio: position and radius, of a clump with a width of 1.
    """

    words: str
    largest: float
    spheres: Callable[[float], list[Sphere]]


def _row(aspect_ratio: float) -> list[Sphere]:
    """Spheres of diameter 1 in a row of this length."""
    length = aspect_ratio - 1
    count = 1 + math.ceil(length / _ROW_STEP - 1e-9)
    return [(x, 0.0, 0.0, 0.5) for x in _spread(length / 2, count)]


def _two_spheres(aspect_ratio: float) -> list[Sphere]:
    half = (aspect_ratio - 1) / 2
    return [(-half, 0.0, 0.0, 0.5), (half, 0.0, 0.0, 0.5)]


def _tetrahedron(aspect_ratio: float) -> list[Sphere]:
    """Spheres of diameter 1 at the corners of a tetrahedron with this largest extent."""
    half = (aspect_ratio - 1) / math.sqrt(8)
    corners = ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
    return [(half * x, half * y, half * z, 0.5) for x, y, z in corners]


def _lens(aspect_ratio: float) -> list[Sphere]:
    """A sphere of diameter 1 and a ring of such spheres about it."""
    radius = (aspect_ratio - 1) / 2
    count = max(6, math.ceil(2 * math.pi * radius / _ROW_STEP))
    turns = [2 * math.pi * n / count for n in range(count)]
    ring = [(radius * math.cos(a), radius * math.sin(a), 0.0, 0.5) for a in turns]
    return [(0.0, 0.0, 0.0, 0.5), *ring]


def _grain(aspect_ratio: float) -> list[Sphere]:
    """Seven spheres that touch the inside of a prolate spheroid with a diameter of 1."""
    half, width = aspect_ratio / 2, 0.5
    focal = half**2 - width**2
    # The outermost sphere has the curvature of the tip; its centre is where that of the tip is.
    return [
        (x, 0.0, 0.0, width * math.sqrt(1 - x**2 / focal) if focal else width)
        for x in _spread(focal / half, 7)
    ]


def _spread(end: float, count: int) -> list[float]:
    """Places at equal distances from minus to plus an end."""
    return [end * (2 * n / (count - 1) - 1) if count > 1 else 0.0 for n in range(count)]


#: Built-in families by name.
FAMILIES: Mapping[str, Family] = {
    "two_spheres": Family("two equal spheres", 2.0, _two_spheres),
    "tetrahedron": Family("four equal spheres at the corners of a tetrahedron", 2.0, _tetrahedron),
    "cylinder": Family("equal spheres in a row: a pellet with round ends", 3.0, _row),
    "lens": Family("a ring of equal spheres about another: a flat pellet", 3.0, _lens),
    "grain": Family("seven spheres inside a spheroid, as a wheat grain", 3.0, _grain),
}


LARGEST_ASPECT_RATIO = max(family.largest for family in FAMILIES.values())


@dataclass(frozen=True)
class ParticleShape:
    """Shape of all particles of a material: a built-in family, or spheres of the user.

    Parameters
    ----------
    family : str
        Name in `FAMILIES`; empty for spheres of the user.
    spheres : tuple of tuple of float
        x, y, z and radius of the user's spheres, in any unit: the particle size gives the scale.
    aspect_ratio : float, optional
        Of a built-in family; None while it is not known.

    Raises
    ------
    InputError
        There is no such family, the aspect ratio is out of its range, or the spheres make no body.

    Examples
    --------
    >>> len(ParticleShape("two_spheres", aspect_ratio=1.5).clump)
    2
    """

    family: str = ""
    spheres: tuple[Sphere, ...] = ()
    aspect_ratio: float | None = None

    def __post_init__(self) -> None:
        InputError.raise_for(self._faults())

    def _faults(self) -> list[Fault]:
        if bool(self.family) == bool(self.spheres):
            return [messages.NO_SHAPE.fault("particle.shape", families=", ".join(FAMILIES))]
        if self.spheres:
            return _sphere_faults(self.spheres)
        if self.family not in FAMILIES:
            names = ", ".join(FAMILIES)
            return [messages.NO_FAMILY.fault("particle.shape", family=self.family, families=names)]
        largest, ratio = FAMILIES[self.family].largest, self.aspect_ratio
        if ratio is not None and not 1 <= ratio <= largest:
            fault = messages.ASPECT_RATIO_OF_FAMILY.fault(
                ASPECT_RATIO, ratio=ratio, family=self.family, largest=largest
            )
            return [fault]
        return []

    @property
    def has_aspect_ratio(self) -> bool:
        """Whether the material's aspect ratio has an effect."""
        return bool(self.family)

    def with_aspect_ratio(self, aspect_ratio: float) -> ParticleShape:
        """Return the shape at an aspect ratio; spheres of the user are what they are."""
        if not self.family:
            return self
        return ParticleShape(self.family, aspect_ratio=float(aspect_ratio))

    @property
    def clump(self) -> Clump | None:
        """The clump; None for a sphere, and while the aspect ratio is not known."""
        from grainfit.materials.clumps import clump_of

        if self.spheres:
            return clump_of(self.spheres)
        if self.aspect_ratio is None or self.aspect_ratio == 1:
            return None
        return clump_of(tuple(FAMILIES[self.family].spheres(self.aspect_ratio)))

    def definition(self) -> str | list[list[float]]:
        """Return everything that affects a run beside the aspect ratio, as JSON."""
        return self.family or [list(sphere) for sphere in self.spheres]

    @classmethod
    def from_definition(cls, definition: str | list[list[float]] | None) -> ParticleShape | None:
        """Return the shape with a definition; None without one."""
        if not definition:
            return None
        if isinstance(definition, str):
            return cls(definition)
        return cls(spheres=tuple((x, y, z, r) for x, y, z, r in definition))

    def __str__(self) -> str:
        if self.spheres:
            return f"{len(self.spheres)} spheres of your own"
        ratio = "" if self.aspect_ratio is None else f", aspect ratio {self.aspect_ratio:.4g}"
        return f"{self.family}{ratio}"


def aspect_ratio_faults(shape: ParticleShape | None, aspect_ratio: float) -> list[Fault]:
    """Return why particles of a shape cannot have an aspect ratio; empty if they can."""
    if aspect_ratio == 1:
        return []
    if shape is None or not shape.has_aspect_ratio:
        what = "spheres" if shape is None else "spheres of your own"
        family = next(iter(FAMILIES))
        return [messages.NO_ASPECT_RATIO.fault(ASPECT_RATIO, what=what, family=family)]
    try:
        shape.with_aspect_ratio(aspect_ratio)
    except InputError as error:
        return list(error.faults)
    return []


def _sphere_faults(spheres: tuple[Sphere, ...]) -> list[Fault]:
    key = "particle.shape.spheres"
    if not 2 <= len(spheres) <= _MOST_SPHERES:
        return [messages.NUMBER_OF_SPHERES.fault(key, count=len(spheres), most=_MOST_SPHERES)]
    radii = [radius for *_, radius in spheres]
    if not all(math.isfinite(value) for sphere in spheres for value in sphere) or min(radii) <= 0:
        return [messages.IMPOSSIBLE_SPHERE.fault(key)]
    if min(radii) < _SMALLEST * max(radii):
        return [messages.SPHERE_TOO_SMALL.fault(key, smallest=_SMALLEST)]
    for (n, one), (m, other) in permutations(enumerate(spheres, 1), 2):
        # Of two equal ones, the later.
        if _is_inside(one, other) and (n > m or not _is_inside(other, one)):
            return [messages.SPHERE_INSIDE.fault(key, inner=n, outer=m)]
    apart = set(range(1, len(spheres)))
    reached = [0]
    while reached:
        one = spheres[reached.pop()]
        near = {n for n in apart if _touch(one, spheres[n])}
        apart -= near
        reached += near
    if apart:
        return [messages.SPHERE_APART.fault(key, number=min(apart) + 1)]
    return []


def _is_inside(one: Sphere, other: Sphere) -> bool:
    return math.dist(one[:3], other[:3]) + one[3] <= other[3] * (1 + 1e-9)


def _touch(one: Sphere, other: Sphere) -> bool:
    return math.dist(one[:3], other[:3]) <= (one[3] + other[3]) * (1 + 1e-9)
