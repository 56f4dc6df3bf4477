"""Contacts of a cohesive material: Bond number, and particles that are too soft for cohesion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from grainfit.contact_models import messages
from grainfit.contact_models.base import LARGEST_OVERLAP, Attraction, ContactLaw
from grainfit.contact_models.contact import Contact
from grainfit.errors import Fault
from grainfit.materials.walls import material_on, walls_among

_MODULUS = "particle.youngs_modulus"
#: Parameters without which no contact can be computed.
_ELASTIC = ("youngs_modulus", "poissons_ratio")
_OF_PARTICLES = {"particle.density", *(f"particle.{key}" for key in _ELASTIC)}
_OF_WALL = {f"wall.{key}" for key in _ELASTIC}
#: Young's moduli that are tried, each over the one before.
_STEP, _STEPS = 1.05, 400


@dataclass(frozen=True)
class CohesiveContact:
    """A cohesive contact in numbers without a unit.

    Parameters
    ----------
    bond_number : float
        Attraction under the typical load over the weight of a particle.
    pull_off : float
        Pull-off force over the weight of a particle.
    overlap : float
        Overlap without a load over the diameter of the particle.
    """

    bond_number: float
    pull_off: float
    overlap: float


def cohesive_contact(law: ContactLaw, contact: Contact) -> CohesiveContact:
    """Return the numbers of a contact; zeros where nothing is cohesive."""
    if law.cohesion is None or law.cohesion.attraction is None:
        return CohesiveContact(0.0, 0.0, 0.0)
    found: Attraction = law.cohesion.attraction(contact)
    return CohesiveContact(
        found.under_load / contact.weight,
        found.pull_off / contact.weight,
        found.overlap / (2 * contact.radius),
    )


def overlap_faults(
    law: ContactLaw, material: Mapping[str, float], diameters: Iterable[float], gravity: float
) -> list[Fault]:
    """Return why particles are too soft for their cohesion; empty if they are not.

    Parameters
    ----------
    law : ContactLaw
        The contact models that act.
    material : mapping of str to float
        Values by dotted name; of an incomplete material, nothing is known.
    diameters : iterable of float
        Of the particles, or of the smallest spheres of clumps, m.
    gravity : float
        m/s^2.
    """
    cohesion = law.cohesion
    if cohesion is None or not material.keys() >= _OF_PARTICLES:
        return []
    contacts = [
        contact
        for diameter in diameters
        for contact in contacts_of(material, diameter, gravity).values()
    ]
    largest = max(cohesive_contact(law, contact).overlap for contact in contacts)
    if largest <= LARGEST_OVERLAP:
        return []
    moduli = (material[_MODULUS] * _STEP**number for number in range(_STEPS))
    enough = (e for e in moduli if _largest_overlap(law, contacts, e) < LARGEST_OVERLAP)
    modulus = next(enough, None)
    remedy = "less cohesion" if modulus is None else f"at least {modulus:.2g} Pa, or less cohesion"
    fault = messages.TOO_SOFT.fault(
        _MODULUS,
        modulus=material[_MODULUS],
        model=cohesion.name,
        overlap=100 * largest,
        remedy=remedy,
        limit=100 * LARGEST_OVERLAP,
    )
    return [fault]


def contacts_of(
    material: Mapping[str, float], diameter: float, gravity: float
) -> dict[str, Contact]:
    """Return the contacts of two equal particles, and of one with every wall, by name."""
    radius = diameter / 2
    found = {"two particles": Contact.between(material, radius, radius, gravity)}
    for wall in walls_among(material):
        own = material_on(material, wall)
        if own.keys() >= _OF_WALL:
            name = f"a particle and {wall or 'a wall'}"
            found[name] = Contact.on_wall(own, radius, gravity)
    return found


def _largest_overlap(law: ContactLaw, contacts: Iterable[Contact], modulus: float) -> float:
    return max(
        cohesive_contact(
            law, replace(contact, material={**contact.material, _MODULUS: modulus})
        ).overlap
        for contact in contacts
    )
