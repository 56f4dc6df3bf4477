"""SJKR2 in closed form: SJKR with the area 2 pi overlap 2 R* of LIGGGHTS.

For two spheres it is twice the area of intersection; on a wall, where LIGGGHTS takes the radius for
2 R*, it is the area of intersection at small overlaps.
"""

from __future__ import annotations

import math

from grainfit.contact_models.base import Attraction
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.sjkr.model import area_attraction


def attraction(contact: Contact) -> Attraction:
    """Return the attraction of a contact."""
    return area_attraction(contact, area_over_overlap(contact.radius, contact.other_radius))


def area_over_overlap(radius: float, other: float | None) -> float:
    """Return the area over the overlap, m; None is a plane."""
    return 2 * math.pi * (radius if other is None else 2 * radius * other / (radius + other))
