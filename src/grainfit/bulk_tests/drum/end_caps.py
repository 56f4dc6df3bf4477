"""What the end caps of a drum do to its angles: their friction carries the bed up."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.drum import messages
from grainfit.checks import Found, check
from grainfit.formatting import number

#: Degrees that caps add to the dynamic angle of rough spheres, times the length of the drum in
#: particle diameters: 5, 3.3 and 1.5 at 4, 6 and 12 of them (`benchmarks/drum_caps.py`).
_STEEPENED = 20.0
#: What a laboratory tells apart, degrees.
_TOLD_APART = 0.5


@check("no-end-caps", "warning")
def no_end_caps(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Drums without end caps in a file that says what these are made of."""
    wall = checked.walls.get("caps")
    if wall and not checked.test.end_caps:
        yield "end_caps", messages.NO_END_CAPS(wall=wall)


@check("coarse-caps", "note")
def coarse_caps(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Drums whose enlarged particles are carried up by the end caps more than the real ones."""
    test = checked.test
    if not (test.end_caps and checked.targets):
        return
    sizes, length = test.sizes, float(test.setup.drum_length)
    real = steepening(sizes.real.sauter_diameter, length)
    more = steepening(sizes.sauter_diameter, length) - real
    if more > _TOLD_APART:
        largest = 1 + (sizes.coarse_graining - 1) * _TOLD_APART / more
        yield (
            "end_caps",
            messages.COARSE_CAPS(
                factor=sizes.coarse_graining,
                more=more,
                told=_TOLD_APART,
                largest=number(largest, 2),
            ),
        )


def steepening(diameter: float, length: float) -> float:
    """Return how many degrees end caps add to the dynamic angle.

    Parameters
    ----------
    diameter : float
        Of the simulated particles, m.
    length : float
        Of the drum, between its caps, m.

    Examples
    --------
    >>> steepening(0.01, 0.06)
    3.33...
    """
    return _STEEPENED * diameter / length
