"""Stiffness of particles, and the bulk density that their overlap adds.

DEM particles are usually far softer than real ones, because their time steps are longer. Soft
particles overlap under the load of a bed, which packs more densely for it: the angle of repose of a
heap does not depend on it, its bulk density does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Protocol, runtime_checkable

from grainfit.bulk_tests.parameter_names import DENSITY, MODULUS
from grainfit.one_line import OneLine

if TYPE_CHECKING:
    from grainfit.bulk_tests.base import BulkTest


@dataclass(frozen=True)
class OverlapLaw(OneLine):
    """Excess of a response, mostly a bulk density, over that of stiff particles, as measured.

    Interpolated in the logarithm of the stiffness number, and extrapolated to softer particles than
    the softest measured.

    Parameters
    ----------
    symbol : str
        Stiffness number in words, such as ``"E/stress"``.
    measured : tuple of (float, float)
        Stiffness numbers and relative excesses, from the softest particles to the stiffest, whose
        excess is zero.
    """

    symbol: str
    measured: tuple[tuple[float, float], ...]

    def excess(self, number: float) -> float:
        """Return the relative excess of the bulk density over that of stiff particles.

        Parameters
        ----------
        number : float
            Stiffness number, above zero.

        Examples
        --------
        >>> [round(UNDER_OWN_WEIGHT.excess(number), 3) for number in (1750, 17_500, 1e6)]
        [0.136, 0.032, 0.0]
        """
        position = math.log(number)
        known = [math.log(value) for value, _ in self.measured]
        if position >= known[-1]:
            return 0.0
        part = max(sum(position >= value for value in known) - 1, 0)
        left, right = known[part : part + 2]
        low, high = (excess for _, excess in self.measured[part : part + 2])
        return low + (high - low) * (position - left) / (right - left)

    def number_with(self, excess: float) -> float:
        """Return the stiffness number at which the bulk density has a relative excess.

        Parameters
        ----------
        excess : float
            Zero or above.

        Examples
        --------
        >>> round(UNDER_OWN_WEIGHT.number_with(UNDER_OWN_WEIGHT.excess(4000.0)))
        4000
        """
        above = sum(excess <= known for _, known in self.measured)
        part = min(max(above - 1, 0), len(self.measured) - 2)
        (left, low), (right, high) = self.measured[part : part + 2]
        share = (excess - low) / (high - low)
        return math.exp(math.log(left) + math.log(right / left) * share)


#: Of beds that only their own weight presses: the default heap, two materials together, two to six
#: seeds each (standard error 0.003); from 112,000 to 447,000 it does not change any more:
#: docs/developers/evidence.md. Beds are ten particles high; higher beds have more.
UNDER_OWN_WEIGHT = OverlapLaw(
    "E/(\u03c1 g d)",
    (
        (525, 0.255),
        (1750, 0.136),
        (5250, 0.070),
        (17_500, 0.032),
        (52_500, 0.0125),
        (112_000, 0.0),
    ),
)
#: Of beds under a stress. The overlap of Hertz contacts follows (stress / E)^(2/3); the factor is
#: that of 14 compression tests at 1000 to 64,000 with two materials (6.1 to 0.4 %), from which a
#: run deviates by 0.6 %: docs/developers/evidence.md. Below 0.1 % nothing is left.
UNDER_A_STRESS = OverlapLaw(
    "E/stress",
    (*((1000 * 2**n, 0.061 * 2 ** (-2 / 3 * n)) for n in range(9)), (512_000, 0.0)),
)
#: Of beds in steady shear under a normal stress: the factor of (stress / E)^(2/3) is that of 15
#: runs of one material at 720 to 46,000 (9.1 to 0.6 %), from which a run deviates by 0.5 %, see
#: docs/developers/evidence.md. Trials at 216 to 7200 gave 7.7 instead of 7.3.
IN_SHEAR = OverlapLaw(
    "E/normal stress",
    (*((700 * 2**n, 7.3 * (700 * 2**n) ** (-2 / 3)) for n in range(9)), (512_000, 0.0)),
)


@runtime_checkable
class UnderLoad(Protocol):
    """A test in which more than the weight of the bed presses particles together."""

    #: Bulk density that overlaps of soft particles add, over `stiffness_number`.
    overlap_law: ClassVar[OverlapLaw]

    def stiffness_number(self, material: Mapping[str, float]) -> float:
        """Return Young's modulus over the stress that presses particles together."""


def overlap_law(test: BulkTest) -> OverlapLaw:
    """Return the bulk density that overlaps of soft particles add in a test."""
    return test.overlap_law if isinstance(test, UnderLoad) else UNDER_OWN_WEIGHT


def stiffness_number(test: BulkTest, material: Mapping[str, float]) -> float:
    """Return Young's modulus over the stress that presses the particles of a test together.

    For most tests E / (rho g d): over the weight of a particle on its cross-section.

    Parameters
    ----------
    test : BulkTest
        The test.
    material : mapping of str to float
        At least Young's modulus (Pa) and density (kg/m^3) of the particles, by dotted name.
    """
    if isinstance(test, UnderLoad):
        return test.stiffness_number(material)
    weight = material[DENSITY] * float(test.gravity) * test.sizes.sauter_diameter
    return material[MODULUS] / weight
