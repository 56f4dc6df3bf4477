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

#: Excess of the bulk density of the default heap over E / (rho g d), of two materials together,
#: two to six seeds each (standard error 0.003); from 112,000 to 447,000 it does not change any
#: more: docs/stiffness.md.
_MEASURED = (
    (525, 0.255),
    (1750, 0.136),
    (5250, 0.070),
    (17_500, 0.032),
    (52_500, 0.0125),
    (112_000, 0.0),
)
_LOGARITHMS = [math.log(number) for number, _ in _MEASURED]
_EXCESS = [excess for _, excess in _MEASURED]


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

    Interpolated in the logarithm of the stiffness number, and extrapolated to softer particles than
    the softest measured. Measured on beds ten particles high; higher beds have more.

    Parameters
    ----------
    number : float
        E / (rho g d), above zero.

    Examples
    --------
    >>> [round(excess_density(number), 3) for number in (1750, 17_500, 1e6)]
    [0.136, 0.032, 0.0]
    """
    position = math.log(number)
    if position >= _LOGARITHMS[-1]:
        return 0.0
    part = max(sum(position >= known for known in _LOGARITHMS) - 1, 0)
    left, right = _LOGARITHMS[part : part + 2]
    low, high = _EXCESS[part : part + 2]
    return low + (high - low) * (position - left) / (right - left)


def number_with_excess(excess: float) -> float:
    """Return the stiffness number at which the bulk density has a relative excess.

    Parameters
    ----------
    excess : float
        Zero or above.

    Examples
    --------
    >>> round(number_with_excess(excess_density(4000.0)))
    4000
    """
    part = min(max(sum(excess <= known for known in _EXCESS) - 1, 0), len(_EXCESS) - 2)
    low, high = _EXCESS[part : part + 2]
    left, right = _LOGARITHMS[part : part + 2]
    return math.exp(left + (right - left) * (excess - low) / (high - low))
