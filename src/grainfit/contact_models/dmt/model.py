"""Contact of Derjaguin, Muller and Toporov in closed form: Hertz, and a constant attraction.

The surface energy gamma is half the work of adhesion w of the two surfaces: w = 2 gamma. The pull-
off force is 4 pi gamma R* = 2 pi w R*.

References
----------
Derjaguin, Muller & Toporov (1975), J. Colloid Interface Sci. 53:314-326.
"""

from __future__ import annotations

import math

from grainfit.contact_models.base import Attraction
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import hertz_overlap, particle_moduli


def attraction(contact: Contact) -> Attraction:
    """Return the attraction of a contact; it does not grow with the load."""
    radius = contact.effective_radius
    force = pull_off_force(contact.value("surface_energy"), radius)
    overlap = hertz_overlap(force, particle_moduli(contact.material, contact.body), radius)
    return Attraction(force, force, overlap)


def pull_off_force(surface_energy: float, effective_radius: float) -> float:
    """Return the pull-off force, N.

    Examples
    --------
    >>> round(pull_off_force(0.05, 0.0025), 6)
    0.001571
    """
    return 4 * math.pi * surface_energy * effective_radius
