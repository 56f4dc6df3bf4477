"""Cylinders that are narrow for their particles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.shared import messages
from grainfit.checks import Found, check
from grainfit.formatting import millimetres

#: Radius below which walls decide the bed, in Sauter diameters of the simulated particles.
_LEAST = 5.0
_ROUNDING = 1e-9


@check("narrow-cylinder", "warning")
def narrow_cylinder(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Cylinders narrower than five particle diameters in radius."""
    test = checked.test
    diameter = test.sizes.sauter_diameter
    radius = test.setup.cylinder_radius
    if radius < _LEAST * diameter * (1 - _ROUNDING):
        yield (
            "cylinder_radius",
            messages.NARROW_CYLINDER(
                radius=radius / diameter,
                least=_LEAST,
                option="cylinder_radius",
                usual=millimetres(_LEAST * diameter),
            ),
        )
