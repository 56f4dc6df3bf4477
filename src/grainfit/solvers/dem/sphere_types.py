"""Types of spheres: the different spheres of a material, and the masses that they move with."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from grainfit.contact_models.contact import TYPICAL_LOAD, Contact, particle_mass
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.spheres import ClumpSpheres, clump_spheres


@dataclass(frozen=True)
class SphereTypes:
    """Types of spheres, numbered from 1.

    Parameters
    ----------
    radii : tuple of float
        Radius of each type, m.
    diameters : tuple of float, optional
        Of clumps: for each type, the diameter of a sphere of the volume of its clump, m.
    """

    radii: tuple[float, ...]
    diameters: tuple[float, ...] = ()

    @classmethod
    def of(cls, sizes: ParticleSizes, *, with_spheres: bool = False) -> SphereTypes:
        """Return the types of a material; with spheres, types of its diameters follow clumps."""
        whole = tuple(diameter / 2 for diameter in sizes.diameters)
        spheres: ClumpSpheres | None = clump_spheres(sizes)
        if spheres is None:
            return cls(whole)
        radii, diameters = spheres.radii_of_kinds, spheres.kind_diameters()
        if with_spheres:
            return cls((*radii, *whole), (*diameters, *sizes.diameters))
        return cls(tuple(radii), tuple(diameters))

    @classmethod
    def mean_of(cls, sizes: ParticleSizes) -> SphereTypes:
        """Return one type that stands for all: of a mean clump, its largest sphere."""
        diameter, clump = sizes.sauter_diameter, sizes.clump
        if clump is None:
            return cls((diameter / 2,))
        return cls((diameter * float(clump.radii.max()),), (diameter,))

    def between(
        self,
        material: Mapping[str, float],
        first: int,
        second: int,
        gravity: float,
        load: float = TYPICAL_LOAD,
    ) -> Contact:
        """Return the contact of spheres of two types under a load in particle weights."""
        one, other = self.radii[first - 1], self.radii[second - 1]
        contact = Contact.between(material, one, other, gravity, load)
        if not self.diameters:
            return contact
        masses = self._mass(material, first), self._mass(material, second)
        reduced = masses[0] * masses[1] / sum(masses)
        return _heavy(contact, sum(masses) / 2, load * 2 * reduced * gravity)

    def on_wall(
        self,
        material: Mapping[str, float],
        number: int,
        gravity: float,
        load: float = TYPICAL_LOAD,
    ) -> Contact:
        """Return the contact of a sphere of a type with a wall under a load in weights."""
        contact = Contact.on_wall(material, self.radii[number - 1], gravity, load)
        if not self.diameters:
            return contact
        mass = self._mass(material, number)
        return _heavy(contact, mass, load * mass * gravity)

    def _mass(self, material: Mapping[str, float], number: int) -> float:
        return particle_mass(material, self.diameters[number - 1] / 2)


def is_one_size(sizes: ParticleSizes) -> bool:
    """Return whether all particles are spheres of one diameter."""
    return len(sizes.diameters) == 1 and sizes.shape is None


def _heavy(contact: Contact, mass: float, load: float) -> Contact:
    """Return a contact whose density makes a sphere as heavy as its clump."""
    density = mass / (4 / 3 * math.pi * contact.radius**3)
    return replace(contact, material={**contact.material, "particle.density": density}, load=load)
