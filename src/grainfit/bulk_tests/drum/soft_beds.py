"""What soft particles do to the angles of a drum: their bed is flatter, at every speed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.drum import messages
from grainfit.bulk_tests.parameter_names import DENSITY, MODULUS
from grainfit.bulk_tests.stiffness import OverlapLaw, stiffness_number
from grainfit.checks import Found, check
from grainfit.formatting import number, rounded_off

#: Stiffness numbers E / (rho g d), and degrees by which the dynamic angle of rough spheres is below
#: that of the stiffest: mean of Froude numbers 0.005 to 0.1 (`benchmarks/soft_drums.py`).
_SOFTEST = 1750.0
_FLATTENED = OverlapLaw(
    "E/(\u03c1 g d)", ((_SOFTEST, 4.0), (7000.0, 1.9), (28_000.0, 0.7), (112_000.0, 0.0))
)
#: What a laboratory tells apart, degrees.
_TOLD_APART = 0.5


@check("soft-drum", "note")
def soft_drum(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Drums whose particles are so soft that their bed is flatter than that of stiff ones."""
    if not checked.targets or MODULUS not in checked.lowest or DENSITY not in checked.highest:
        return
    softest = {**checked.lowest, DENSITY: checked.highest[DENSITY]}
    value = stiffness_number(checked.test, softest)
    less = flattening(value)
    if less > _TOLD_APART:
        enough = softest[MODULUS] * _FLATTENED.number_with(_TOLD_APART) / value
        yield (
            "",
            messages.SOFT_DRUM(
                number=number(value, 3),
                less=less,
                told=_TOLD_APART,
                enough=number(rounded_off(enough / 1e6, 2, up=True), 2),
            ),
        )


def flattening(value: float) -> float:
    """Return how many degrees the bed of a drum is flatter than with stiff particles.

    Parameters
    ----------
    value : float
        Stiffness number, E / (rho g d); softer particles than were measured flatten as much as the
        softest of these.
    """
    return _FLATTENED.excess(max(value, _SOFTEST))
