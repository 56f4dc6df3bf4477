"""Attraction in proportion to the area of contact, in closed form.

SJKR is the "simplified JKR" of LIGGGHTS: a cohesion energy density k (J/m^3) times an area, beside
the force of Hertz. It is no approximation of JKR: the attraction grows with the load, and the
pull-off force depends on Young's modulus.
"""

from __future__ import annotations

import math

from grainfit.contact_models.base import Attraction
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import (
    hertz_overlap,
    hertz_stiffness,
    particle_moduli,
)

#: Newton's method doubles the digits in each.
_ITERATIONS = 12


def attraction(contact: Contact) -> Attraction:
    """Return the attraction of a contact with the area 2 pi R* overlap."""
    return area_attraction(contact, 2 * math.pi * contact.effective_radius)


def area_attraction(contact: Contact, area: float) -> Attraction:
    """Return the attraction of a contact whose area (m^2) is a length times the overlap.

    With F = 4/3 E* sqrt(R*) x^1.5 - c x, the unloaded overlap is (3 c / 4 E*)^2 / R*, and the
    pull-off force c^3 / (12 E*^2 R*).

    Parameters
    ----------
    contact : Contact
        The contact.
    area : float
        Area over overlap, m.
    """
    radius, load = contact.effective_radius, contact.load
    moduli = particle_moduli(contact.material, contact.body)
    slope = contact.value("cohesion_energy_density") * area
    overlap = (3 * slope / (4 * moduli.young)) ** 2 / radius
    loaded = overlap + 4 * hertz_overlap(load, moduli, radius)
    if loaded > overlap:
        # From above: Newton's iterations on a convex function stay above its root.
        for _ in range(_ITERATIONS):
            elastic = hertz_stiffness(loaded, moduli, radius)
            loaded -= ((elastic - slope) * loaded - load) / (1.5 * elastic - slope)
    pull_off = slope**3 / (12 * moduli.young**2 * radius)
    return Attraction(pull_off, slope * loaded, overlap)


def sphere_area(distance: float, radius: float, other: float | None) -> float:
    """Return the area in which two spheres, or a sphere and a plane, intersect, m^2.

    Parameters
    ----------
    distance : float
        Between the centres, or from the centre to the plane, m.
    radius, other : float
        Radii, m; None is a plane.

    Examples
    --------
    >>> round(sphere_area(0.8, 1.0, None) / math.pi, 6)
    0.36
    >>> round(sphere_area(1.6, 1.0, 1.0) / math.pi, 6)
    0.36
    """
    if other is None:
        return math.pi * (radius**2 - distance**2)
    to_area = (distance**2 + radius**2 - other**2) / (2 * distance)
    return math.pi * (radius**2 - to_area**2)
