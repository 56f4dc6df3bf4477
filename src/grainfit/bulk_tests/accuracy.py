"""Usual accuracies of laboratory measurements.

One table: the standard uncertainty with which a laboratory usually measures a response; the figures
of docs/choosing_tests.md are made with it. They are estimates: a laboratory that knows its own
accuracy gives the uncertainty of a target, or an option of `grainfit advise` and `design`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from grainfit.formatting import number, unit_for_people, with_unit


@dataclass(frozen=True)
class Accuracy:
    """Standard uncertainty of a measurement: absolute, or a share of the value.

    Parameters
    ----------
    value : float
        In the unit of the response, or the share.
    is_share : bool
        Whether it is a share of the value.
    """

    value: float
    is_share: bool = False

    def of(self, value: float) -> float:
        """Return the standard uncertainty of a value, in its unit."""
        return self.value * abs(value) if self.is_share else self.value

    def times(self, factor: float) -> Accuracy:
        """Return one that is coarser by a factor."""
        return Accuracy(factor * self.value, self.is_share)

    def in_words(self, unit: str) -> str:
        """Return it for readers.

        Examples
        --------
        >>> Accuracy(0.01, is_share=True).in_words("kg/m^3"), Accuracy(0.5).in_words("deg")
        ('1 %', '0.5°')
        """
        if self.is_share:
            return f"{number(100 * self.value, 2)} %"
        return with_unit(number(self.value, 2), unit_for_people(unit))


#: Usual accuracy by name of the response, where it is not that of its unit: averages of a steady
#: state, which instruments measure better than the slope of a heap, and a mean of several
#: directions by a ruler.
_OF_RESPONSE: Mapping[str, Accuracy] = {
    "internal_friction_angle": Accuracy(0.5),
    "phi_sf": Accuracy(0.5),
    "dynamic_angle": Accuracy(0.5),
    "ffc": Accuracy(0.1, is_share=True),
    "base_radius": Accuracy(0.01, is_share=True),
}
#: Usual accuracy by unit: angles, densities, mass flows, stresses and moduli, lengths, ratios.
_OF_UNIT: Mapping[str, Accuracy] = {
    "deg": Accuracy(1.0),
    "kg/m^3": Accuracy(0.01, is_share=True),
    "kg/s": Accuracy(0.02, is_share=True),
    "Pa": Accuracy(0.05, is_share=True),
    "m": Accuracy(0.02, is_share=True),
    "": Accuracy(0.02),
}
_ANY = Accuracy(0.05, is_share=True)
#: The best instruments beside what a laboratory usually has.
_BEST = 0.1


def usual_accuracy(response: str, unit: str) -> Accuracy:
    """Return the accuracy with which a laboratory usually measures a response.

    Parameters
    ----------
    response : str
        Its name in the bulk test.
    unit : str
        Its unit.
    """
    return _OF_RESPONSE.get(response) or _OF_UNIT.get(unit, _ANY)


def finest_accuracy(response: str, unit: str) -> Accuracy:
    """Return the accuracy that the best instruments reach: a tenth of the usual one.

    Parameters
    ----------
    response : str
        Its name in the bulk test.
    unit : str
        Its unit.
    """
    return usual_accuracy(response, unit).times(_BEST)
