"""A check of the height of the funnel: a measured heap may reach its outlet."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.funnel import messages
from grainfit.bulk_tests.funnel.setup import cone_height
from grainfit.checks import Found, check
from grainfit.formatting import millimetres

_STEEPEST = 90.0


@check("funnel-in-heap", "warning")
def funnel_in_heap(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Funnels so low that the measured heap grows into them."""
    setup, diameter = checked.test.setup, checked.test.sizes.sauter_diameter
    angle, apex = (checked.targets.get(name) for name in ("angle_of_repose", "heap_height"))
    if apex is None and angle is not None and 0 < angle < _STEEPEST:
        apex = cone_height(setup.heap_volume, angle)
        if setup.is_disc:
            apex = min(apex, setup.plate_radius * math.tan(math.radians(angle)))
    if apex is not None and setup.raise_speed == 0 and apex > setup.funnel_height - diameter:
        yield (
            "funnel_height",
            messages.FUNNEL_IN_HEAP(
                apex=millimetres(apex),
                height=millimetres(setup.funnel_height),
                least=millimetres(apex + 2 * diameter),
            ),
        )
