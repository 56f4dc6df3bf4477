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

#: Solid fraction of the default heap over E / (rho g d), sliding friction 0.5, rolling friction
#: 0.2, two to six seeds each (standard error 0.2 to 0.4 %); the stiffest is taken as stiff.
_SOLID_FRACTION = ((525, 0.673), (1750, 0.609), (5250, 0.573), (17_500, 0.553), (52_500, 0.543))
_LOGARITHMS = [math.log(number) for number, _ in _SOLID_FRACTION]
_EXCESS = [fraction / _SOLID_FRACTION[-1][1] - 1 for _, fraction in _SOLID_FRACTION]


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
    """Return the relative excess of the bulk density over that of stiff particles.

    Interpolated in the logarithm of the stiffness number. Beyond the softest measured particles it
    is extrapolated; beyond the stiffest it is zero.

    Parameters
    ----------
    number : float
        E / (rho g d).

    Examples
    --------
    >>> [round(excess_density(number), 3) for number in (1750, 17_500, 1e6)]
    [0.122, 0.018, 0.0]
    """
    position = math.log(number)
    part = max(sum(position >= known for known in _LOGARITHMS) - 1, 0)
    if part == len(_LOGARITHMS) - 1:
        return 0.0
    left, right = _LOGARITHMS[part : part + 2]
    low, high = _EXCESS[part : part + 2]
    return low + (high - low) * (position - left) / (right - left)


def number_with_excess(excess: float) -> float:
    """Return the stiffness number at which the bulk density has a relative excess.

    Parameters
    ----------
    excess : float
        Above zero.

    Examples
    --------
    >>> round(number_with_excess(excess_density(4000.0)))
    4000
    """
    part = max(sum(excess <= known for known in _EXCESS) - 1, 0)
    part = min(part, len(_EXCESS) - 2)
    low, high = _EXCESS[part : part + 2]
    left, right = _LOGARITHMS[part : part + 2]
    return math.exp(left + (right - left) * (excess - low) / (high - low))
