"""Control of what presses on a bed: as slow as the dashpots of its contacts ask for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from grainfit.contact_models.contact import particle_mass
from grainfit.contact_models.hertz_mindlin.model import (
    damping_factor,
    effective_moduli,
    hertz_overlap,
    hertz_stiffness,
)

#: Contacts of a wall on the cross-section of a particle.
_CONTACTS = 0.7


@dataclass(frozen=True)
class Control:
    """A control is a dashpot that pulls a wall to its load, slower where contacts overcome it.

    A step's speed makes a force in the dashpots of the contacts. The next step answers it with more
    than that speed where they are stronger than the control, at any time step, and no load is held.

    Parameters
    ----------
    overcome : float
        Estimated damping of all contacts over that of the control, from which they overcome it.
    slower : float
        Damping of the control over that of the contacts where they would.
    """

    overcome: float
    slower: float

    def dashpot(
        self,
        usual: float,
        area: float,
        diameter: float,
        stress: float,
        material: Mapping[str, float],
    ) -> float:
        """Return the damping of the control of a wall under a stress, N s/m.

        Parameters
        ----------
        usual : float
            Damping where no contacts overcome it, N s/m.
        area : float
            Of the wall, m^2.
        diameter : float
            Sauter diameter of the particles, m.
        stress : float
            Pa.
        material : mapping of str to float
            Material parameters by dotted name.
        """
        contacts = contact_damping(area, diameter, stress, material)
        return self.slower * contacts if contacts > self.overcome * usual else usual


def contact_damping(
    area: float, diameter: float, stress: float, material: Mapping[str, float]
) -> float:
    """Return the estimated normal damping of all contacts of a wall, N s/m; see `Control`."""
    count = _CONTACTS * area / (math.pi / 4 * diameter**2)
    moduli = effective_moduli(
        material["particle.youngs_modulus"], material["particle.poissons_ratio"], math.inf, 0.0
    )
    overlap = hertz_overlap(stress * area / count, moduli, diameter / 2)
    stiffness = hertz_stiffness(overlap, moduli, diameter / 2)
    mass = particle_mass(material, diameter / 2)
    given = (value for name, value in material.items() if name.endswith("restitution"))
    least = min(given, default=1.0)
    return count * 2 * math.sqrt(5 / 6 * stiffness * mass) * damping_factor(least)
