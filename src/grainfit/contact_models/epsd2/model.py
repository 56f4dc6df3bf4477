"""EPSD2 rolling friction in closed form, as a spring of constant stiffness.

The reference is LIGGGHTS (``rolling_friction epsd2``). It has the limit of EPSD and no dashpot, and
its rolling stiffness is that of the tangential contact, for any rolling friction.

References
----------
Iwashita & Oda (1998), J. Eng. Mech. 124:285-292: rolling stiffness from the tangential one.
Ai, Chen, Rotter & Ooi (2011), Powder Technology 206:269-282: models with and without dashpot.
"""

from __future__ import annotations

import math

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import (
    EffectiveModuli,
    hertz_overlap,
    particle_moduli,
    tangential_stiffness,
)


def rolling_stiffness(moduli: EffectiveModuli, effective_radius: float, load: float) -> float:
    """Return the rolling stiffness over R*^2 at a normal force, N/m.

    EPSD2: ``k_r = k_t R*^2`` (N m) with ``k_t = 8 G* sqrt(R* overlap)``. The force of LAMMPS acts
    on the rolling displacement R* theta with the lever R*, so its stiffness is k_t.

    Parameters
    ----------
    moduli : EffectiveModuli
        Of the contact.
    effective_radius : float
        R*, m: r_i r_j / (r_i + r_j) of two spheres, r of a sphere on a wall.
    load : float
        Normal force, N.
    """
    overlap = hertz_overlap(load, moduli, effective_radius)
    return tangential_stiffness(moduli) * math.sqrt(effective_radius * overlap)


def rolling_stiffness_of(contact: Contact) -> float:
    """Return the stiffness of a contact at its typical load, see `rolling_stiffness`."""
    if contact.springs is not None:
        return contact.springs.tangential
    moduli = particle_moduli(contact.material, contact.body)
    return rolling_stiffness(moduli, contact.effective_radius, contact.load)
