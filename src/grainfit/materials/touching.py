"""How particles touch that touch in several places at once."""

from __future__ import annotations

from typing import NamedTuple


class Touching(NamedTuple):
    """Contact of two particles, over that of two spheres of their volume.

    Parameters
    ----------
    frequency : float
        Frequency of the contact.
    damping : float
        Damping ratio of the contact: the dashpots of all spheres that touch act at once.
    """

    frequency: float
    damping: float


#: Contact of two spheres.
ONE_PAIR = Touching(1.0, 1.0)
