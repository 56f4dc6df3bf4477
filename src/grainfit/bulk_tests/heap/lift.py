"""A check of the lift: one that is not slow is a collapse."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.heap import messages
from grainfit.checks import Found, check

#: Lift speed over sqrt(g d) above which the column collapses beside the cylinder. Beads of 10 mm
#: make heaps of 22 degrees at 0.16, of 19 degrees at 0.32 and of 15 degrees at 3.2.
_FASTEST = 0.4


@check("fast-lift", "warning")
def fast_lift(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Lifts so fast that the column collapses."""
    setup = checked.test.setup
    natural = math.sqrt(setup.gravity * setup.d)
    speed = setup.lift_speed / natural
    if speed > _FASTEST:
        yield (
            "lift_speed",
            messages.FAST_LIFT(
                lift_speed=setup.lift_speed,
                speed=speed,
                fastest=_FASTEST,
                usual=setup.usual_lift_speed,
            ),
        )
