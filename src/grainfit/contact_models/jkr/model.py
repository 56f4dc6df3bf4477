"""Contact of Johnson, Kendall and Roberts in closed form.

The surface energy gamma is half the work of adhesion w of the two surfaces: w = 2 gamma. The pull-
off force is 3 pi gamma R* = 1.5 pi w R*.

References
----------
Johnson, Kendall & Roberts (1971), Proc. R. Soc. Lond. A 324:301-313.
Johnson (1985), Contact Mechanics, chapter 5.5.
"""

from __future__ import annotations

import math

from grainfit.contact_models.base import Attraction
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import particle_moduli


def attraction(contact: Contact) -> Attraction:
    """Return the attraction of a contact; it does not grow with the load."""
    energy, radius = contact.value("surface_energy"), contact.effective_radius
    force = pull_off_force(energy, radius)
    modulus = particle_moduli(contact.material, contact.body).young
    contact_radius = unloaded_contact_radius(energy, modulus, radius)
    return Attraction(force, force, contact_radius**2 / (3 * radius))


def pull_off_force(surface_energy: float, effective_radius: float) -> float:
    """Return the pull-off force, N.

    Examples
    --------
    >>> round(pull_off_force(0.05, 0.0025), 6)
    0.001178
    """
    return 3 * math.pi * surface_energy * effective_radius


def unloaded_contact_radius(
    surface_energy: float, modulus: float, effective_radius: float
) -> float:
    """Return the contact radius without a load, m; ``modulus`` is E* (Pa).

    There, 4 E* a^3 / (3 R*) equals sqrt(16 pi gamma E* a^3), and the overlap is a^2 / (3 R*).
    """
    return float((9 * math.pi * surface_energy * effective_radius**2 / modulus) ** (1 / 3))


def force_at(
    overlap: float, surface_energy: float, modulus: float, effective_radius: float
) -> float:
    """Return the normal force at an overlap, N; attraction is negative.

    Of the two contact radii of an overlap, the larger one is stable.
    """
    low = float((math.pi * surface_energy * effective_radius**2 / (4 * modulus)) ** (1 / 3))
    high = (
        low
        + 2 * math.sqrt(effective_radius * max(overlap, 0.0))
        + unloaded_contact_radius(surface_energy, modulus, effective_radius)
    )
    for _ in range(200):
        middle = (low + high) / 2
        reach = middle**2 / effective_radius
        reach -= math.sqrt(4 * math.pi * surface_energy * middle / modulus)
        low, high = (middle, high) if reach < overlap else (low, middle)
    radius = (low + high) / 2
    elastic = 4 * modulus * radius**3 / (3 * effective_radius)
    return elastic - math.sqrt(16 * math.pi * surface_energy * modulus * radius**3)
