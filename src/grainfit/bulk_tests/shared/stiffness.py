"""Stiffness of particles, and the bulk density that their overlap adds.

DEM particles are usually far softer than real ones, because the time step is proportional to
1 / sqrt(E). Soft particles overlap under the weight of the bed, which packs more densely for it:
the angle of repose of a heap does not mind, its bulk density does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from grainfit.bulk_tests.base import Conditions
from grainfit.bulk_tests.sensitivities import DENSITY, MODULUS

#: Solid fractions of the default heap at 9 stiffness numbers from 525 to 112,000, of two materials
#: with three seeds each (docs/stiffness.md), follow 1 + 6.5 / sqrt(E / (rho g d)) within 0.5 %. A
#: fit of the exponent gives 0.49 +- 0.02.
_EXCESS = 6.5


def stiffness_number(material: Mapping[str, float], conditions: Conditions) -> float:
    """Return E / (rho g d): Young's modulus over the weight of a particle on its cross-section.

    Parameters
    ----------
    material : mapping of str to float
        At least Young's modulus (Pa) and density (kg/m^3) of the particles, by dotted name.
    conditions : Conditions
        Particle sizes and gravity of a test.
    """
    weight = material[DENSITY] * conditions.gravity * conditions.sizes.sauter_diameter
    return material[MODULUS] / weight


def excess_density(number: float) -> float:
    """Return the relative excess of the bulk density over that of rigid particles.

    It is proportional to the time step. Measured on heaps in a cylinder ten particles high; a
    higher bed has more.

    Parameters
    ----------
    number : float
        E / (rho g d), above zero.

    Examples
    --------
    >>> [round(excess_density(number), 3) for number in (1750, 17_500, 1e6)]
    [0.155, 0.049, 0.006]
    """
    return _EXCESS / math.sqrt(number)


def number_with_excess(excess: float) -> float:
    """Return the stiffness number at which the bulk density has a relative excess.

    Parameters
    ----------
    excess : float
        Above zero.

    Examples
    --------
    >>> round(number_with_excess(0.02))
    105625
    """
    return (_EXCESS / excess) ** 2
