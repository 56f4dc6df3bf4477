"""A check of the speed of a drum: beyond the rolling regime its surface has no one angle."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.drum import messages
from grainfit.checks import Found, check

#: Froude number from which beds cascade (Mellmann, Powder Technology 118, 2001: rolling from 1e-4
#: to 1e-2, cascading up to 1e-1, cataracting above).
_FASTEST_ROLLING = 0.02


@check("fast-drum", "warning")
def fast_drum(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Drums beyond the rolling regime, whose surface is bent."""
    froude = checked.test.setup.speed_as_froude_number
    if froude > _FASTEST_ROLLING:
        yield (
            "rotational_speed" if checked.test.froude_number is None else "froude_number",
            messages.FAST_DRUM(froude=froude, fastest=_FASTEST_ROLLING),
        )
